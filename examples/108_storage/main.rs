//! The ways in which a device can keep a rig, side by side: memory, times, and how far vertices and normals
//! are from those of fp32.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 108_storage
//! cargo run --release -p rhytid-examples --example 108_storage -- face.safetensors take.csv cpu:0
//! ```
//!
//! Without files, it makes a face and a take. Of a longer take, 800 frames are compared.
use rhytid::core::plan::{Plan, PlanLimits};
use rhytid::core::{BasisStorage, Missing, NoProgress, rig_file};
use rhytid::devices::{Guard, backends, find_device};
use rhytid::playback::{CleanUp, read_take};
use rhytid::solve::solve;
use rhytid::{Result, Rig, Stage, UploadOptions};
use std::path::Path;
use std::time::Instant;

const FRAMES: usize = 800;
const BATCH: usize = 32;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (rig, handles) = match &words[..] {
        [] => made()?,
        [rig, take, ..] => read(Path::new(rig), Path::new(take))?,
        [_] => {
            eprintln!("give a rig file, a take, and, if you like, a device; or nothing");
            std::process::exit(2);
        }
    };
    let device = find_device(words.get(2).map_or("cpu:0", String::as_str), Guard::NONE)?;
    let backend = backends::open(&device)?;
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    println!("{} vertices, on {} ({})", rig.vertices(), device.id(), device.name);
    println!(
        "{:<10} {:>9} {:>10} {:>10} {:>12} {:>12} {:>12} {:>12}",
        "", "MB there", "upload, s", "ms a frame", "32 at once", "worst, mm", "marker, mm", "normals, °"
    );
    let mut exact: Option<Frames> = None;
    for basis in BasisStorage::ALL {
        let any = PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: u32::MAX };
        let bytes = Plan::new(&rig, UploadOptions { max_frames: 1, basis }, any, "any")?.bytes();
        let begin = Instant::now();
        let mut one = backend.upload(&rig, UploadOptions { max_frames: 1, basis })?;
        let upload = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        let singles = handles.chunks(3 * rig.handles().len()).take(2 * BATCH);
        let count = singles.len() as f64;
        let mut positions = Vec::new();
        for frame in singles {
            one.evaluate(frame)?;
            one.read(Stage::Strain, &mut positions)?;
        }
        let ms = 1e3 * begin.elapsed().as_secs_f64() / count;
        drop(one);

        let mut many = backend.upload(&rig, UploadOptions { max_frames: BATCH, basis })?;
        let mut found = Frames::default();
        let mut seconds = 0.0;
        for frames in handles.chunks(BATCH * 3 * rig.handles().len()) {
            let begin = Instant::now();
            many.evaluate(frames)?;
            many.read(Stage::Strain, &mut positions)?;
            seconds += begin.elapsed().as_secs_f64();
            many.read(Stage::Positions, &mut positions)?;
            found.positions.extend_from_slice(positions.as_chunks().0);
            many.read(Stage::Normals, &mut positions)?;
            found.normals.extend_from_slice(positions.as_chunks().0);
        }
        let frames = handles.len() / (3 * rig.handles().len());
        let in_batch = 1e3 * seconds / frames as f64;
        let exact = exact.get_or_insert_with(|| found.clone());
        let worst = apart(&found.positions, &exact.positions).fold(0.0, f64::max);
        let squares: f64 = apart(&found.normals, &exact.normals).map(|off| off * off).sum();
        // The chord of a small angle is about as long as the angle.
        let turned = (squares / found.normals.len() as f64).sqrt().to_degrees();
        let marker = found.off_markers(&rig, &handles);
        println!(
            "{:<10} {:>9.1} {upload:>10.2} {ms:>10.2} {in_batch:>12.2} {:>12.4} {:>12.5} {turned:>12.4}",
            basis.name(),
            bytes as f64 / 1e6,
            worst * millimetres,
            marker * millimetres,
        );
    }
    Ok(())
}

/// The vertices of all frames, V each.
#[derive(Default, Clone)]
struct Frames {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Frames {
    /// How far a handle is from its marker at most.
    fn off_markers(&self, rig: &Rig, markers: &[f32]) -> f64 {
        let frames = self.positions.chunks(rig.vertices());
        let at = |frame| rig.handles().points.iter().map(move |point| point.at(frame));
        let held: Vec<[f32; 3]> = frames.flat_map(at).collect();
        apart(&held, markers.as_chunks().0).fold(0.0, f64::max)
    }
}

fn apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> impl Iterator<Item = f64> {
    a.iter().zip(b).map(|(a, b)| {
        let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
        squares.sum::<f64>().sqrt()
    })
}

/// A face that is made in code, and its take.
fn made() -> Result<(Rig, Vec<f32>)> {
    let face = rhytid_demo::face(9_409);
    let rig = solve(&face, &NoProgress)?.rounded()?;
    let take = rhytid_demo::performance(&face);
    let handles = take.handle_positions(&rig.handles().labels)?;
    Ok((rig, handles))
}

/// A rig, and frames of a take that are evenly spaced.
fn read(rig: &Path, take: &Path) -> Result<(Rig, Vec<f32>)> {
    let rig = rig_file::read(rig)?;
    let take = read_take(take, &rig, Missing::default(), &CleanUp::default(), &NoProgress)?.take;
    let handles = take.handle_positions(&rig.handles().labels)?;
    let frames: Vec<&[f32]> = handles.chunks(3 * rig.handles().len()).collect();
    let count = FRAMES.min(frames.len());
    let chosen = (0..count).flat_map(|i| frames[i * frames.len() / count]).copied().collect();
    Ok((rig, chosen))
}
