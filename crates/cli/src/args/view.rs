//! `rhytid view`

use super::LIVE;
use super::live::{Sender, parse_address};
use std::net::SocketAddr;
use std::path::PathBuf;

/// `rhytid view`
#[derive(Debug, clap::Args)]
pub(crate) struct View {
    /// The rig file that `solve` wrote, or a mesh or an animation; without one the window is empty.
    pub rig: Option<PathBuf>,

    /// A take for it, as for `animate`.
    pub take: Option<PathBuf>,

    /// Edits of the take, as for `animate`.
    #[arg(long, value_name = "EDIT.toml", requires = "take")]
    pub edit: Option<PathBuf>,

    /// Numbers at the rig's vertices to show as heat maps: a PLY, as `transfer --report` writes it.
    #[arg(long, value_name = "NUMBERS.ply", requires = "rig")]
    pub numbers: Option<PathBuf>,

    /// Show frames as they arrive over the network, as OSC bundles; docs/live.md says what is sent.
    /// ADDR:PORT, or a port of this machine alone [default: 127.0.0.1:9000].
    #[arg(
        long,
        value_name = "ADDR:PORT",
        num_args = 0..=1,
        default_missing_value = "9000",
        value_parser = parse_address,
    )]
    pub listen: Option<SocketAddr>,

    #[command(flatten)]
    pub sender: Sender,

    /// With --world: actor and session, as for `prepare`.
    #[arg(long, value_name = "TAKE.toml", requires = "world", help_heading = LIVE)]
    pub setup: Option<PathBuf>,

    /// The device to evaluate on, as `rhytid devices` names it [default: the one that draws; where that is a
    /// software driver, cpu:0].
    #[arg(long)]
    pub device: Option<String>,

    /// The device to draw with, one of the backend wgpu [default: that of --device where it is one, else the
    /// first that draws into the window].
    #[arg(long)]
    pub draw_on: Option<String>,
}
