//! `rhytid farm`: many takes on many machines.

mod disk;
mod job;
mod local;
mod record;
mod slurm;
mod speed;
mod status;
mod task;
mod template;
mod words;
mod write;

use crate::progress::Ui;
use crate::{args, exit_code, output};
use job::{JOB, Job};
use rhytid::core::human;
use rhytid::{Error, Result};
use serde::Serialize;
use speed::Speed;
use status::StepStatus;
use std::path::{Path, PathBuf};
use std::time::Duration;
use template::TEMPLATE;

/// A take for which no chunk was made.
#[derive(Debug, Serialize)]
struct Failed {
    take: PathBuf,
    error: String,
}

/// The JSON that is printed.
#[derive(Serialize)]
struct Summary<'a> {
    job: PathBuf,
    template: PathBuf,
    slurm: PathBuf,
    takes: usize,
    frames: usize,
    chunks: usize,
    /// The frames of a chunk. None where takes are not cut, or where the job was written before.
    frames_of_chunk: Option<usize>,
    /// None without a measurement.
    speed: Option<Speed>,
    /// Takes that are not in the job.
    failed: &'a [Failed],
    /// How far each step is.
    steps: Vec<StepStatus>,
    /// The sentences of tasks that failed now.
    failures: Vec<String>,
}

/// A job and what is known of it.
struct Written {
    job: Job,
    failed: Vec<Failed>,
    frames_of_chunk: Option<usize>,
    speed: Option<Speed>,
}

/// Writes a job or finds it, runs it if that is wanted, and says how far it is. Returns the exit code.
///
/// # Errors
/// As [`write::write`], [`Job::read`] and [`local::run`].
pub(super) fn run(args: &args::Farm, ui: &Ui) -> Result<u8> {
    let folder = &args.output;
    let written = match args.takes.is_empty() {
        true => found(folder)?,
        false => write::write(args, ui)?,
    };
    let failures = match args.local {
        Some(at_once) => local::run(&written.job, folder, at_once, ui)?,
        None => Vec::new(),
    };
    ui.clear();
    let summary = Summary {
        job: folder.join(JOB),
        template: folder.join(TEMPLATE),
        slurm: folder.join(slurm::SCRIPT),
        takes: written.job.takes.len(),
        frames: written.job.takes.iter().map(|take| take.frames).sum(),
        chunks: written.job.chunks.len(),
        frames_of_chunk: written.frames_of_chunk,
        speed: written.speed,
        failed: &written.failed,
        steps: status::of_steps(&written.job, folder),
        failures,
    };
    output::done(args.json, ui, &summary, || words(&summary, &written, folder))?;
    let is_right = summary.failed.is_empty() && summary.failures.is_empty();
    Ok(if is_right { exit_code::DONE } else { exit_code::USER })
}

/// Does a task of a job. Returns the exit code.
///
/// # Errors
/// As [`task::run`].
pub(super) fn task(args: &args::FarmTask, ui: &Ui) -> Result<u8> {
    task::run(args, ui)
}

/// The job that a folder holds.
fn found(folder: &Path) -> Result<Written> {
    let path = folder.join(JOB);
    if !path.exists() {
        return Err(Error::input(format!(
            "{}: holds no job; write one with `rhytid farm TAKE… --rig RIG -o {}`",
            folder.display(),
            output::word(folder)
        )));
    }
    Ok(Written { job: Job::read(&path)?, failed: Vec::new(), frames_of_chunk: None, speed: None })
}

/// The job in words.
fn words(summary: &Summary<'_>, written: &Written, folder: &Path) -> String {
    let mut text = format!(
        "{}: {}, {}, {}",
        folder.display(),
        human::counted(summary.takes, "take"),
        human::counted(summary.frames, "frame"),
        human::counted(summary.chunks, "chunk")
    );
    if let Some(frames) = summary.frames_of_chunk {
        text += &format!(" of at most {}", human::counted(frames, "frame"));
    }
    if let Some(speed) = &summary.speed {
        text += &measured(speed, summary.frames, summary.chunks);
    }
    text += "\n";
    text += &status::words(&summary.steps);
    if !summary.failed.is_empty() {
        text += &format!("\n{} left out; the errors say why", human::counted(summary.failed.len(), "take"));
    }
    if summary.steps.iter().all(|step| step.done == step.tasks) {
        return text;
    }
    let there = output::word(folder);
    let places = written.job.places(folder);
    let whole = |path: &PathBuf| path.canonicalize().unwrap_or_else(|_| path.clone());
    let [rig, takes] = [&places.rig, &places.takes].map(|path| output::word(&whole(path)));
    text + &output::next(&[
        format!("rhytid farm -o {there} --local 2    # here"),
        format!("sh {}    # with Slurm", output::word(&folder.join(slurm::SCRIPT))),
        format!("deadline bundle submit {there} -p Rig={rig} -p Takes={takes}"),
    ])
}

/// What was measured, in words.
fn measured(speed: &Speed, frames: usize, chunks: usize) -> String {
    let seconds = speed.frame_seconds * frames as f64 + speed.start_seconds * chunks as f64;
    format!(
        "\n{:.4} s a frame here, and {:.1} s to start a chunk: {} on a machine like this one, and {} of animation",
        speed.frame_seconds,
        speed.start_seconds,
        time(seconds),
        human::bytes((speed.frame_bytes * frames as f64) as u64)
    )
}

/// A time that can be long.
fn time(seconds: f64) -> String {
    let hours = seconds / 3600.0;
    if hours < 2.0 { human::duration(Duration::from_secs_f64(seconds)) } else { format!("{hours:.0} hours") }
}
