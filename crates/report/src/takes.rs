//! The page of a folder of takes: which of them to look at first.

use crate::document::document;
use crate::opening::{Finding, opening};
use crate::written::write_texts;
use maud::{Markup, html};
use rhytid_core::{Error, Result, human};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The width and height of the picture of a take's frames, in its own units. The page stretches it.
const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 14.0;
/// The least width of a run, so that one frame of a long take is visible.
const LEAST: f64 = 3.0;

/// What became of all takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Takes {
    /// The rig's file.
    pub rig: PathBuf,
    /// How many takes were written.
    pub written: usize,
    /// How many takes were done before, and nothing of them has changed.
    pub unchanged: usize,
    /// How many takes failed.
    pub failed: usize,
    /// The takes, those to look at first.
    pub takes: Vec<TakeOutcome>,
}

/// What became of a take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TakeOutcome {
    /// The take's file.
    pub take: PathBuf,
    /// The file that was written for it, or was to be.
    pub file: PathBuf,
    /// What became of it.
    pub outcome: Outcome,
    /// The sentence of a take that failed.
    pub error: Option<String>,
    /// What was warned of.
    pub warnings: Vec<String>,
    /// How many of each kind the clean-up found.
    pub events: BTreeMap<String, usize>,
    /// The frames that were written.
    pub frames: usize,
    /// How many frames are in `doubtful`.
    pub doubtful_frames: usize,
    /// Where a marker was guessed, where markers move as no skin does, or where no example is like it.
    pub doubtful: Vec<Run>,
    /// The size of `file`, in bytes.
    pub bytes: u64,
    /// How long it took.
    pub seconds: f64,
    /// What decides the file.
    pub made_from: MadeFrom,
}

/// What became of a take, those that failed first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// It has no file. [`TakeOutcome::error`] says why.
    Failed,
    /// Its file was written.
    Written,
    /// Its file was there, and nothing has changed.
    Unchanged,
}

/// Frames that follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Run {
    /// The first one, counted from the first frame that was written.
    pub first: usize,
    /// How many they are.
    pub frames: usize,
}

/// All that decides a file. If it is the same as before, so is the file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MadeFrom {
    /// The hash of the take's file.
    pub take: String,
    /// The recipe, with the rig's hash.
    pub recipe: BTreeMap<String, Value>,
    /// The frames, and the options of the file.
    pub options: String,
}

impl Takes {
    /// The name of the data's file.
    pub const JSON: &'static str = "takes.json";
    /// The name of the page.
    pub const PAGE: &'static str = "takes.html";

    /// Of no take yet.
    pub fn new(rig: &Path) -> Self {
        Self { rig: rig.to_owned(), written: 0, unchanged: 0, failed: 0, takes: Vec::new() }
    }

    /// Adds a take in its place. Takes that failed come first, then those with the largest part of doubtful
    /// frames, then those with most warnings.
    pub fn add(&mut self, take: TakeOutcome) {
        match take.outcome {
            Outcome::Failed => self.failed += 1,
            Outcome::Written => self.written += 1,
            Outcome::Unchanged => self.unchanged += 1,
        }
        let place = self.takes.partition_point(|other| other.order(&take) == Ordering::Less);
        self.takes.insert(place, take);
    }

    /// How many takes have a doubtful frame or a warning, without those that failed.
    fn doubted(&self) -> usize {
        self.takes.iter().filter(|take| take.outcome != Outcome::Failed && take.is_doubted()).count()
    }

    /// The report in a sentence.
    fn verdict(&self) -> String {
        let all = human::counted(self.takes.len(), "take");
        let needs = |n: usize| if n == 1 { "needs" } else { "need" };
        match (self.failed, self.doubted()) {
            (0, 0) => format!("Nothing was found in {all}."),
            (0, doubted) => format!("{doubted} of {all} {} a look.", needs(doubted)),
            (failed, 0) => format!("{failed} of {all} failed."),
            (failed, doubted) => {
                format!("{failed} of {all} failed, and {doubted} {} a look.", needs(doubted))
            }
        }
    }
}

impl TakeOutcome {
    /// Marks the frames that are doubtful, of all that were written.
    pub fn doubt(&mut self, is_doubtful: &[bool]) {
        self.frames = is_doubtful.len();
        self.doubtful_frames = is_doubtful.iter().filter(|is| **is).count();
        self.doubtful.clear();
        let mut first = 0;
        for run in is_doubtful.chunk_by(|a, b| a == b) {
            if run[0] {
                self.doubtful.push(Run { first, frames: run.len() });
            }
            first += run.len();
        }
    }

    /// The part of the frames that is doubtful, 0 to 1.
    pub fn doubtful_part(&self) -> f64 {
        self.doubtful_frames as f64 / self.frames.max(1) as f64
    }

