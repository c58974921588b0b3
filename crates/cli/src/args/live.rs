//! The arguments of commands that send or receive frames while they are captured.

use super::LIVE;
use super::setup::Setup;
use super::values::{Json, UnitChoice, parse_rate};
use rhytid::Error;
use rhytid::capture::Axes;
use rhytid::formats::Reach;
use rhytid::live::Pattern;
use rhytid::playback::{CleanUp, FrameRange};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

/// `rhytid animate --listen`
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Listen {
    /// Record --frames N from the network instead of TAKE.
    ///
    /// Frames come as OSC bundles; docs/live.md describes them. Give ADDR:PORT, or a port of this machine
    /// alone [default: 127.0.0.1:9000]. Ctrl-C ends the recording and keeps the received frames.
    #[arg(
        long,
        value_name = "ADDR:PORT",
        num_args = 0..=1,
        default_missing_value = "9000",
        value_parser = parse_address,
        help_heading = LIVE,
        conflicts_with_all = ["takes", "missing", "take_unit", "take_axes", "take_rate"]
    )]
    pub listen: Option<SocketAddr>,

    /// With --listen: also write the received frames as a take.
    #[arg(long, value_name = "TAKE.csv", requires = "listen", help_heading = LIVE)]
    pub record: Option<PathBuf>,

    /// With --listen: how long to wait for a frame [default: 30].
    ///
    /// After this time without a frame the recording ends. Without any frame, that is an error.
    #[arg(long, hide_short_help = true, value_name = "SECONDS", requires = "listen", value_parser = parse_seconds, help_heading = LIVE)]
    pub timeout: Option<Duration>,

    #[command(flatten)]
    pub sender: Sender,
}

/// What comes with `--listen`.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Sender {
    /// With --listen: the address of the messages with positions [default: /rhytid/handle].
    ///
    /// In /marker/{label} the label is in the address, and the arguments are X Y Z. In an address without
    /// {label}, such as /VMC/Ext/Tra/Pos, the arguments are LABEL X Y Z. Further arguments are ignored.
    #[arg(long, value_name = "ADDRESS", requires = "listen", help_heading = LIVE)]
    pub address: Option<Pattern>,

    /// With --listen: the positions are in world space. The head's motion is taken out, as `prepare` does it.
    #[arg(long, requires = "listen", help_heading = LIVE)]
    pub world: bool,

    /// With --world: the rigid markers [default: markers of no handle that keep their distances].
    #[arg(long, hide_short_help = true, value_name = "A,B,C", value_delimiter = ',', requires = "world", help_heading = LIVE)]
    pub rigid: Option<Vec<String>>,

    /// With --world: the unit of the positions [default: what fits the rig's size].
    #[arg(long, value_enum, requires = "world", help_heading = LIVE)]
    pub unit: Option<UnitChoice>,

    /// With --world: the axes that the mesh's x, y and z are, such as +x+z-y [default: those in which the
    /// actor looks where the rig looks].
    #[arg(long, hide_short_help = true, value_name = "AXES", allow_hyphen_values = true, requires = "world", help_heading = LIVE)]
    pub axes: Option<Axes>,

    /// With --world: the neutral frames A to B-1, counted from 0.
    #[arg(long, hide_short_help = true, value_name = "A..B", requires = "world", help_heading = LIVE)]
    pub neutral: Option<FrameRange>,
}

impl Sender {
    /// How positions in world space are cleaned: these options, else those of a setup. `None` for positions
    /// in head space.
    ///
    /// # Errors
    /// As [`Setup::read`] and [`Setup::clean_up`]; [`Error::Input`] if there is a setup for positions in head
    /// space.
    pub(crate) fn clean_up(&self, setup: Option<&Path>, reach: Reach) -> rhytid::Result<Option<CleanUp>> {
        if !self.world {
            return match setup {
                Some(_) => {
                    Err(Error::conflict("--setup with --listen is for --world; give both, or leave it out"))
                }
                None => Ok(None),
            };
        }
        let given = Setup {
            rigid: self.rigid.clone(),
            unit: self.unit,
            axes: self.axes,
            neutral: self.neutral,
            ..Setup::default()
        };
        let from_file = setup.map_or_else(|| Ok(Setup::default()), |path| Setup::read(path, reach))?;
        Ok(Some(CleanUp { world: true, ..given.or(from_file).clean_up()? }))
    }
}

/// `rhytid send`
#[derive(Debug, clap::Args)]
pub(crate) struct Send {
    /// The take: CSV with time,LABEL_x,LABEL_y,LABEL_z,… in mesh units and head space. A marker is not sent
    /// in frames where it is missing.
    pub take: PathBuf,

    /// Send only the handles of this rig, and no other markers of the take.
    #[arg(long)]
    pub rig: Option<PathBuf>,

    /// Where to: ADDR:PORT, or a port of this machine.
    #[arg(long, value_name = "ADDR:PORT", default_value = "127.0.0.1:9000", value_parser = parse_address)]
    pub to: SocketAddr,

    /// Send N of the take's frames a second [default: as far apart as its times].
    #[arg(long, value_name = "N", value_parser = parse_rate)]
    pub rate: Option<f64>,

    /// Start again at the end, until Ctrl-C.
    #[arg(long = "loop")]
    pub again: bool,

    /// The frames A to B-1 of the take, counted from 0; either end can be left out.
    #[arg(long, value_name = "A..B", default_value = "..", hide_default_value = true)]
    pub frames: FrameRange,

    #[command(flatten)]
    pub json: Json,
}

/// `--frames` of `animate`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FramesChoice {
    /// A range of the take's frames.
    Range(FrameRange),
    /// The number of frames to record with `--listen`.
    Count(usize),
}

impl FromStr for FramesChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(count) => Ok(Self::Count(count)),
            Err(_) => text.parse().map(Self::Range),
        }
    }
}

/// A port without an address is one of this machine, which no other machine reaches.
pub(super) fn parse_address(text: &str) -> Result<SocketAddr, String> {
    let port = || Ok(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), text.parse().map_err(drop)?));
    text.parse().map_err(drop).or_else(|()| port()).map_err(|()| {
        "expected an address and a port in numbers, such as 127.0.0.1:9000 or [::1]:9000, or a port alone"
            .to_owned()
    })
}

fn parse_seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.01..=86_400.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("expected seconds, from 0.01 to 86400".to_owned()),
    }
}
