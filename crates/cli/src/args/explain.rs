//! `rhytid explain`

use super::placing::TakeReading;
use super::values::Json;
use std::path::PathBuf;

/// `rhytid explain`
#[derive(Debug, clap::Args)]
pub(crate) struct Explain {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// The take, as for `animate`.
    pub take: PathBuf,

    /// The frame of the take, counted from 0.
    #[arg(long, value_name = "N")]
    pub frame: usize,

    /// The vertices, counted from 0: as many as are named.
    #[arg(long, value_name = "V", value_delimiter = ',', required = true)]
    pub vertex: Vec<usize>,

    #[command(flatten)]
    pub json: Json,

    #[command(flatten)]
    pub reading: TakeReading,
}
