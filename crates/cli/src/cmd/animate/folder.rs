//! `rhytid animate` of takes into a folder: a file for each take, and one report on all of them.
//!
//! A take that fails does not stop the others. A take that was written before, and of which nothing has
//! changed, is left as it is.

use super::options::{self, export_options};
use super::warnings::warn;
use super::{perform, take_name};
use crate::args;
use crate::progress::Ui;
use crate::{exit, exit_code, inputs, output};
use rhytid::capture::{Event, Kind};
use rhytid::core::{DeviceInfo, human, rig_file};
use rhytid::formats::animation::Format;
use rhytid::formats::export::{Recipe, StatedRecipe, unique_names};
use rhytid::formats::refuse_inputs;
use rhytid::playback::ReadTake;
use rhytid::report::{MadeFrom, Outcome, TakeOutcome, Takes, write_takes};
use rhytid::{Error, Result, Rig, Take};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The place of the take's name in the name of a file.
const TAKE: &str = "{take}";

/// A marker with less confidence than this makes its frame a doubtful one.
const DOUBTFUL: f32 = 0.5;

/// Whether the output is a folder, or a name for each take.
pub(super) fn is_for(output: &Path) -> bool {
    let text = output.to_string_lossy();
    let is_named_as_file = output.extension().is_some();
    text.contains(TAKE) || text.ends_with(std::path::is_separator) || output.is_dir() && !is_named_as_file
}

/// Animates each take into a file of its own, and says what became of them.
///
/// # Errors
/// [`Error::Input`] for an option that is for one take, and for outputs that are inputs. As reading the rig.
/// [`Error::Cancelled`]. What is wrong with a take is in the report.
pub(super) fn run(args: &args::Animate, ui: &Ui) -> Result<u8> {
    let pattern = match args.output.to_string_lossy().contains(TAKE) {
        true => args.output.clone(),
        false => args.output.join(format!("{TAKE}.usd")),
    };
    let format = Format::from_extension(&pattern)?;
    let names: Vec<String> = args.takes.iter().map(|take| take_name(take)).collect();
    let names = unique_names(names.iter().map(String::as_str));
    let file = |name: &String| PathBuf::from(pattern.to_string_lossy().replace(TAKE, name));
    let files: Vec<PathBuf> = names.iter().map(file).collect();
    check(args, format, &files)?;
    let folder = folder_of(&pattern);
    for file in &files {
        let parent = file.parent().unwrap_or(Path::new(""));
        fs::create_dir_all(parent).map_err(Error::io(parent))?;
    }
    let device = inputs::named_device(&args.device)?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let rig_hash = rig_file::hash(&args.rig)?;
    let devices = inputs::devices(device, ui)?;
    let job = Job { args, rig: &rig, rig_hash, format, devices, ui };
    let before = read(&folder.join(Takes::JSON));
    let mut report = Takes::new(&args.rig);
    for (i, (take, file)) in args.takes.iter().zip(&files).enumerate() {
        if !ui.is_quiet() {
            ui.line(&format!("{} of {}: {}", i + 1, files.len(), take.display()));
        }
        let before = before.iter().find(|entry| entry.take == *take && entry.file == *file);
        let entry = job.one(take, file, before)?;
        if let Some(error) = &entry.error {
            ui.line(&format!("error: {error}"));
        }
        report.add(entry);
        // After each take, so that a machine that stops loses one take alone.
        write_takes(&folder, &report)?;
    }
    output::done(args.json, ui, &report, || words(&report, &folder))?;
    Ok(if report.failed > 0 { exit_code::USER } else { exit_code::DONE })
}

/// An option that is for one take is a mistake, and an output is no input.
fn check(args: &args::Animate, format: Format, files: &[PathBuf]) -> Result<()> {
    let given = [
        (args.edit.is_some(), "--edit"),
        (args.masks.is_some(), "--masks"),
        (args.strain_curves.is_some(), "--strain-curves"),
        (args.onto.is_some(), "--onto"),
        (args.live.listen.is_some(), "--listen"),
    ];
    if let Some((_, option)) = given.into_iter().find(|(given, _)| *given) {
        return Err(Error::conflict(format!(
            "{}: is a folder for many takes, and {option} is for one; leave it out, or name a file",
            args.output.display()
        )));
    }
    options::check(args, format)?;
    let outputs: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let inputs = [Some(&args.rig), args.reading.setup.as_ref()].into_iter().flatten().chain(&args.takes);
    refuse_inputs(&outputs, inputs.map(PathBuf::as_path))
}

/// The innermost folder that all files share.
fn folder_of(pattern: &Path) -> PathBuf {
    let shared = |folder: &&Path| !folder.to_string_lossy().contains(TAKE);
    pattern.ancestors().skip(1).find(shared).unwrap_or(Path::new("")).to_owned()
}

/// The entries of a former report. Without one, everything is new.
fn read(path: &Path) -> Vec<TakeOutcome> {
    let Ok(text) = fs::read_to_string(path) else { return Vec::new() };
    match serde_json::from_str::<Takes>(&text) {
        Ok(report) => report.takes,
        Err(error) => {
            log::warn!(
                "{}: is no report that this program wrote ({error}): all takes are written anew",
                path.display()
            );
            Vec::new()
        }
    }
}

/// What all takes share.
struct Job<'a> {
    args: &'a args::Animate,
    rig: &'a Rig,
    rig_hash: String,
    format: Format,
    devices: Vec<DeviceInfo>,
    ui: &'a Ui,
}

