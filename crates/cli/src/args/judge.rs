//! The arguments of the commands that say how good a rig, a rig for a take, or a device is.

use super::Elsewhere;
use super::INPUT;
use super::placing::TakeReading;
use super::values::{Json, MethodChoice, MissingChoice, StorageChoice};
use std::path::PathBuf;

/// `rhytid evaluate`
#[derive(Debug, clap::Args)]
pub(crate) struct Evaluate {
    /// The project file.
    #[arg(value_name = "FACE.toml")]
    pub project: PathBuf,

    /// Dense meshes over time with the neutral's vertices, in head space. A USD or glTF animation, a .npy
    /// array of frames × vertices × 3, or a folder with a mesh for each frame.
    #[arg(long, requires = "take")]
    pub truth: Option<PathBuf>,

    /// The take that the truth belongs to, as for `animate`.
    #[arg(long, requires = "truth")]
    pub take: Option<PathBuf>,

    /// Which frames of the take the truth has: CSV with a column frame, counted from 0 [default: all].
    #[arg(long, value_name = "FRAMES.csv", requires = "truth")]
    pub truth_frames: Option<PathBuf>,

    /// Regions: the neutral as .obj with groups (“g NAME” before faces) [default: by the names of the
    /// handles].
    #[arg(long, value_name = "GROUPS.obj")]
    pub groups: Option<PathBuf>,

    /// What to do where a marker is missing from a frame.
    #[arg(long, value_enum, default_value_t = MissingChoice::Error, help_heading = INPUT)]
    pub missing: MissingChoice,

    /// For a raw take: what is known of the actor and the session, as for `prepare`.
    #[arg(long, value_name = "TAKE.toml", requires = "take", help_heading = INPUT)]
    pub setup: Option<PathBuf>,

    /// Take the noise of the markers out of the take first.
    #[arg(long, requires = "take", help_heading = INPUT)]
    pub soft_markers: bool,

    #[command(flatten)]
    pub elsewhere: Elsewhere,

    /// The folder to write evaluation.html, with maps drawn on the face, and evaluation.json to; made if it
    /// does not exist.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,

    /// The device to evaluate on, as `rhytid devices` names it; auto takes the fastest that conforms,
    /// software drivers last.
    #[arg(long, default_value = "auto")]
    pub device: String,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid coverage`
#[derive(Debug, clap::Args)]
pub(crate) struct Coverage {
    /// The rig file that `solve` wrote.
    pub rig: PathBuf,

    /// The take, as for `animate`.
    pub take: PathBuf,

    #[command(flatten)]
    pub reading: TakeReading,

    /// How many expressions and how many strain edges to list.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub top: u32,

    /// How many scans to plan [default: as many as --top].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub plan: Option<u32>,

    /// The frames that can be scanned: CSV with a column frame, counted from 0 [default: all whose markers
    /// were seen].
    #[arg(long, value_name = "FRAMES.csv")]
    pub candidates: Option<PathBuf>,

    /// The folder to write plan.html, with the planned frames drawn, and plan.json to; made if it does not
    /// exist.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,

    /// Dense meshes over time, a frame for each of the take or of --candidates, as for `evaluate --truth`:
    /// the planned scans are cut out of them.
    #[arg(long, value_name = "DENSE", requires = "output")]
    pub take_examples: Option<PathBuf>,

    /// The folder to write the examples to; made if it does not exist.
    #[arg(short, long, value_name = "DIR", requires = "take_examples")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid conform`
#[derive(Debug, clap::Args)]
pub(crate) struct Conform {
    /// The device to examine, as `rhytid devices` names it [default: all of them].
    #[arg(long)]
    pub device: Option<String>,

    /// The folder to write report.md, report.json and junit.xml to; made if it does not exist.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,

    /// A few small cases, in seconds.
    #[arg(long)]
    pub quick: bool,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid bench`
#[derive(Debug, clap::Args)]
pub(crate) struct Bench {
    /// The rig file that `solve` wrote [default: a rig made for it].
    pub rig: Option<PathBuf>,

    /// The device to measure, as `rhytid devices` names it, or all.
    #[arg(long, default_value = "cpu:0")]
    pub device: String,

    /// About how many vertices the generated rig has.
    #[arg(long, value_name = "N", default_value_t = 530_000, conflicts_with = "rig", value_parser = clap::value_parser!(u32).range(1_000..=4_000_000))]
    pub vertices: u32,

    /// The method of the generated rig.
    #[arg(long, value_enum, default_value_t = MethodChoice::Learned, conflicts_with = "rig")]
    pub method: MethodChoice,

    /// Frames in a batch.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub frames: u32,

    /// How the device keeps the basis.
    #[arg(long, value_enum, default_value_t = StorageChoice::F32)]
    pub storage: StorageChoice,

    /// Measure how a frame's time grows, too: with vertices, handles, examples and frames in a batch. Takes
    /// minutes.
    #[arg(long, conflicts_with = "rig")]
    pub growth: bool,

    /// The file to draw a chart to, as SVG.
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,

    #[command(flatten)]
    pub json: Json,
}
