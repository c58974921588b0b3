//! What moves: positions, normals, the head.

use super::cases::{Case, animation, cases, head};
use super::tools::unfold;
use super::viewer::{Matrix, Vector, Viewer, transform};
use crate::animation::{Animation, UvKind};
use rhytid_core::{RigidMotion, UpAxis};
use rhytid_formats::export::{Options, Written};
use std::path::PathBuf;

/// Every case as it was written, and as three.js unfolds it.
fn written(folder: &std::path::Path) -> Vec<(Case, Written, Viewer)> {
    let cases = cases();
    let (files, written): (Vec<PathBuf>, Vec<Written>) = cases.iter().map(|case| case.export(folder)).unzip();
    let viewers = unfold(&files).into_iter().map(|file| Viewer::open(&file));
    cases
        .into_iter()
        .zip(written)
        .zip(viewers)
        .map(|((case, written), viewer)| (case, written, viewer))
        .collect()
}

/// Along the mesh's axes, along glTF's.
fn y_up([x, y, z]: Vector, up_axis: UpAxis) -> Vector {
    if up_axis == UpAxis::Z { [x, z, -y] } else { [x, y, z] }
}

fn distance(a: Vector, b: Vector) -> f64 {
    glam::DVec3::from(a).distance(b.into())
}

#[test]
fn every_vertex_is_within_the_stated_distance_in_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    for (Case { animation, options, label, .. }, written, viewer) in written(folder.path()) {
        let unit = animation.metres_per_unit;
        let error = written.errors[0];
        let (mut worst, mut at_stated, mut sum) = (0.0_f64, 0.0_f64, 0.0);
        for (k, [positions, _]) in animation.frames.iter().enumerate() {
            let shown = viewer.frame(k);
            for (w, shown) in shown.iter().enumerate() {
                let v = viewer.ids[w] as usize;
                let given = std::array::from_fn(|axis| unit * f64::from(positions[3 * v + axis]));
                let off = distance(*shown, y_up(given, animation.up_axis)) / unit;
                if w < animation.rest.len() {
                    sum += off * off;
                }
                worst = worst.max(off);
                if (k, v) == error.at {
                    at_stated = at_stated.max(off);
                }
            }
        }
        let rms = (sum / (animation.rest.len() * animation.frames.len()) as f64).sqrt();
        assert!(worst <= error.worst, "{label}: {worst}, stated {error:?}");
        // The stated error includes the rounding of a reader's 32-bit arithmetic.
        let rounding = 3.0_f64.sqrt() * 8.0 * 12.0 * f64::from(f32::EPSILON);
        assert!((rms - error.rms).abs() < rounding, "{label}: rms {rms}, stated {error:?}");
        let bound = match (options.max_error, options.quantize) {
            (Some(max_error), _) => max_error,
            // Half a step of a grid of 65,533 over 14 units, along three axes.
            (None, true) => 14.0 / 65_533.0 / 2.0 * 3.0_f64.sqrt() + rounding,
            (None, false) => rounding,
        };
        assert!(error.worst <= bound, "{label}: {error:?}, expected {bound} at most");
        // What is stated is no empty phrase.
        if options.max_error.is_none() && options.quantize && animation.frames.len() > 1 {
            assert!(worst > bound / 8.0, "{label}: {worst}, stated {error:?}");
            assert!(at_stated >= worst - rounding, "{label}: {worst}, {at_stated} at the stated {error:?}");
        }
        let extras = &viewer.scene_extras()["error"];
        assert_eq!(extras["frame"], error.at.0, "{label}");
        assert_eq!(extras["vertex"], error.at.1, "{label}");
        let stated = extras["worstMillimetres"].as_f64().unwrap();
        assert!((stated - error.worst * unit * 1000.0).abs() <= 1e-12 * stated, "{label}");
    }
}

#[test]
fn exact_files_begin_with_the_first_frame_and_show_one_target_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    for (Case { animation, options, label, .. }, written, viewer) in written(folder.path()) {
        let frames = animation.frames.len();
        for (k, &time) in viewer.times.iter().enumerate() {
            assert_eq!(time, f64::from((k as f64 / animation.rate) as f32), "{label}");
        }
        assert_eq!(written.targets, Some(viewer.targets.len()), "{label}");
        assert!(viewer.weights.iter().all(|w| (0.0..=1.0).contains(w)), "{label}");
        // Where nothing is played, the first frame is shown. Some programs need these weights.
        let first = viewer.weights.get(..viewer.targets.len()).unwrap_or_default();
        assert_eq!(viewer.weights_at_rest, first, "{label}");
        if options.max_error.is_some() {
            assert!(viewer.targets.len() <= frames, "{label}");
            continue;
        }
        assert_eq!((viewer.targets.len(), viewer.times.len()), (frames, frames), "{label}");
        assert_eq!(viewer.weights.len(), frames * frames);
        for (i, weight) in viewer.weights.iter().enumerate() {
            assert_eq!(*weight, if i / frames == i % frames { 1.0 } else { 0.0 }, "{label}");
        }
        assert!(viewer.targets[0].0.as_flattened().iter().all(|&x| x == 0.0), "{label}");
        if !options.quantize {
            let first = animation.frames[0][0].as_chunks::<3>().0;
            for (w, position) in viewer.positions.iter().enumerate() {
                assert_eq!(*position, first[viewer.ids[w] as usize].map(f64::from), "{label}");
            }
        }
    }
}