impl Job<'_> {
    /// Animates a take, unless its file is there already.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn one(&self, take: &Path, file: &Path, before: Option<&TakeOutcome>) -> Result<TakeOutcome> {
        let start = Instant::now();
        let mut entry = TakeOutcome {
            take: take.to_owned(),
            file: file.to_owned(),
            outcome: Outcome::Failed,
            error: None,
            warnings: Vec::new(),
            events: BTreeMap::new(),
            frames: 0,
            doubtful_frames: 0,
            doubtful: Vec::new(),
            bytes: 0,
            seconds: 0.0,
            made_from: MadeFrom::default(),
        };
        self.ui.noted();
        match self.animate(&mut entry, before) {
            Ok(()) => {}
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => {
                entry.outcome = Outcome::Failed;
                entry.error = Some(exit::sentence(&error));
            }
        }
        if entry.outcome != Outcome::Unchanged {
            entry.warnings = self.ui.noted();
            entry.seconds = start.elapsed().as_secs_f64();
        }
        Ok(entry)
    }

    fn animate(&self, entry: &mut TakeOutcome, before: Option<&TakeOutcome>) -> Result<()> {
        let Self { args, rig, ui, .. } = self;
        let take_file = entry.take.clone();
        inputs::rig_and_take(&args.rig, &take_file, "rhytid animate RIG TAKE… -o FOLDER/")?;
        let recipe = options::recipe(args, self.rig_hash.clone(), self.format, None)?;
        let recipe = Recipe { treatment: args.reading.treatment(Some(&take_file))?, ..recipe };
        let mut options = export_options(args, rig.surface().metres_per_unit, None);
        options.clips = vec![take_name(&take_file)];
        entry.made_from = MadeFrom {
            take: rig_file::hash(&take_file)?,
            recipe: StatedRecipe::from(&recipe).0.into_iter().collect(),
            options: format!("{:?} {options:?}", args.frames),
        };
        let bytes = fs::metadata(&entry.file).map(|file| file.len());
        if let (Some(before), Ok(bytes)) = (before, bytes)
            && before.outcome != Outcome::Failed
            && before.made_from == entry.made_from
            && before.bytes == bytes
        {
            *entry = TakeOutcome { outcome: Outcome::Unchanged, ..before.clone() };
            return Ok(());
        }
        let ReadTake { take, events } = inputs::read_take(&take_file, rig, &args.reading, ui)?;
        for event in &events {
            *entry.events.entry(event.kind.name().to_owned()).or_default() += 1;
        }
        let mut is_doubtful = doubtful(&take, &events);
        let performance = perform(args, (*rig).clone(), None, recipe, take)
            .map_err(|error| error.in_file(take_file.display()))?;
        let far = warn(args, self.format, &performance, Some(&take_file), ui)?;
        far.into_iter().for_each(|frames| is_doubtful[frames].fill(true));
        let mut playback = performance.playback(&self.devices, *ui)?;
        let written = playback.export(&performance, &entry.file, &options, *ui)?;
        let range = performance.recipe.first_frame as usize..performance.recipe.end_frame as usize;
        entry.doubt(&at_frames(&is_doubtful[range], performance.selection.inner.len()));
        entry.bytes = written.bytes;
        entry.outcome = Outcome::Written;
        Ok(())
    }
}

/// In which frames a marker was guessed, or markers move as no skin does.
fn doubtful(take: &Take, events: &[Event]) -> Vec<bool> {
    let mut is_doubtful = vec![false; take.frames()];
    let markers = take.labels.len();
    for (i, confidence) in take.confidence.iter().flatten().enumerate() {
        is_doubtful[i / markers] |= *confidence < DOUBTFUL;
    }
    for event in events.iter().filter(|event| matches!(event.kind, Kind::Strain | Kind::Step)) {
        let frames = event.first.min(take.frames())..(event.first + event.frames).min(take.frames());
        is_doubtful[frames].fill(true);
    }
    is_doubtful
}

/// The same for `frames` evenly spaced times, such as those of another rate.
fn at_frames(is_doubtful: &[bool], frames: usize) -> Vec<bool> {
    let last = is_doubtful.len().saturating_sub(1) as f64;
    let step = if frames > 1 { last / (frames - 1) as f64 } else { 0.0 };
    (0..frames).map(|i| is_doubtful[(i as f64 * step).round() as usize]).collect()
}

/// The report in words.
fn words(report: &Takes, folder: &Path) -> String {
    let heading = ["take", "", "frames", "doubtful", "what was found"].map(str::to_owned);
    let row = |entry: &TakeOutcome| {
        let outcome = match entry.outcome {
            Outcome::Failed => "failed",
            Outcome::Written => "written",
            Outcome::Unchanged => "unchanged",
        };
        let is_there = entry.outcome != Outcome::Failed;
        let frames = if is_there { human::count(entry.frames) } else { String::new() };
        let doubt = if is_there { format!("{:.0} %", 100.0 * entry.doubtful_part()) } else { String::new() };
        [take_name(&entry.take), outcome.to_owned(), frames, doubt, entry.what()]
    };
    let rows: Vec<_> = std::iter::once(heading).chain(report.takes.iter().map(row)).collect();
    format!(
        "{}: {} written, {} unchanged, {} failed; {} shows all of it\n{}",
        if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.display(),
        report.written,
        report.unchanged,
        report.failed,
        folder.join(Takes::PAGE).display(),
        output::table(&rows)
    )
}
