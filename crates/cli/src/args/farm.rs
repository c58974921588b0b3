//! `rhytid farm`: many takes on many machines.

use super::values::{Json, parse_rate};
use super::{DEVICE, GLOBAL, INPUT, OUTPUT};
use clap::ValueEnum;
use std::path::PathBuf;

/// Headings of options.
const JOB: &str = "Job";

/// `rhytid farm`
#[derive(Debug, clap::Args)]
pub(crate) struct Farm {
    /// The takes, as for `animate`. Without a take, the job that DIR holds.
    #[arg(value_name = "TAKE", requires = "rig")]
    pub takes: Vec<PathBuf>,

    /// The rig that plays all takes.
    #[arg(long, value_name = "RIG", requires = "takes", help_heading = INPUT)]
    pub rig: Option<PathBuf>,

    /// The job's folder; made if it does not exist.
    ///
    /// It gets the job and, when the job runs, the animations.
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: PathBuf,

    /// What to write of each take: usd, usdc, usda, usdz, glb or gltf.
    ///
    /// Only usd, usdc and usda can be written in parts. Any other kind is one task for each take.
    #[arg(long, value_name = "KIND", default_value = "usd", requires = "takes", help_heading = OUTPUT)]
    pub kind: String,

    /// Options of `animate` for all takes, in quotes: --animate "--velocities --fps 24".
    #[arg(
        long,
        value_name = "OPTIONS",
        default_value = "",
        hide_default_value = true,
        allow_hyphen_values = true,
        requires = "takes",
        help_heading = OUTPUT
    )]
    pub animate: String,

    /// Pixels of the films for review, or none.
    #[arg(long, value_name = "WxH|none", default_value = "360x480", value_parser = parse_film, requires = "takes", help_heading = OUTPUT)]
    pub film: FilmChoice,

    /// Frames per second of the films [default: those of the animation].
    ///
    /// A film takes as long as it has frames: with --film-fps 15, a quarter of 60.
    #[arg(long, value_name = "N", value_parser = parse_rate, requires = "takes", help_heading = OUTPUT)]
    pub film_fps: Option<f64>,

    /// Minutes that a chunk should take on a machine like this one, by a measurement.
    #[arg(long, value_name = "N", default_value_t = 10.0, value_parser = parse_minutes, requires = "takes", help_heading = JOB)]
    pub minutes: f64,

    /// Frames of a chunk, in place of a measurement.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), requires = "takes", conflicts_with = "minutes", help_heading = JOB)]
    pub chunk: Option<u32>,

    /// Run the job on this machine with openjd, N tasks at a time.
    ///
    /// `pip install openjd-cli` installs openjd. What is done is left, so that the same command continues a
    /// job that stopped.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = JOB)]
    pub local: Option<u16>,

    /// The device of all machines, as `rhytid devices` names it.
    ///
    /// Devices agree to within rounding. With cpu:0, every machine writes the same bytes.
    #[arg(long, default_value = "cpu:0", requires = "takes", help_heading = DEVICE)]
    pub device: String,

    #[command(flatten)]
    pub json: Json,
}

/// `rhytid farm-task`
#[derive(Debug, clap::Args)]
pub(crate) struct FarmTask {
    /// What to do.
    pub step: StepName,

    /// Its number in the job, counted from 0: of the chunk for animate, else of the take.
    pub number: usize,

    /// The job that `rhytid farm` wrote.
    #[arg(long, value_name = "job.json", help_heading = INPUT)]
    pub job: PathBuf,

    /// The rig [default: where the job has it].
    #[arg(long, value_name = "RIG", help_heading = INPUT)]
    pub rig: Option<PathBuf>,

    /// The folder of the takes [default: where the job has it].
    #[arg(long, value_name = "FOLDER", help_heading = INPUT)]
    pub takes: Option<PathBuf>,

    /// The folder to write to [default: the job's].
    #[arg(short, long, value_name = "DIR", help_heading = OUTPUT)]
    pub output: Option<PathBuf>,

    /// The device to evaluate on, as `rhytid devices` names it [default: the job's].
    #[arg(long, help_heading = DEVICE)]
    pub device: Option<String>,

    /// Do it again, although it is done.
    #[arg(long, help_heading = GLOBAL)]
    pub again: bool,
}

/// The steps of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StepName {
    /// Write a chunk of a take, and compare it with a fresh evaluation.
    Animate,
    /// Put the parts of a take together.
    Stitch,
    /// Draw a take as a film.
    Film,
}

impl StepName {
    /// Its word on the command line.
    pub(crate) fn word(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}

/// `--film`
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum FilmChoice {
    /// No films.
    None,
    /// Films of this size, as `render --size` has it.
    Size(String),
}

fn parse_film(text: &str) -> Result<FilmChoice, String> {
    let is_side = |side: &str| side.parse::<u32>().is_ok_and(|n| n > 0);
    match text.split_once('x') {
        None if text == "none" => Ok(FilmChoice::None),
        Some((width, height)) if is_side(width) && is_side(height) => Ok(FilmChoice::Size(text.to_owned())),
        _ => Err("expected none, or a width and a height in pixels, such as 360x480".to_owned()),
    }
}

fn parse_minutes(text: &str) -> Result<f64, String> {
    let minutes = text.parse().ok().filter(|minutes| (0.01..=10_000.0).contains(minutes));
    minutes.ok_or_else(|| "expected minutes, from 0.01 to 10000".to_owned())
}
