//! Real faces, their rigs, and frames of rigs.
use rhytid_core::{
    DeviceInfo, Example, Face, Handles, NoProgress, Rig, Settings, SurfacePoint, Table, UpAxis,
};
use rhytid_devices::{Guard, choose_devices};
use rhytid_formats::export::OutputStage;
use rhytid_formats::{mesh, tables};
use rhytid_playback::Playback;
use rhytid_solve::{Smoothing, solve};
use std::path::Path;

/// The CPU as a device.
pub(crate) fn processor() -> Vec<DeviceInfo> {
    choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices
}

/// `data/{name}` with its poses and the 89 handles of the capture.
pub(crate) fn face(shared: &Path, name: &str) -> Face {
    let folder = shared.join("data").join(name);
    let path = folder.join("neutral.obj");
    let neutral = mesh::read(&path).unwrap();
    let mut poses: Vec<_> =
        std::fs::read_dir(folder.join("poses")).unwrap().map(|entry| entry.unwrap().path()).collect();
    poses.sort();
    let example = |pose: std::path::PathBuf| Example {
        name: pose.file_stem().unwrap().to_string_lossy().into_owned(),
        positions: mesh::read_like(&neutral, &path, &pose).unwrap(),
        mirror: false,
        noise: None,
    };
    Face {
        name: name.into(),
        examples: poses.into_iter().map(example).collect(),
        neutral,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: tables::read_handles(&shared.join("data/markers.csv")).unwrap(),
        prior: None,
        settings: Settings::default(),
    }
}

/// Another face of the same kind with this neutral and these handles, without examples.
pub(crate) fn bare(of: &Face, neutral: rhytid_core::Mesh, points: Vec<SurfacePoint>) -> Face {
    let handles = Handles { labels: of.handles.labels.clone(), points };
    Face { name: "second".into(), neutral, handles, examples: Vec::new(), ..of.clone() }
}

/// The rig, rounded as in a file.
pub(crate) fn rig(face: &Face) -> Rig {
    solve(face, &NoProgress).unwrap().rounded().unwrap()
}

/// The positions of some frames.
pub(crate) fn played(rig: &Rig, handles: &[f32], stage: OutputStage) -> Vec<Vec<[f64; 3]>> {
    let mut frames = Vec::new();
    let count = handles.len() / 3 / rig.handles().len();
    let mut playback = Playback::new(rig, &processor(), count).unwrap();
    let each = |positions: &[f32], _: &[f32]| {
        frames.push(positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect());
        Ok(())
    };
    playback.evaluate(handles, stage, false, &NoProgress, each).unwrap();
    frames
}

/// The root mean square and the largest of the lengths of some vectors.
pub(crate) fn rms(vectors: impl Iterator<Item = [f64; 3]>) -> [f64; 2] {
    let (mut sum, mut count, mut worst) = (0.0, 0, 0.0_f64);
    for v in vectors {
        let square: f64 = v.iter().map(|x| x * x).sum();
        sum += square;
        count += 1;
        worst = worst.max(square);
    }
    [(sum / f64::from(count)).sqrt(), worst.sqrt()]
}

/// a − b.
pub(crate) fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] - b[c])
}

/// The wrinkles in positions of the rig's examples.
///
/// They are the residual after the rig's shell, without parts as wide as a quarter of the handles' spacing.
pub(crate) fn wrinkles(rig: &Rig, full: &[Vec<[f64; 3]>]) -> Vec<Vec<[f64; 3]>> {
    let shell = played(
        &rig.clone().shell().unwrap(),
        rig.examples().handles.as_slice().as_flattened(),
        OutputStage::Shell,
    );
    let rest_lengths = rig.handles().rest_lengths();
    let spacing = rest_lengths.iter().map(|x| f64::from(*x)).sum::<f64>() / rest_lengths.len() as f64;
    let smoothing = Smoothing::over(&rig.widened(), 0.25 * spacing, &NoProgress).unwrap();
    let of_example = |(full, shell): (&Vec<[f64; 3]>, &Vec<[f64; 3]>)| {
        let left: Vec<[f64; 3]> = full.iter().zip(shell).map(|(x, y)| minus(x, y)).collect();
        let mut wide = Table::new(left.len(), 1, left.clone());
        smoothing.apply(&mut wide, &NoProgress).unwrap();
        left.iter().zip(wide.as_slice()).map(|(x, y)| minus(x, y)).collect()
    };
    full.iter().zip(&shell).map(of_example).collect()
}
