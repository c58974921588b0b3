//! Writes a job: reads each take once, measures, and cuts the takes into chunks.

use super::job::{self, Chunk, Film, InputFile, JOB, Job, Places, Take, VERSION};
use super::speed::Speed;
use super::template::{TEMPLATE, template};
use super::{Failed, Written, disk, slurm, words};
use crate::args::{Animate, Farm, FilmChoice};
use crate::cmd::animate::{options, perform, take_name};
use crate::progress::Ui;
use crate::{exit, inputs, output};
use rhytid::core::rig_file;
use rhytid::formats::animation::Format;
use rhytid::formats::export::unique_names;
use rhytid::formats::refuse_inputs;
use rhytid::{Error, Progress, Result, Rig};
use std::fs;
use std::path::{Path, PathBuf};

/// Writes the job, its template and the script for Slurm.
///
/// # Errors
/// [`Error::Input`] for options that are for one take, for inputs without a shared folder, and if no take can
/// be played. As reading the rig, and as [`Speed::measure`].
pub(super) fn write(args: &Farm, ui: &Ui) -> Result<Written> {
    let Some(rig_path) = &args.rig else {
        return Err(Error::input("the takes need a rig; give it with --rig RIG"));
    };
    let kind = Path::new("x").with_extension(&args.kind);
    if let Format::Pc2 | Format::Csv = Format::from_extension(&kind)? {
        return Err(Error::unsupported_format(format!(
            "--kind {}: such a file does not say how it was made, so that no task can verify it; choose usd, usdc, \
             usda, usdz, glb or gltf",
            args.kind
        )));
    }
    if args.film == FilmChoice::None && args.film_fps.is_some() {
        return Err(Error::conflict(
            "--film-fps: there are no films with --film none; leave one of the two out",
        ));
    }
    let words = words::split(&args.animate)?;
    let folder = &args.output;
    let first = job::animate(
        rig_path,
        &args.takes[0],
        &folder.join(format!("x.{}", args.kind)),
        "..",
        &args.device,
        &words,
    )
    .map_err(|error| error.reworded(|said| format!("--animate {}: {said}", args.animate)))?;
    check(&first)?;
    inputs::named_device(&args.device)?;
    let files: Vec<PathBuf> =
        args.takes.iter().cloned().chain(words::files(&words).iter().map(PathBuf::from)).collect();
    let mut failed = Vec::new();
    let takes_folder = takes_folder(&files)?;
    fs::create_dir_all(folder).map_err(Error::io(folder))?;
    let folder = folder.canonicalize().map_err(Error::io(folder))?;
    // A folder that stays empty goes again.
    let _tidy = Tidy(&folder);
    let rig = ui.timed("read the rig", || rig_file::read(rig_path)).0?;
    let mut job = Job {
        version: VERSION.to_owned(),
        rig: InputFile { file: job::relative(rig_path, &folder)?, hash: rig_file::hash(rig_path)? },
        takes_folder: job::relative(&takes_folder, &folder)?,
        kind: args.kind.clone(),
        device: args.device.clone(),
        options: words::within(&words, &takes_folder)?,
        film: match &args.film {
            FilmChoice::Size(size) => Some(Film { size: size.clone(), fps: args.film_fps }),
            FilmChoice::None => None,
        },
        takes: Vec::new(),
        chunks: Vec::new(),
    };
    let places = job.places(&folder);
    let names: Vec<String> = args.takes.iter().map(|take| job::file_name(&take_name(take))).collect();
    let names = unique_names(names.iter().map(String::as_str));
    let muted = ui.muted();
    let reader = Reader {
        job: &job,
        places: &places,
        takes_folder: &takes_folder,
        rig: &rig,
        first: &first,
        ui: &muted,
    };
    let mut takes = Vec::new();
    let total = args.takes.len() as u64;
    for (number, (path, name)) in args.takes.iter().zip(names).enumerate() {
        ui.step("read the takes", number as u64, total)?;
        match reader.take(path, name) {
            Ok(take) => takes.push(take),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                let error = exit::sentence(&error);
                ui.line(&format!("error: {error}"));
                failed.push(Failed { take: path.clone(), error });
            }
        }
    }
    ui.report("read the takes", total, total);
    job.takes = takes;
    if job.takes.is_empty() {
        return Err(Error::input(format!(
            "{}: no take can be played, so that there is no job; the errors above say why",
            args.output.display()
        )));
    }
    let is_cut = job.has_parts();
    let speed = match args.chunk {
        Some(_) => None,
        None => Some(ui.timed("measure the first take", || measure(&job, &places, &folder, &muted)).0?),
    };
    let frames_of_chunk = match (args.chunk, &speed) {
        _ if !is_cut => None,
        (Some(frames), _) => Some(frames as usize),
        (None, speed) => speed.map(|speed| speed.chunk(args.minutes)),
    };
    if let Some(speed) = &speed {
        disk::check(&args.output, speed, job.takes.iter().map(|take| take.frames).sum());
    }
    job.chunks = chunks(&job, frames_of_chunk);
    write_files(&job, &folder, args)?;
    Ok(Written { job, failed, frames_of_chunk, speed })
}

