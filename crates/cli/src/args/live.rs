//! The arguments of commands that send or receive frames while they are captured.

use super::LIVE;
use super::values::{Json, parse_rate};
use rhytid::playback::FrameRange;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// `rhytid animate --listen`
#[derive(Debug, Clone, Default, clap::Args)]
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
        conflicts_with_all = ["take", "setup", "missing", "take_unit", "take_axes", "take_rate"]
    )]
    pub listen: Option<SocketAddr>,

    /// With --listen: also write the received frames as a take.
    #[arg(long, value_name = "TAKE.csv", requires = "listen", help_heading = LIVE)]
    pub record: Option<PathBuf>,

    /// With --listen: how long to wait for a frame [default: 30].
    ///
    /// After this time without a frame the recording ends. Without any frame, that is an error.
    #[arg(long, value_name = "SECONDS", requires = "listen", value_parser = parse_seconds, help_heading = LIVE)]
    pub timeout: Option<Duration>,
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
