//! `rhytid pack`

use super::placing::TakeReading;
use super::values::{Json, parse_millimetres};
use std::path::PathBuf;

/// How far a vertex of a packed rig may be off, in millimetres.
pub(super) const PACKED_WITHIN: f64 = 0.05;

/// `rhytid pack`
#[derive(Debug, clap::Args)]
pub(crate) struct Pack {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// A take, as for `animate`, whose frames count as the examples do.
    pub take: Option<PathBuf>,

    /// The packed rig file to write.
    #[arg(short, long, value_name = "SMALL.safetensors")]
    pub output: PathBuf,

    /// How far a vertex may be from where the rig has it, in millimetres.
    #[arg(long, value_name = "MM", default_value_t = PACKED_WITHIN, value_parser = parse_millimetres)]
    pub max_error: f64,

    #[command(flatten)]
    pub reading: TakeReading,

    #[command(flatten)]
    pub json: Json,
}
