//! The help of the program: commands in groups, and pages by their addresses.

use super::Args;
use clap::CommandFactory;
use clap::builder::{Resettable, StyledStr};

/// The groups of commands, each with its first command. The commands have the order of [`super::Command`].
const GROUPS: [(&str, &str); 6] = [
    ("Look first", "demo"),
    ("Make a face and its animation", "solve"),
    ("Prepare and change", "handles"),
    ("Judge", "doctor"),
    ("Choose a device", "devices"),
    ("Set up your shell", "completions"),
];

/// The pages of the documentation, for users who have the program alone.
pub(crate) const DOCS: &str = concat!(env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/");

/// The definition of the command line, with commands in groups and pages by their addresses.
pub(crate) fn command() -> clap::Command {
    let command = with_addresses(Args::command());
    let heading = *command.get_styles().get_header();
    let groups = groups(&command);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}\
         {heading}Options:{heading:#}\n{{options}}{{after-help}}"
    ))
}

/// The commands in their groups, a line for each.
fn groups(command: &clap::Command) -> String {
    let (heading, literal) = (*command.get_styles().get_header(), *command.get_styles().get_literal());
    let mut text = String::new();
    for command in command.get_subcommands().filter(|command| !command.is_hide_set()) {
        let name = command.get_name();
        if let Some((group, _)) = GROUPS.iter().find(|(_, first)| *first == name) {
            let gap = if text.is_empty() { "" } else { "\n" };
            text += &format!("{gap}{heading}{group}:{heading:#}\n");
        }
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        text += &format!("  {literal}{name:<14}{literal:#}{about}\n");
    }
    text + &format!("  {literal}{:<14}{literal:#}Print the help of a command\n\n", "help")
}

/// The command with the addresses of pages that its help names.
fn with_addresses(command: clap::Command) -> clap::Command {
    let address = |text: &StyledStr| StyledStr::from(text.to_string().replace("docs/", DOCS));
    let addresses = |text: Option<&StyledStr>| Resettable::from(text.map(address));
    let about = addresses(command.get_about());
    let long_about = addresses(command.get_long_about());
    let after_help = addresses(command.get_after_help());
    command
        .about(about)
        .long_about(long_about)
        .after_help(after_help)
        .mut_args(|arg| {
            let (help, long_help) = (addresses(arg.get_help()), addresses(arg.get_long_help()));
            arg.help(help).long_help(long_help)
        })
        .mut_subcommands(with_addresses)
}

#[cfg(test)]
mod tests {
    use super::super::SPACE;
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        command().debug_assert();
    }

    #[test]
    fn every_group_begins_with_a_command() {
        let help = command().render_help().to_string();
        for (group, first) in GROUPS {
            assert!(help.contains(&format!("{group}:\n  {first}")), "{help}");
        }
    }

    /// A screen has 50 lines of 100 characters.
    #[test]
    fn summaries_fit_two_screens() {
        for command in command().term_width(100).get_subcommands_mut() {
            let help = command.render_help().to_string();
            assert!(help.lines().count() <= 100, "{}: {} lines", command.get_name(), help.lines().count());
            let longest = help.lines().map(|line| line.chars().count()).max();
            assert!(longest <= Some(100), "{help}");
        }
    }

    #[test]
    fn the_space_of_a_take_has_its_own_heading() {
        let mut command = command();
        command.build();
        for command in command.get_subcommands() {
            let under = command.get_opts().filter(|option| option.get_help_heading() == Some(SPACE));
            let under: Vec<&str> = under.map(|option| option.get_id().as_str()).collect();
            assert!(under.is_empty() || under == ["take_unit", "take_axes", "take_rate"], "{under:?}");
        }
    }

    #[test]
    fn help_names_pages_by_their_addresses() {
        let mut command = command();
        let mut help = command.render_long_help().to_string();
        for command in command.get_subcommands_mut() {
            help += &command.render_long_help().to_string();
        }
        assert!(help.matches(".md").count() > 10);
        for (at, _) in help.match_indices("docs/") {
            assert!(help[..at].ends_with("/blob/main/"), "{}", &help[at..at + 20]);
        }
    }

    #[test]
    fn every_command_has_an_example() {
        for command in command().get_subcommands().filter(|command| !command.is_hide_set()) {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let example = format!("  rhytid {}", command.get_name());
            assert!(help.contains(&example), "{}: {help}", command.get_name());
        }
    }
}
