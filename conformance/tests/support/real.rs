//! Real faces and takes, from the folder beside the project.
use rhytid_core::{Example, Face, Method, NoProgress, Rig, Settings, Take, UpAxis};
use rhytid_formats::{mesh, tables, take};
use rhytid_solve::solve;
use std::path::Path;
use std::sync::OnceLock;

/// The face or head in a folder of the shared data, with its eight examples.
pub(crate) fn face(shared: &Path, folder: &str, settings: Settings) -> Face {
    let folder = shared.join("data").join(folder);
    let neutral_path = folder.join("neutral.obj");
    let neutral = mesh::read(&neutral_path).unwrap();
    let mut poses: Vec<_> =
        std::fs::read_dir(folder.join("poses")).unwrap().map(|entry| entry.unwrap().path()).collect();
    poses.sort();
    assert_eq!(poses.len(), 8, "poses found: {poses:?}");
    let examples = poses
        .iter()
        .map(|path| Example {
            mirror: false,
            name: path.file_stem().unwrap().to_string_lossy().into_owned(),
            positions: mesh::read_like(&neutral, &neutral_path, path).unwrap(),
            noise: None,
        })
        .collect();
    Face {
        name: "face".into(),
        neutral,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: tables::read_handles(&shared.join("data/markers.csv")).unwrap(),
        examples,
        prior: None,
        settings,
    }
}

/// The settings of the chapter's method for which an independent implementation gave its errors.
pub(crate) fn settings() -> Settings {
    Settings { bending_length: Some(3.0), method: Method::Chapter, ..Settings::default() }
}

/// The face with [`settings`] and its rig, solved once for all tests.
pub(crate) fn solved_face(shared: &Path) -> &'static (Face, Rig<f64>) {
    static SOLVED: OnceLock<(Face, Rig<f64>)> = OnceLock::new();
    SOLVED.get_or_init(|| {
        let face = face(shared, "face", settings());
        let rig = solve(&face, &NoProgress).unwrap();
        (face, rig)
    })
}

/// The take without noise, for the rig's handles.
pub(crate) fn clean_take(shared: &Path, rig: &Rig<f64>) -> Take {
    let path = shared.join("data/takes/rom_3_clean.csv");
    take::read(&path, Some(&rig.handles().labels), take::Missing::Error).unwrap()
}

/// Frames of [`clean_take`] with a truth, and the face's positions in them, frames × 9409 × 3 in cm.
pub(crate) fn truth(shared: &Path) -> (Vec<usize>, Vec<f32>) {
    let bytes = std::fs::read(shared.join("data/truth/rom_3.npy")).unwrap();
    let npy = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(npy.shape(), [100, 9409, 3]);
    let list = std::fs::read_to_string(shared.join("data/truth/rom_3_frames.csv")).unwrap();
    let frames: Vec<usize> =
        list.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
    assert_eq!(frames.len(), 100);
    (frames, npy.into_vec().unwrap())
}

/// The handle positions in every frame of [`clean_take`], frames × H.
pub(crate) fn clean_handles(shared: &Path, rig: &Rig<f64>) -> Vec<[f64; 3]> {
    let markers = clean_take(shared, rig).handle_positions(&rig.handles().labels).unwrap();
    markers.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect()
}
