//! How fast `.usd` is written, against USD's own library writing the same arrays to the same disk:
//! `cargo bench -p rhytid-formats --bench usd_writer`, after `cargo xtask setup`.
//!
//! The scene is a sheet of 728 × 728 vertices with 100 frames of points, normals and extent. The arrays come
//! from a file, so that both programs have the same ones. Reading the file is not timed.
//!
//! Rhytid computes the extents, and USD receives them. The time of USD is that of authoring and saving. The
//! time until the file is on the disk is reported apart, because Rhytid always waits for the disk. At the
//! end, USD compares every array of the two files.
use rhytid_core::{Faces, NoProgress, UpAxis, channel};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, Options, Scene, StatedRecipe};
use serde_json::Value;
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

const SIDE: usize = 728;
const FRAMES: usize = 100;
const ROUNDS: usize = 4;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR"))?;
    let path = |name: &str| folder.path().join(name);
    write_arrays(&path("arrays.bin"))?;
    println!("{} vertices, {FRAMES} frames, {ROUNDS} rounds", SIDE * SIDE);
    let mut best = [f64::INFINITY; 3];
    for round in 1..=ROUNDS {
        remove(&path("ours.usd"))?;
        let (ours, bytes) = write_ours(&path("arrays.bin"), &path("ours.usd"))?;
        remove(&path("theirs.usd"))?;
        let theirs = python("write", folder.path())?;
        let seconds = |name: &str| theirs[name].as_f64().unwrap_or(f64::NAN);
        let saved = seconds("author") + seconds("save");
        let times = [ours.as_secs_f64(), saved, saved + seconds("sync")];
        for (best, time) in best.iter_mut().zip(times) {
            *best = best.min(time);
        }
        println!(
            "round {round}: ours {}, on the disk; USD {} (authoring {:.2} s), on the disk {}",
            speed(times[0], bytes),
            speed(times[1], bytes),
            seconds("author"),
            speed(times[2], bytes),
        );
        println!("         memory at most: ours {}, USD {} MB", peak_memory(), theirs["peak"]);
    }
    let [ours, saved, on_disk] = best;
    println!(
        "best times, USD / ours: {:.2} on the disk, {:.2} where USD does not wait for it",
        on_disk / ours,
        saved / ours
    );
    println!("{}", python("compare", folder.path())?["compared"].as_str().unwrap_or("not compared"));
    Ok(())
}

/// Each side's last file goes right before it writes the next, so that it gets that file's memory for the
/// disk's cache.
fn remove(path: &Path) -> std::io::Result<()> {
    if path.exists() { std::fs::remove_file(path) } else { Ok(()) }
}

fn speed(seconds: f64, bytes: u64) -> String {
    format!("{seconds:.2} s ({:.0} MB/s)", bytes as f64 / seconds / 1e6)
}

/// The most memory that this process held, as Linux tells it.
fn peak_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kib.map_or("unknown".into(), |kib| format!("{:.0} MB", kib / 1024.0))
}

/// Frames of 3V positions and 3V normals, waves that no two frames have alike.
fn write_arrays(path: &Path) -> Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    for frame in 0..FRAMES {
        for amplitude in [0.1, 1.0] {
            for v in 0..SIDE * SIDE {
                let (x, y) = ((v % SIDE) as f32, (v / SIDE) as f32);
                let wave = amplitude * (0.01 * x + 0.02 * y + frame as f32).sin();
                for number in [0.1 * x + wave, 0.1 * y - wave, wave] {
                    out.write_all(&number.to_le_bytes())?;
                }
            }
        }
    }
    Ok(out.flush()?)
}

fn write_ours(arrays: &Path, path: &Path) -> Result<(Duration, u64)> {
    let mut frame = vec![0.0_f32; 6 * SIDE * SIDE];
    let mut source = File::open(arrays)?;
    source.read_exact(bytemuck::cast_slice_mut(&mut frame))?;
    let (faces, triangle_corners) = sheet();
    let (positions, normals) = frame.split_at(3 * SIDE * SIDE);
    let recipe = StatedRecipe::default();
    let scene = Scene {
        name: "face",
        rest: positions.as_chunks().0,
        rest_normals: Some(normals.as_chunks().0),
        channels: std::slice::from_ref(&channel::NORMALS),
        faces: &faces,
        triangle_corners: &triangle_corners,
        uvs: None,
        materials: None,
        head: None,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        frames: FRAMES,
        rate: 24.0,
        first_time_code: 1.0,
        recipe: &recipe,
        further: &[],
    };
    let start = Instant::now();
    let mut exporter = animation::create(path, &scene, &Options::default())?;
    let mut spent = start.elapsed();
    for i in 0..FRAMES {
        if i > 0 {
            source.read_exact(bytemuck::cast_slice_mut(&mut frame))?;
        }
        let (positions, normals) = frame.split_at(3 * SIDE * SIDE);
        let start = Instant::now();
        exporter.frame(&Frame::new(positions).with(&channel::NORMALS, normals))?;
        spent += start.elapsed();
    }
    let start = Instant::now();
    let written = exporter.finish(&NoProgress)?;
    Ok((spent + start.elapsed(), written.bytes))
}

fn sheet() -> (Faces, Vec<[u32; 3]>) {
    let (mut faces, mut triangles) = (Faces::default(), Vec::new());
    let side = SIDE as u32;
    for y in 0..side - 1 {
        for x in 0..side - 1 {
            let (v, corner) = (y * side + x, 4 * faces.len() as u32);
            faces.push(&[v, v + 1, v + side + 1, v + side]);
            triangles.extend([[corner, corner + 1, corner + 2], [corner, corner + 2, corner + 3]]);
        }
    }
    (faces, triangles)
}

/// The report of `usd_writer.py`, as JSON.
fn python(what: &str, folder: &Path) -> Result<Value> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let python =
        std::env::var_os("RHYTID_PYTHON").map_or_else(|| root.join("target/venv/bin/python"), PathBuf::from);
    let mut command = Command::new(&python);
    command.arg(root.join("crates/formats/benches/usd_writer.py")).arg(what).arg(folder);
    command.args([SIDE, FRAMES].map(|n| n.to_string()));
    let output =
        command.output().map_err(|e| format!("{}: {e}; run `cargo xtask setup`", python.display()))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}
