//! `rhytid animate` of takes into a folder: a file for each take, and one report on all of them.
//!
//! A take that fails does not stop the others. A take that was written before, and of which nothing has
//! changed, is left as it is.

use super::options::{self, export_options};
use super::warnings::warn;
use super::{perform, take_name};
use crate::args::{self, FramesChoice};
use crate::progress::Ui;
use crate::{exit, exit_code, inputs, output};
use rhytid::capture::Kind;
use rhytid::core::{DeviceInfo, human, rig_file};
use rhytid::formats::animation::Format;
use rhytid::formats::export::{Recipe, StatedRecipe, unique_names};
use rhytid::formats::refuse_inputs;
use rhytid::playback::ReadTake;
use rhytid::{Error, Result, Rig};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The place of the take's name in the name of a file.
const TAKE: &str = "{take}";

/// The report's file in the folder.
const REPORT: &str = "takes.json";

/// A marker with less confidence than this makes its frame a doubtful one.
const DOUBTFUL: f32 = 0.5;

/// What became of all takes, those with most to look at first.
#[derive(Serialize, Deserialize)]
struct Report {
    rig: PathBuf,
    written: usize,
    unchanged: usize,
    failed: usize,
    takes: Vec<Entry>,
}

/// What became of a take.
#[derive(Clone, Serialize, Deserialize)]
struct Entry {
    take: PathBuf,
    file: PathBuf,
    outcome: Outcome,
    /// The sentence of a take that failed.
    error: Option<String>,
    warnings: Vec<String>,
    /// How many of each kind the clean-up found.
    events: BTreeMap<String, usize>,
    frames: usize,
    /// Frames in which a marker was guessed, or in which markers move as no skin does.
    doubtful_frames: usize,
    bytes: u64,
    seconds: f64,
    made_from: MadeFrom,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Outcome {
    Failed,
    Written,
    Unchanged,
}

/// All that decides a file. If it is the same as before, so is the file.
#[derive(Clone, PartialEq, Default, Serialize, Deserialize)]
struct MadeFrom {
    /// The hash of the take's file.
    take: String,
    /// The recipe, with the rig's hash.
    recipe: BTreeMap<String, Value>,
    /// The frames, and the options of the file.
    options: String,
}

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
    let before = read(&folder.join(REPORT));
    let mut report = Report { rig: args.rig.clone(), written: 0, unchanged: 0, failed: 0, takes: Vec::new() };
    for (i, (take, file)) in args.takes.iter().zip(&files).enumerate() {
        if !ui.is_quiet() {
            ui.line(&format!("{} of {}: {}", i + 1, files.len(), take.display()));
        }
        let before = before.iter().find(|entry| entry.take == *take && entry.file == *file);
        let entry = job.one(take, file, before)?;
        if let Some(error) = &entry.error {
            ui.line(&format!("error: {error}"));
        }
        match entry.outcome {
            Outcome::Failed => report.failed += 1,
            Outcome::Written => report.written += 1,
            Outcome::Unchanged => report.unchanged += 1,
        }
        report.takes.push(entry);
        report.takes.sort_by(Entry::order);
        // After each take, so that a machine that stops loses one take alone.
        let text = serde_json::to_string_pretty(&report).map_err(|e| Error::Internal(e.to_string()))?;
        output::file(&folder.join(REPORT), text.as_bytes())?;
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
fn read(path: &Path) -> Vec<Entry> {
    let Ok(text) = fs::read_to_string(path) else { return Vec::new() };
    match serde_json::from_str::<Report>(&text) {
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
    fn one(&self, take: &Path, file: &Path, before: Option<&Entry>) -> Result<Entry> {
        let start = Instant::now();
        let mut entry = Entry {
            take: take.to_owned(),
            file: file.to_owned(),
            outcome: Outcome::Failed,
            error: None,
            warnings: Vec::new(),
            events: BTreeMap::new(),
            frames: 0,
            doubtful_frames: 0,
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

    fn animate(&self, entry: &mut Entry, before: Option<&Entry>) -> Result<()> {
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
            *entry = Entry { outcome: Outcome::Unchanged, ..before.clone() };
            return Ok(());
        }
        let ReadTake { take, events } = inputs::read_take(&take_file, rig, &args.reading, ui)?;
        for event in &events {
            *entry.events.entry(event.kind.name().to_owned()).or_default() += 1;
        }
        let mut is_doubtful = vec![false; take.frames()];
        let markers = take.labels.len();
        for (i, confidence) in take.confidence.iter().flatten().enumerate() {
            is_doubtful[i / markers] |= *confidence < DOUBTFUL;
        }
        for event in events.iter().filter(|event| matches!(event.kind, Kind::Strain | Kind::Step)) {
            let frames = event.first.min(take.frames())..(event.first + event.frames).min(take.frames());
            is_doubtful[frames].fill(true);
        }
        let range = match args.frames {
            FramesChoice::Range(range) => {
                range.within(take.frames()).map_err(|error| error.in_file(take_file.display()))?
            }
            FramesChoice::Count(_) => 0..take.frames(),
        };
        entry.doubtful_frames = is_doubtful[range].iter().filter(|is| **is).count();
        let performance = perform(args, (*rig).clone(), None, recipe, take)
            .map_err(|error| error.in_file(take_file.display()))?;
        warn(args, self.format, &performance, Some(&take_file), ui)?;
        let mut playback = performance.playback(&self.devices, *ui)?;
        let written = playback.export(&performance, &entry.file, &options, *ui)?;
        entry.frames = performance.selection.inner.len();
        entry.bytes = written.bytes;
        entry.outcome = Outcome::Written;
        Ok(())
    }
}

impl Entry {
    /// The part of the frames that is doubtful.
    fn doubt(&self) -> f64 {
        self.doubtful_frames as f64 / self.frames.max(1) as f64
    }

    /// What needs a look comes first: takes that failed, then those with the largest part of doubtful frames,
    /// then those with most warnings.
    fn order(&self, other: &Self) -> std::cmp::Ordering {
        let failed = |entry: &Self| entry.outcome != Outcome::Failed;
        failed(self)
            .cmp(&failed(other))
            .then(other.doubt().total_cmp(&self.doubt()))
            .then(other.warnings.len().cmp(&self.warnings.len()))
            .then(self.take.cmp(&other.take))
    }

    /// What is wrong with the take, in a line.
    fn what(&self) -> String {
        if let Some(error) = &self.error {
            return error.clone();
        }
        let mut parts: Vec<String> = Vec::new();
        let events: Vec<String> = self.events.iter().map(|(kind, n)| format!("{n} × {kind}")).collect();
        if !events.is_empty() {
            parts.push(events.join(", "));
        }
        if !self.warnings.is_empty() {
            parts.push(human::counted(self.warnings.len(), "warning"));
        }
        parts.join("; ")
    }
}

/// The report in words.
fn words(report: &Report, folder: &Path) -> String {
    let heading = ["take", "", "frames", "doubtful", "what was found"].map(str::to_owned);
    let row = |entry: &Entry| {
        let outcome = match entry.outcome {
            Outcome::Failed => "failed",
            Outcome::Written => "written",
            Outcome::Unchanged => "unchanged",
        };
        let is_there = entry.outcome != Outcome::Failed;
        let frames = if is_there { human::count(entry.frames) } else { String::new() };
        let doubt = if is_there { format!("{:.0} %", 100.0 * entry.doubt()) } else { String::new() };
        [take_name(&entry.take), outcome.to_owned(), frames, doubt, entry.what()]
    };
    let rows: Vec<_> = std::iter::once(heading).chain(report.takes.iter().map(row)).collect();
    format!(
        "{}: {} written, {} unchanged, {} failed; {} says all of it\n{}",
        if folder.as_os_str().is_empty() { Path::new(".") } else { folder }.display(),
        report.written,
        report.unchanged,
        report.failed,
        folder.join(REPORT).display(),
        output::table(&rows)
    )
}
