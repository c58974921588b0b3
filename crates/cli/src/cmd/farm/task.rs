//! `rhytid farm-task`: one task of a job, as a scheduler starts it.

use super::job::{self, Job, Places};
use super::record::Target;
use crate::args::{Animate, Command, FarmTask, StepName};
use crate::cmd::{animate, verify as verify_command};
use crate::progress::Ui;
use crate::scheduler::Scheduler;
use crate::{call, exit, exit_code, output};
use rhytid::core::{human, rig_file};
use rhytid::formats::{Reach, animation, usd};
use rhytid::{DeviceErrorKind, Error, Result};
use serde_json::Value;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The steps of the work with their shares of its time.
const SHARES: [(&str, f64); 2] = [("animate", 0.6), ("verify", 0.4)];
const FILM_SHARES: [(&str, f64); 1] = [("render", 1.0)];

/// Missing parts that a sentence names.
const NAMED: usize = 3;

/// Does the task, and says how far it is. Returns the exit code.
///
/// # Errors
/// [`Error::Input`] for inputs that are others than the job was written for, and for parts that are missing.
/// As `animate`, `verify`, `stitch` and `render`.
pub(super) fn run(args: &FarmTask, ui: &Ui) -> Result<u8> {
    ui.tell(Scheduler::new(if args.step == StepName::Film { &FILM_SHARES } else { &SHARES }));
    match task(args, ui) {
        Ok(words) => {
            output::say(&words)?;
            Ok(exit_code::DONE)
        }
        Err(error) => {
            Scheduler::fail(&exit::sentence(&error));
            Err(error)
        }
    }
}

/// Does the task. Returns what it did.
fn task(args: &FarmTask, ui: &Ui) -> Result<String> {
    let job = Job::read(&args.job)?;
    let own = job.places(args.job.parent().unwrap_or(Path::new("")));
    let places = Places {
        rig: args.rig.clone().unwrap_or(own.rig),
        takes: args.takes.clone().unwrap_or(own.takes),
        output: args.output.clone().unwrap_or(own.output),
    };
    let count = if args.step == StepName::Animate { job.chunks.len() } else { job.takes.len() };
    if args.number >= count {
        return Err(Error::out_of_range(format!(
            "{}: has {count} tasks of the step {}, counted from 0, found the number {}",
            args.job.display(),
            args.step.word(),
            args.number
        )));
    }
    let target = Target::of(&job, args.step, args.number);
    if !args.again && target.done(&places.output).is_some() {
        return Ok(format!("{}: is there already; --again writes it again", target.file));
    }
    let device = args.device.as_deref().unwrap_or(&job.device);
    let task = Task { job: &job, places: &places, target, device, args, ui };
    let start = Instant::now();
    let done = match args.step {
        StepName::Animate => task.animate()?,
        StepName::Stitch => task.stitch()?,
        StepName::Film => task.film()?,
    };
    task.keep(done, start.elapsed())
}

struct Task<'a> {
    job: &'a Job,
    places: &'a Places,
    target: Target,
    device: &'a str,
    args: &'a FarmTask,
    ui: &'a Ui,
}

/// What a task did.
struct Done {
    frames: usize,
    verified: Value,
}

