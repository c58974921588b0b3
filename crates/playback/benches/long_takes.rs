//! How much processor time it takes to find few shapes for a long take of a real head.
//!
//! `cargo bench -p rhytid-playback --bench long_takes -- [FRAMES] [face|head] [MODE]`. The data are those of
//! `../shared/data`. MODE is `floats` (the default), `integers`, or a number of shapes. Takes of more than
//! 4,030 frames repeat the capture. Each repetition mixes it with another moment of it, so that all frames
//! differ.

use rhytid_core::{Example, Face, Progress, Result, Settings, Take, UpAxis};
use rhytid_devices::{Guard, choose_devices};
use rhytid_formats::export::{Options, Recipe};
use rhytid_formats::{mesh, tables, take};
use rhytid_playback::{Performance, Playback};
use rhytid_test_support::{peak, processor_seconds, shared};
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

/// The largest error, in the centimetres of the data.
const MAX_ERROR: f64 = 0.01;

fn face(data: &Path, name: &str) -> Result<Face> {
    let neutral_path = data.join(name).join("neutral.obj");
    let neutral = mesh::read(&neutral_path)?;
    let poses = std::fs::read_dir(data.join(name).join("poses")).expect("the folder of poses");
    let mut poses: Vec<_> = poses.map(|entry| entry.expect("a pose").path()).collect();
    poses.sort();
    let mut examples = Vec::new();
    for pose in poses.iter().filter(|pose| pose.extension().is_some_and(|extension| extension == "obj")) {
        examples.push(Example {
            name: pose.file_stem().expect("a name").to_string_lossy().into_owned(),
            mirror: false,
            positions: mesh::read_like(&neutral, &neutral_path, pose)?,
            noise: None,
        });
    }
    Ok(Face {
        name: name.into(),
        neutral,
        examples,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: tables::read_handles(&data.join("markers.csv"))?,
        prior: None,
        settings: Settings::default(),
    })
}

/// The take with so many frames.
fn lengthened(take: &Take, frames: usize) -> Take {
    let (count, markers) = (take.frames(), take.labels.len());
    let row = |frame: usize| &take.positions[frame % count * markers..][..markers];
    let mut positions = Vec::with_capacity(frames * markers);
    for frame in 0..frames {
        let repetition = frame / count;
        let part = if repetition == 0 { 0.0 } else { 0.25 };
        for (a, b) in row(frame).iter().zip(row(frame + 977 * repetition)) {
            positions.push(std::array::from_fn(|axis| (1.0 - part) * a[axis] + part * b[axis]));
        }
    }
    let step = take.times[1] - take.times[0];
    let times = (0..frames).map(|frame| take.times[0] + step * frame as f64).collect();
    Take { labels: take.labels.clone(), times, positions, ..Take::default() }
}

/// The step that is under way, and the processor time at its start.
struct Step {
    name: &'static str,
    since: f64,
}

/// Prints the processor time of each step.
struct Steps(Mutex<Step>);

impl Progress for Steps {
    fn report(&self, name: &'static str, _done: u64, _total: u64) {
        let mut step = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if step.name != name {
            let now = processor_seconds();
            println!("{:>24} {:7.1} s", step.name, now - step.since);
            *step = Step { name, since: now };
        }
    }
}

fn main() -> Result<()> {
    let Some(data) = shared("data") else { return Ok(()) };
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let word = |i: usize, other: &str| words.get(i).map_or(other.to_owned(), Clone::clone);
    let frames: usize = word(0, "4030").parse().expect("a number of frames");
    let (name, mode) = (word(1, "head"), word(2, "floats"));
    let rig = rhytid_solve::solve(&face(&data, &name)?, &rhytid_core::NoProgress)?.rounded()?;
    let labels = &rig.handles().labels;
    let take = take::read(&data.join("takes/rom_3_clean.csv"), Some(labels), take::Missing::Error)?;
    let performance = Performance::new(Recipe::default(), rig, lengthened(&take, frames), None)?;
    let devices = choose_devices("cpu:0", Guard::NONE, &rhytid_core::NoProgress)?.devices;
    let mut playback = Playback::new(&performance.rig, &devices, frames)?;
    let shapes: Option<usize> = mode.parse().ok();
    let max_error = shapes.is_none().then_some(MAX_ERROR);
    let options =
        Options { max_error, shapes, quantize: mode == "integers", meshopt: true, ..Options::default() };
    println!("{name}: {frames} frames of {} vertices, {mode}", performance.rig.vertices());
    let folder = tempfile::tempdir().expect("a folder");
    let (start, before) = (Instant::now(), processor_seconds());
    let steps = Steps(Mutex::new(Step { name: "begin", since: before }));
    let written = playback.export(&performance, &folder.path().join("out.glb"), &options, &steps)?;
    steps.report("end", 0, 0);
    let error = written.errors[0];
    println!(
        "{} targets, {} bytes, worst {:.4} mm, RMS {:.4} mm; {:.1} s of processor time, {:.1} s; {} MiB",
        written.targets.unwrap_or_default(),
        written.bytes,
        error.worst * 10.0,
        error.rms * 10.0,
        processor_seconds() - before,
        start.elapsed().as_secs_f64(),
        peak() >> 20
    );
    Ok(())
}
