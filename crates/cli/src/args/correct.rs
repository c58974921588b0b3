//! `rhytid correct`

use super::placing::TakeReading;
use super::values::Json;
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

    #[command(flatten)]
    pub reading: TakeReading,

    #[command(flatten)]
    pub json: Json,
}
