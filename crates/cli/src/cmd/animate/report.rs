//! What `rhytid animate` says at its end, in words and as JSON.

use super::{Animated, ClipOf, take_name};
use crate::cmd::listen;
use crate::{args, output, start};
use rhytid::core::human;
use rhytid::formats::animation::Format;
use rhytid::formats::export::{Deviation, Written};
use rhytid::playback::{Correction, Selection};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What was written.
pub(super) fn words(args: &args::Animate, done: &Animated) -> String {
    let evaluated = format!(
        "evaluated on {} in {} ({} frames/s), {}{}",
        done.device.id(),
        human::duration(done.time),
        human::number((done.frames() as f64 / done.time.as_secs_f64() * 10.0).round() / 10.0),
        human::bytes(done.written.bytes),
        targets(&done.written),
    );
    let frames = |clip: &ClipOf| {
        let (frames, rate) = (human::counted(clip.frames, "frame"), human::number(clip.rate));
        format!("{frames} at {rate} frames per second")
    };
    let error = |i: usize| off(done.written.errors.get(i), done.metres_per_unit);
    match &done.clips[..] {
        [clip] => format!("{}: {}, {evaluated}{}", args.output.display(), frames(clip), error(0)),
        clips => {
            let takes = human::counted(clips.len(), "take");
            let of_clip =
                |(i, clip): (usize, &ClipOf)| format!("\n  {}: {}{}", clip.name, frames(clip), error(i));
            let of_clips: String = clips.iter().enumerate().map(of_clip).collect();
            format!("{}: {takes}, {evaluated}{of_clips}", args.output.display())
        }
    }
}

/// The commands that come next: look at it, and check the file.
pub(super) fn next(args: &args::Animate, done: &Animated) -> String {
    let Some(take) = args.takes.first().or(args.live.record.as_ref()) else { return String::new() };
    if args.live.sender.world {
        return output::next(&[listen::prepare(start::arguments(), &args.rig, take)]);
    }
    let [rig, file] = [&args.rig, &args.output].map(|path| output::word(path));
    let option = |name: &str, value: &Option<PathBuf>| {
        value.as_ref().map_or(String::new(), |path| format!(" {name} {}", output::word(path)))
    };
    let edit = option("--edit", &args.edit);
    let setup = option("--setup", &args.reading.setup);
    let shapes = option("--shapes", &args.reading.shapes_of_curves().map(Path::to_owned));
    let elsewhere = args.reading.elsewhere.again();
    let mut commands = Vec::new();
    // The window plays no other shapes than the rig's examples.
    if shapes.is_empty() {
        commands.push(format!("rhytid view {rig} {}{edit}", output::word(take)));
    }
    // A point cache says nothing about how it was made, and neither do curves.
    let is_stated = |format| !matches!(format, Format::Pc2 | Format::Csv);
    if Format::from_extension(&args.output).is_ok_and(is_stated) && args.live.listen.is_none() {
        commands.extend(args.takes.iter().zip(&done.clips).map(|(take, clip)| {
            // Two takes may have one name.
            let is_plain = done.clips.len() == 1 || clip.name == take_name(take);
            let clip = if is_plain {
                String::new()
            } else {
                format!(" --clip {}", output::word(clip.name.as_ref()))
            };
            let take = output::word(take);
            format!("rhytid verify {file} --rig {rig} --take {take}{clip}{edit}{setup}{shapes}{elsewhere}")
        }));
    }
    output::next(&commands)
}

/// The JSON that is printed.
#[derive(Serialize)]
pub(super) struct Summary<'a> {
    file: &'a Path,
    bytes: u64,
    frames: usize,
    frames_per_second: f64,
    device: String,
    device_name: &'a str,
    seconds: f64,
    /// Null where the file has no morph targets.
    morph_targets: Option<usize>,
    /// The largest distance of a vertex from its place; null where nothing is approximated.
    worst_mm: Option<f64>,
    rms_mm: Option<f64>,
    /// Null where there is one take.
    clips: Option<Vec<ClipSummary<'a>>>,
}

/// One of several takes.
#[derive(Serialize)]
struct ClipSummary<'a> {
    take: &'a Path,
    frames: usize,
    frames_per_second: f64,
    worst_mm: Option<f64>,
    rms_mm: Option<f64>,
}

impl<'a> Summary<'a> {
    pub(super) fn new(args: &'a args::Animate, done: &'a Animated) -> Self {
        let millimetres = |length: f64| length * done.metres_per_unit * 1e3;
        Self {
            file: &args.output,
            bytes: done.written.bytes,
            frames: done.frames(),
            frames_per_second: done.clips.first().map_or(0.0, |clip| clip.rate),
            device: done.device.id(),
            device_name: &done.device.name,
            seconds: done.time.as_secs_f64(),
            morph_targets: done.written.targets,
            worst_mm: done.error().map(|error| millimetres(error.worst)),
            rms_mm: done.error().map(|error| millimetres(error.rms)),
            clips: (done.clips.len() > 1).then(|| {
                let clips = args.takes.iter().zip(&done.clips).enumerate();
                let summary = clips.map(|(i, (take, clip))| ClipSummary {
                    take,
                    frames: clip.frames,
                    frames_per_second: clip.rate,
                    worst_mm: done.written.errors.get(i).map(|error| millimetres(error.worst)),
                    rms_mm: done.written.errors.get(i).map(|error| millimetres(error.rms)),
                });
                summary.collect()
            }),
        }
    }
}

/// The words about morph targets, if there are any.
fn targets(written: &Written) -> String {
    written.targets.map_or(String::new(), |n| format!(", {}", human::counted(n, "morph target")))
}

/// The words about the error of a clip, if it has one.
fn off(error: Option<&Deviation>, metres_per_unit: f64) -> String {
    let Some(error) = error else { return String::new() };
    let millimetres = |length: f64| human::number(length * metres_per_unit * 1e3);
    let (frame, vertex) = error.at;
    format!(
        "; at most {} mm off (frame {frame}, vertex {vertex}), RMS {} mm",
        millimetres(error.worst),
        millimetres(error.rms)
    )
}

/// A smaller motion, in millimetres, cannot be seen.
const SEEN_MM: f64 = 0.1;

/// What a correction did in the frames of a selection.
pub(super) fn corrected(
    correction: &Correction,
    moved: &[f64],
    selection: &Selection,
    metres_per_unit: f64,
) -> String {
    let millimetres = |x: f64| human::number((x * metres_per_unit * 1e5).round() / 1e2);
    let moved = moved.get(selection.inner.clone()).unwrap_or_default();
    let seen: Vec<usize> = (0..moved.len()).filter(|&i| moved[i] * metres_per_unit * 1e3 > SEEN_MM).collect();
    let touched = moved.iter().filter(|by| **by > 0.0).count();
    let between = match (seen.first(), seen.last()) {
        (Some(first), Some(last)) => {
            format!(" between {} and {}", first + selection.first, last + selection.first)
        }
        _ => String::new(),
    };
    format!(
        "correction of frame {}: {} vertices by up to {} mm; more than {SEEN_MM} mm in {}{between}, nothing in {}: its reach is {}, as a ratio of strains",
        correction.frame(),
        human::count(correction.vertices()),
        millimetres(correction.largest()),
        human::counted(seen.len(), "frame"),
        human::count(moved.len() - touched),
        human::number((correction.reach() * 1e4).round() / 1e4)
    )
}
