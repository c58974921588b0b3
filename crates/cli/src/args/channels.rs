//! An option for each kind of channels that frames can have. The options follow from the list of kinds: a new
//! kind needs no line here.

use super::{OUTPUT, USD};
use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};
use rhytid::core::ChannelKind;
use rhytid::formats::animation::Format;
use rhytid::formats::export::ChannelChoice;

/// `--no-normals`, `--velocities` and so on.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Channels(pub ChannelChoice);

/// The option of a kind. A kind that frames have by default has an option that leaves it out.
pub(crate) fn option(kind: ChannelKind) -> String {
    if kind.is_default() { format!("no-{kind}") } else { kind.name().to_owned() }
}

/// The formats that have a place for a kind, as messages call them.
pub(crate) fn formats(kind: ChannelKind) -> &'static str {
    if Format::Glb.carries(kind) { "USD and glTF" } else { "USD (.usd, .usda or .usdz)" }
}

fn argument(kind: ChannelKind) -> Arg {
    let verb = if kind.is_default() { "Leave" } else { "Write" };
    let help = format!("{verb} {}", kind.description());
    Arg::new(option(kind))
        .long(option(kind))
        .long_help(format!("{help}.\n\n{}", kind.details()))
        .help(help)
        .help_heading(if Format::Glb.carries(kind) { OUTPUT } else { USD })
        .action(ArgAction::SetTrue)
}

impl clap::Args for Channels {
    fn augment_args(command: Command) -> Command {
        ChannelKind::ALL.into_iter().fold(command, |command, kind| command.arg(argument(kind)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Channels {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut channels = Self::default();
        channels.update_from_arg_matches(matches)?;
        Ok(channels)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for kind in ChannelKind::ALL {
            if matches.get_flag(&option(kind)) {
                self.0.set(kind, !kind.is_default());
            }
        }
        Ok(())
    }
}