/// The files of the job. Nothing that the job reads may be one of them.
fn write_files(job: &Job, folder: &Path, args: &Farm) -> Result<()> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let template = serde_json::to_string_pretty(&template(job, &name));
    let template = template.map_err(|error| Error::Internal(error.to_string()))? + "\n";
    let outputs = [folder.join(JOB), folder.join(TEMPLATE), folder.join(slurm::SCRIPT)];
    let outputs: Vec<&Path> = outputs.iter().map(PathBuf::as_path).collect();
    refuse_inputs(&outputs, args.rig.iter().chain(&args.takes).map(PathBuf::as_path))?;
    job.write(folder)?;
    output::file(outputs[1], template.as_bytes())?;
    output::file(outputs[2], slurm::script(job).as_bytes())
}

/// An option that is for one take, or that names a file in another way, is a mistake.
fn check(args: &Animate) -> Result<()> {
    let given = [
        (args.edit.is_some(), "--edit"),
        (args.masks.is_some(), "--masks"),
        (args.strain_curves.is_some(), "--strain-curves"),
        (args.onto.is_some(), "--onto"),
        (args.live.listen.is_some() || args.live.record.is_some(), "--listen"),
        (args.takes.len() > 1, "another take"),
        (args.json.wanted, "--json"),
    ];
    if let Some((_, option)) = given.into_iter().find(|(given, _)| *given) {
        return Err(Error::conflict(format!(
            "--animate has options for all takes, and {option} is for one; leave it out, or use `rhytid animate`"
        )));
    }
    options::check(args, Format::from_extension(&args.output)?)
}

/// The folder that machines need besides the rig.
fn takes_folder(files: &[PathBuf]) -> Result<PathBuf> {
    // A take that is not there is an error of its own.
    let whole: Vec<PathBuf> = files.iter().filter_map(|file| job::whole(file).ok()).collect();
    if whole.is_empty() {
        return std::env::current_dir().map_err(Error::io(&files[0]));
    }
    job::folder_of_all(&whole).ok_or_else(|| {
        Error::bad_path(format!(
            "{}: shares no folder with the other takes and the files of the options; put them below one folder, \
             which machines can be given",
            files[0].display()
        ))
    })
}

/// Measures the first take.
fn measure(job: &Job, places: &Places, folder: &Path, ui: &Ui) -> Result<Speed> {
    let output = folder.join(format!("measure.{}", job.kind));
    let options = job.animate(places, 0, &output, "..", &job.device)?;
    Speed::measure(folder, options, job.takes[0].frames, ui)
}

/// Cuts each take into chunks of so many frames; none for a chunk a take.
fn chunks(job: &Job, frames_of_chunk: Option<usize>) -> Vec<Chunk> {
    let mut chunks = Vec::new();
    for (number, take) in job.takes.iter().enumerate() {
        let length = frames_of_chunk.unwrap_or(take.frames);
        for first in (0..take.frames).step_by(length) {
            let end = (first + length).min(take.frames);
            let file = match frames_of_chunk {
                Some(_) => format!("parts/{}.{first:06}-{end:06}.{}", take.name, job.kind),
                None => format!("{}.{}", take.name, job.kind),
            };
            chunks.push(Chunk { take: number, first, end, file });
        }
    }
    chunks
}

/// A folder that goes if it is empty.
struct Tidy<'a>(&'a Path);

impl Drop for Tidy<'_> {
    fn drop(&mut self) {
        let _ = fs::remove_dir(self.0);
    }
}

/// What reading all takes needs.
struct Reader<'a> {
    job: &'a Job,
    places: &'a Places,
    /// A whole path.
    takes_folder: &'a Path,
    rig: &'a Rig,
    /// The options, with the user's paths.
    first: &'a Animate,
    ui: &'a Ui,
}

impl Reader<'_> {
    /// Reads a take as a task will, so that what is wrong with it is known now.
    fn take(&self, path: &Path, name: String) -> Result<Take> {
        let Self { job, places, takes_folder, rig, first, ui } = self;
        inputs::rig_and_take(&first.rig, path, "rhytid farm TAKE… --rig RIG -o DIR")?;
        let file = job::relative(path, takes_folder)?;
        let take = inputs::take(path, rig, &first.reading, ui)?;
        let frames = take.frames();
        let hash = rig_file::hash(path)?;
        let output = places.output.join(format!("{name}.{}", job.kind));
        let words = words::from_folder(&job.options, &places.takes);
        let options = job::animate(&places.rig, path, &output, "..", &first.device, &words)?;
        let made_from = job::made_from(&options, job, &hash)?;
        let recipe = options::recipe(&options, job.rig.hash.clone(), Format::from_extension(&output)?, None)?;
        perform(&options, (*rig).clone(), None, recipe, take)
            .map_err(|error| error.in_file(path.display()))?;
        Ok(Take { file, name, hash, frames, made_from })
    }
}
