//! `rhytid lod`

use super::placing::TakeReading;
use super::values::Json;
use std::path::PathBuf;

/// `rhytid lod`
#[derive(Debug, clap::Args)]
pub(crate) struct Lod {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// A take, as for `animate`: what its frames do not need goes first.
    pub take: Option<PathBuf>,

    /// How many levels to make: a half of the triangles, a quarter, an eighth and so on.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=12))]
    pub levels: u32,

    /// The folder to write the levels to.
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,

    #[command(flatten)]
    pub reading: TakeReading,

    #[command(flatten)]
    pub json: Json,
}
