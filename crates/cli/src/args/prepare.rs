//! `rhytid prepare`

use super::setup::Setup;
use super::values::{Elsewhere, Json, parse_rate};
use std::path::PathBuf;

/// `rhytid prepare`
#[derive(Debug, clap::Args)]
pub(crate) struct Prepare {
    /// The raw take.
    pub raw: PathBuf,

    /// The rig file that `solve` wrote.
    #[arg(long)]
    pub rig: PathBuf,

    /// The clean take to write.
    #[arg(short, long, value_name = "TAKE.csv")]
    pub output: PathBuf,

    /// The folder to write report.html and report.json to; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,

    /// What is known of the actor and the session, as options of `prepare` in a TOML file; options given here
    /// win.
    #[arg(long, value_name = "TAKE.toml")]
    pub setup: Option<PathBuf>,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    /// Resample to N frames per second [default: the take's own rate].
    #[arg(long, value_name = "N", value_parser = parse_rate)]
    pub fps: Option<f64>,

    /// Write which marker belongs to which handle, and how surely: a table to edit and to give as --markers.
    #[arg(long, value_name = "TABLE.csv")]
    pub write_markers: Option<PathBuf>,

    /// The raw take is a take's CSV in world space, not head space. The head's motion is taken out of it.
    #[arg(long)]
    pub world: bool,

    #[command(flatten)]
    pub json: Json,

    // The heading is that of all options below.
    #[command(flatten, next_help_heading = "Setup, also as keys of TAKE.toml")]
    pub known: Setup,
}
