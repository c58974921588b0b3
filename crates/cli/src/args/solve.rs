//! The flags of commands that make a rig, or look at what it is made of.

use super::pack::PACKED_WITHIN;
use super::values::{Elsewhere, Json, parse_millimetres};
use std::path::PathBuf;

/// `rhytid solve`
#[derive(Debug, clap::Args)]
pub(crate) struct Solve {
    /// The project file.
    #[arg(value_name = "FACE.toml")]
    pub project: PathBuf,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    /// The rig file to write [default: beside the project file, under its name with .safetensors].
    #[arg(short, long, value_name = "FACE.safetensors")]
    pub output: Option<PathBuf>,

    /// Also write a packed rig, to send it, as `pack` does.
    #[arg(long, value_name = "SMALL.safetensors")]
    pub pack: Option<PathBuf>,

    /// How far a vertex of the packed rig may be off, in millimetres.
    #[arg(long, value_name = "MM", requires = "pack", default_value_t = PACKED_WITHIN, value_parser = parse_millimetres)]
    pub max_error: f64,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid doctor`
#[derive(Debug, clap::Args)]
pub(crate) struct Doctor {
    /// The project file.
    #[arg(value_name = "FACE.toml")]
    pub project: PathBuf,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid demo`
#[derive(Debug, clap::Args)]
pub(crate) struct Demo {
    /// The folder to write to; made if it does not exist, the demo's own files in it are replaced.
    #[arg(default_value = "rhytid-demo")]
    pub dir: PathBuf,

    /// About how many vertices the face has, 2,000 to 4,000,000.
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(2_000..=4_000_000))]
    pub vertices: u32,

    #[command(flatten)]
    pub json: Json,
}