    /// What is wrong with the take, in a line.
    pub fn what(&self) -> String {
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

    fn is_doubted(&self) -> bool {
        self.doubtful_frames > 0 || !self.warnings.is_empty()
    }

    fn order(&self, other: &Self) -> Ordering {
        let failed = |take: &Self| take.outcome != Outcome::Failed;
        failed(self)
            .cmp(&failed(other))
            .then(other.doubtful_part().total_cmp(&self.doubtful_part()))
            .then(other.warnings.len().cmp(&self.warnings.len()))
            .then(self.take.cmp(&other.take))
    }

    fn name(&self) -> String {
        self.take.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// Writes `takes.html` and then `takes.json` to `folder`, which is created if necessary.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written.
pub fn write_takes(folder: &Path, takes: &Takes) -> Result<()> {
    let json =
        serde_json::to_string_pretty(takes).map_err(|e| Error::Internal(format!("takes as JSON: {e}")))?;
    write_texts(folder, [(Takes::PAGE, page(takes)), (Takes::JSON, json)])
}

fn page(takes: &Takes) -> String {
    let about = html! {
        "Takes on the rig " b { (takes.rig.display()) } ": "
        (human::count(takes.written)) " written, " (human::count(takes.unchanged)) " unchanged, "
        (human::count(takes.failed)) " failed"
    };
    let main = html! {
        (opening(&takes.verdict(), &findings(takes)))
        section {
            h2 { "All takes" }
            p {
                "Those to look at first come first. A bar has the frames of a take. In the "
                span.doubtful { "coloured" } " ones, a marker was guessed, markers move as no skin does, or the "
                "expression is far outside the examples. "
                "The window shows such a take, and the report of its clean-up says what was done to each marker."
            }
            (table(takes))
        }
    };
    document("Takes", &about, &main)
}

/// The first takes of the list, with what is wrong with them.
fn findings(takes: &Takes) -> Vec<Finding> {
    let first = takes.takes.iter().take_while(|take| take.outcome == Outcome::Failed || take.is_doubted());
    let finding = |take: &TakeOutcome| {
        let words = match take.outcome {
            Outcome::Failed => html! { b { (take.name()) } " failed. " (take.what()) },
            _ => html! {
                b { (take.name()) } ". "
                @if take.doubtful_frames > 0 { (percent(take)) " of the frames are doubtful. " }
                @match take.warnings.first() {
                    Some(warning) => { (warning) }
                    None => { (take.what()) }
                }
            },
        };
        Finding { words, picture: None }
    };
    first.map(finding).collect()
}

fn table(takes: &Takes) -> Markup {
    html! {
        table.takes {
            thead { tr {
                th { "take" } th {} th.number { "frames" } th { "doubtful" } th.number {} th { "what was found" }
            } }
            tbody {
                @for take in &takes.takes {
                    @let is_there = take.outcome != Outcome::Failed;
                    tr.failed[!is_there] {
                        td.frame title=(take.take.display()) { (take.name()) }
                        td { (word(take.outcome)) }
                        @if is_there {
                            td.number { (human::count(take.frames)) }
                            td.frames { (bar(take)) }
                            td.number { (percent(take)) }
                        } @else {
                            td {} td {} td {}
                        }
                        td { (found(take)) }
                    }
                }
            }
        }
    }
}

fn found(take: &TakeOutcome) -> Markup {
    html! {
        @if take.warnings.is_empty() {
            (take.what())
        } @else {
            details {
                summary { (take.what()) }
                ul { @for warning in &take.warnings { li { (warning) } } }
            }
        }
    }
}

/// The frames of a take, with those that are doubtful.
fn bar(take: &TakeOutcome) -> Markup {
    let frames = take.frames.max(1) as f64;
    html! {
        svg viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } preserveAspectRatio="none" role="img" aria-label="doubtful frames" {
            @for run in &take.doubtful {
                @let width = (WIDTH * run.frames as f64 / frames).max(LEAST);
                @let x = (WIDTH * run.first as f64 / frames).min(WIDTH - width);
                rect.lost x=(format!("{x:.1}")) y="0" width=(format!("{width:.1}")) height=(HEIGHT) {
                    title { "frames " (run.first) " to " (run.first + run.frames - 1) }
                }
            }
        }
    }
}

/// The part of the frames that is doubtful. It shows 0 or 100 only if it is exactly that.
fn percent(take: &TakeOutcome) -> String {
    match 100.0 * take.doubtful_part() {
        0.0 => "0 %".to_owned(),
        part if part < 1.0 => "< 1 %".to_owned(),
        part if part > 99.0 && part < 100.0 => "> 99 %".to_owned(),
        part => format!("{part:.0} %"),
    }
}

/// What became of a take, in a word.
fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Failed => "failed",
        Outcome::Written => "written",
        Outcome::Unchanged => "unchanged",
    }
}