impl Task<'_> {
    /// Writes a chunk and compares it with a fresh evaluation.
    fn animate(&self) -> Result<Done> {
        let chunk = &self.job.chunks[self.args.number];
        let options = self.options(&format!("{}..{}", chunk.first, chunk.end))?;
        self.check_inputs(&options)?;
        self.target.begin(&self.places.output)?;
        animate::animate(&options, self.ui)?;
        let verified = verify(&options, self.ui)?;
        Ok(Done { frames: chunk.end - chunk.first, verified })
    }

    /// Puts the parts of a take together.
    fn stitch(&self) -> Result<Done> {
        let Self { job, places, args: task, .. } = self;
        let output = places.output.join(&self.target.file);
        let mut parts: Vec<PathBuf> = Vec::new();
        let mut missing = Vec::new();
        for (number, _) in job.chunks_of(task.number) {
            let part = Target::of(job, StepName::Animate, number);
            match part.done(&places.output) {
                Some(_) => parts.push(places.output.join(&part.file)),
                None => missing.push((number, part.file)),
            }
        }
        if let Some((number, _)) = missing.first() {
            let named: Vec<&str> = missing.iter().take(NAMED).map(|(_, file)| file.as_str()).collect();
            let others = if missing.len() > NAMED { " and others" } else { "" };
            return Err(Error::input(format!(
                "{}: {} of {} parts are missing: {}{others}; write them first, as with `rhytid farm-task animate \
                 {number} --job {}`",
                output.display(),
                missing.len(),
                missing.len() + parts.len(),
                named.join(", "),
                output::word(&task.job)
            )));
        }
        self.target.begin(&places.output)?;
        let stitched = usd::stitch(&parts, &output)?;
        // As others read it: with its manifest and its parts.
        let summary = animation::open_within(&output, Reach::Below)?.summary().clone();
        if summary.frames != stitched.frames {
            return Err(Error::Internal(format!("{}: has {} frames", output.display(), summary.frames)));
        }
        Ok(Done { frames: stitched.frames, verified: Value::Null })
    }

    /// Draws a take.
    #[cfg(feature = "wgpu")]
    fn film(&self) -> Result<Done> {
        let Self { job, places, args: task, ui, target, device } = self;
        let Some(film) = &job.film else {
            return Err(Error::input(format!(
                "{}: the job has no films; write it again without `--film none`",
                task.job.display()
            )));
        };
        let options = self.options("..")?;
        self.check_inputs(&options)?;
        target.begin(&places.output)?;
        let mut line: Vec<OsString> = vec!["render".into(), options.rig.clone().into()];
        line.extend([options.takes[0].clone().into(), "-o".into(), places.output.join(&target.file).into()]);
        line.extend(["--size", &film.size, "--device", device].map(OsString::from));
        let mut args = call::parse_render(line)?;
        args.fps = film.fps.or(options.fps);
        args.reading = options.reading.clone();
        args.reading.shapes.retain(|choice| matches!(choice, crate::args::ShapesChoice::Of(_)));
        args.fine_detail = options.fine_detail.clone();
        let drawn = crate::cmd::render::draw(&args, ui)?;
        Ok(Done { frames: drawn.pictures, verified: Value::Null })
    }

    #[cfg(not(feature = "wgpu"))]
    fn film(&self) -> Result<Done> {
        Err(Error::input(
            "this build draws no films (the feature wgpu is off); write the job with `--film none`",
        ))
    }

    /// The options of `animate` for the target's take.
    fn options(&self, frames: &str) -> Result<Box<Animate>> {
        let Self { job, places, target, device, .. } = self;
        // A film has the options of the animation.
        let file = Path::new(&target.file).with_extension(&job.kind);
        job.animate(places, target.take, &places.output.join(file), frames, device)
    }

    /// Keeps that the task is done. Returns what it did, in words.
    fn keep(&self, done: Done, time: Duration) -> Result<String> {
        let output = &self.places.output;
        let record = self.target.finish(output, done.frames, time.as_secs_f64(), done.verified)?;
        Ok(format!(
            "{}: {}, {}, in {}",
            output.join(&self.target.file).display(),
            human::counted(record.frames, "frame"),
            human::bytes(record.bytes),
            human::duration(time)
        ))
    }

    /// The inputs must be those that the job was written for, on every machine.
    fn check_inputs(&self, options: &Animate) -> Result<()> {
        let Self { job, args: task, target, .. } = self;
        let take = &job.takes[target.take];
        let changed = |file: &Path, what: &str| {
            Err(Error::input(format!(
                "{}: is {what} than {} was written for; give the file of that time, or write the job again with \
                 `rhytid farm`",
                file.display(),
                task.job.display()
            )))
        };
        let rig = rig_file::hash(&options.rig)?;
        if rig != job.rig.hash {
            return changed(&options.rig, "another rig");
        }
        let file = &options.takes[0];
        let hash = rig_file::hash(file)?;
        if hash != take.hash {
            return changed(file, "another take");
        }
        if job::made_from(options, job, &hash)? != take.made_from {
            return Err(Error::input(format!(
                "{}: a setup or shapes that the options name are others than {} was written for; write the job \
                 again with `rhytid farm`",
                self.places.takes.display(),
                task.job.display()
            )));
        }
        Ok(())
    }
}

/// Compares a file that these options wrote with a fresh evaluation. Returns what `verify --json` prints.
///
/// # Errors
/// [`Error::Device`] for a file that is not as it should be. It is removed, so that the next try writes it
/// again. As `verify`.
pub(super) fn verify(options: &Animate, ui: &Ui) -> Result<Value> {
    let file = &options.output;
    let mut line: Vec<OsString> = vec!["verify".into(), file.into(), "--json".into()];
    line.extend(["--rig".into(), options.rig.clone().into(), "--take".into(), (&options.takes[0]).into()]);
    line.extend(["--device".into(), OsString::from(&options.device)]);
    let Command::Verify(mut args) = call::parse(line)?.command else {
        return Err(Error::Internal("the words are another command".into()));
    };
    args.setup.clone_from(&options.reading.setup);
    args.shapes = options.reading.shapes_of_curves().map(Path::to_owned);
    args.elsewhere = options.reading.elsewhere;
    args.space = options.reading.space.clone();
    let mut code = exit_code::DONE;
    let printed = output::captured(|| {
        code = verify_command::run(&args, ui)?;
        Ok(())
    })?;
    let found: Value = serde_json::from_str(&printed).map_err(|error| Error::Internal(error.to_string()))?;
    if code == exit_code::DONE {
        return Ok(found);
    }
    fs::remove_file(file).map_err(Error::io(file))?;
    Err(Error::Device {
        kind: DeviceErrorKind::Driver,
        device: options.device.clone(),
        message: format!(
            "{}: was not what the rig and the take give, {} mm off at worst, and is removed; run the task again, on \
             another machine if it happens twice",
            file.display(),
            found["worst_mm"]
        ),
    })
}