#[test]
fn normals_are_there_when_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    for (Case { animation, options, label, .. }, _, viewer) in written(folder.path()) {
        let asked = animation.with_normals;
        assert_eq!(viewer.normals.is_some(), asked, "{label}");
        assert!(viewer.targets.iter().all(|(_, normals)| normals.is_some() == asked), "{label}");
        if !asked || options.max_error.is_some() {
            continue;
        }
        for (k, [_, normals]) in animation.frames.iter().enumerate() {
            for (w, shown) in viewer.normals(k).into_iter().enumerate() {
                let v = viewer.ids[w] as usize;
                let given: Vector = std::array::from_fn(|axis| f64::from(normals[3 * v + axis]));
                // The last vertex has no area: its normal is glTF's to choose, and stays.
                let expected = if given == [0.0; 3] { [0.0, 0.0, 1.0] } else { given };
                let off = distance(shown, expected);
                // The frames' normals are random: some turn to where 8 bits leave little room.
                let base = viewer.normals.as_ref().unwrap()[w];
                let cosine: f64 = base.iter().zip(expected).map(|(a, b)| a * b).sum();
                let bound = match options.quantize {
                    false => 1e-6,
                    true if cosine > 0.3 => 0.06,
                    true => continue,
                };
                assert!(
                    off <= bound,
                    "{label}: normal {shown:?} of vertex {v} in frame {k}, expected {given:?}"
                );
            }
        }
    }
}

#[test]
fn normals_that_turn_little_are_within_a_degree_when_quantised() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let mut animation = animation(UvKind::None, 4, 41);
    let first = animation.frames[0][1].clone();
    for (k, [_, normals]) in animation.frames.iter_mut().enumerate() {
        for (n, first) in normals.as_chunks_mut::<3>().0.iter_mut().zip(first.as_chunks::<3>().0) {
            let [x, y, z] = *first;
            let (sin, cos) = (0.25 * k as f32).sin_cos();
            *n = [cos * x - sin * y, sin * x + cos * y, z];
        }
    }
    animation.export_with(&path, &Options { quantize: true, ..Options::default() }).unwrap();
    let viewer = Viewer::open(&path);
    for (k, [_, normals]) in animation.frames.iter().enumerate() {
        for (v, (shown, given)) in
            viewer.normals(k).iter().zip(normals.as_chunks::<3>().0).enumerate().take(33)
        {
            let off = distance(*shown, given.map(f64::from));
            assert!(off < 1.0_f64.to_radians(), "vertex {v} in frame {k}: {shown:?}, expected {given:?}");
        }
    }
}

#[test]
fn the_head_moves_as_it_does_in_the_take() {
    let folder = tempfile::tempdir().unwrap();
    for (Case { animation, label, .. }, _, viewer) in written(folder.path()) {
        let Some(expected) = &animation.head else {
            assert!(viewer.head.is_none(), "{label}");
            continue;
        };
        let (rotations, translations) = viewer.head.as_ref().expect(&label);
        assert_eq!((rotations.len(), translations.len()), (expected.len(), expected.len()), "{label}");
        for (k, motion) in expected.iter().enumerate() {
            let shown = matrix(rotations[k], translations[k]);
            // A point of the face, and where it is in the world.
            let point = [7.0, -3.0, 11.0];
            let rows = motion.matrix();
            let moved = std::array::from_fn(|i| {
                rows[i][0] * point[0] + rows[i][1] * point[1] + rows[i][2] * point[2] + rows[i][3]
            });
            let metres = |p: Vector| y_up(p.map(|x| x * animation.metres_per_unit), animation.up_axis);
            let off = distance(transform(&shown, metres(point)), metres(moved)) / animation.metres_per_unit;
            assert!(off < 1e-5, "{label}: {off} in frame {k}");
        }
        // Viewers that mix the numbers go the shorter way.
        for pair in rotations.windows(2) {
            let dot: f64 = pair[0].iter().zip(pair[1]).map(|(a, b)| a * b).sum();
            assert!(dot > 0.0, "{label}: {pair:?}");
        }
    }
}

fn matrix(rotation: [f64; 4], translation: Vector) -> Matrix {
    let rows = RigidMotion { rotation, translation }.matrix();
    std::array::from_fn(|column| std::array::from_fn(|row| rows[row][column]))
}

#[test]
fn what_does_not_move_is_a_plain_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let mut still = animation(UvKind::PerCorner, 4, 42);
    let first = still.frames[0].clone();
    still.frames.fill(first);
    for max_error in [None, Some(0.01)] {
        for quantize in [false, true] {
            for with_head in [false, true] {
                let path = folder.path().join("face.glb");
                let still = Animation { head: with_head.then(|| head(4)), ..still.clone() };
                let options = Options { max_error, quantize, ..Options::default() };
                let written = still.export_with(&path, &options).unwrap();
                let viewer = Viewer::open(&path);
                assert_eq!(written.targets, Some(if max_error.is_some() { 0 } else { 4 }));
                assert_eq!(viewer.times.is_empty(), max_error.is_some() && !with_head);
                assert_eq!(viewer.scene_extras()["frames"], 4);
                let mut reader = rhytid_formats::animation::open(&path).unwrap();
                let mut out = Vec::new();
                reader.positions(3, &mut out).unwrap();
                let off = out.iter().zip(&still.frames[3][0]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off < 2e-4, "{options:?}: {off}");
            }
        }
    }
}
