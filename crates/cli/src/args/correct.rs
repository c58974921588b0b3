//! `rhytid correct`

use super::placing::TakeSpace;
use super::values::{Elsewhere, MissingChoice};
use std::path::PathBuf;

/// `rhytid correct`
#[derive(Debug, clap::Args)]
pub(crate) struct Correct {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// The take, as for `animate`.
    pub take: PathBuf,

    /// The frame of the take, counted from 0.
    #[arg(long, value_name = "N")]
    pub frame: usize,

    /// The mesh to write.
    #[arg(short, long, value_name = "POSE.obj")]
    pub output: PathBuf,

    /// Edits of the take, as for `animate`.
    #[arg(long, value_name = "EDIT.toml")]
    pub edit: Option<PathBuf>,

    /// What to do where a marker is missing from a frame.
    #[arg(long, value_enum, default_value_t = MissingChoice::Error)]
    pub missing: MissingChoice,

    /// For a raw take: what is known of the actor and the session, as for `prepare`.
    #[arg(long, value_name = "TAKE.toml")]
    pub setup: Option<PathBuf>,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    #[command(flatten)]
    pub space: TakeSpace,
}
