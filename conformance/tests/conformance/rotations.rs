//! Rotations of the handles: the motions that stay exact, and the distance of faces from the truth with and
//! without rotations.
use crate::support::random_face::faces_for_both_methods;
use crate::support::real;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{Numbers, evaluate, worst_difference};
use rhytid_core::{
    Animator, Backend, Face, Handles, LearnedSettings, Method, NoProgress, Rig, Settings, Stage,
    SurfacePoint, UploadOptions, VertexId,
};
use rhytid_solve::solve;
use rhytid_test_support::shared;
use std::collections::BTreeSet;

/// The same face with turning handles. Those inside triangles are at the nearest vertex instead, because two
/// or three handles alone would not tell how the face turns.
fn turning(mut face: Face) -> Face {
    let vertices: BTreeSet<VertexId> = face.handles.points.iter().map(SurfacePoint::nearest_vertex).collect();
    face.handles = Handles {
        labels: vertices.iter().map(|v| format!("m{v}")).collect(),
        points: vertices.into_iter().map(SurfacePoint::from).collect(),
    };
    face.settings.rotations = true;
    if let Method::Learned(learned) = &mut face.settings.method {
        learned.share = Some(1.0);
    }
    face
}

fn handles_at_rest(rig: &Rig<f64>) -> Vec<[f64; 3]> {
    rig.handles().rest.clone()
}

fn worst(found: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    worst_difference(found.as_flattened(), expected.as_flattened()).size
}

fn size(face: &Face) -> f64 {
    let [low, high] = face.neutral.bounds().unwrap().map(DVec3::from_array);
    high.distance(low)
}

/// The large scale of a frame on the CPU backend, which has the bits of the f32 reference.
fn on_cpu(rig: &Rig<f64>, handles: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, &rig.rounded().unwrap(), UploadOptions::frames(1)).unwrap();
    let handles: Vec<f32> = handles.as_flattened().iter().map(|&x| x as f32).collect();
    animator.evaluate(&handles).unwrap();
    let mut found = Vec::new();
    animator.read(Stage::LargeScale, &mut found).unwrap();
    found.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn markers_and_the_rest_pose_are_met(face in faces_for_both_methods(), seed: u64) {
        let face = turning(face);
        let rig = solve(&face, &NoProgress).unwrap();
        let rest = handles_at_rest(&rig);
        let results = evaluate(&rig, &rest);
        prop_assert!(worst(&results.large_scale, &rig.surface().rest) < 1e-14 * size(&face));
        prop_assert_eq!(evaluate(&rig.clone().shell().unwrap(), &rest).positions, rig.surface().rest.clone());
        prop_assert!(worst(&results.positions, &rig.surface().rest) < 1e-10 * size(&face));
        let mut numbers = Numbers::new(seed);
        let pose: Vec<[f64; 3]> = rest.iter().map(|p| p.map(|c| c + 2.0 * numbers.signed())).collect();
        let results = evaluate(&rig, &pose);
        for positions in [&results.large_scale, &results.positions] {
            let found: Vec<[f64; 3]> = rig.handles().points.iter().map(|point| point.at(positions)).collect();
            prop_assert!(worst(&found, &pose) < 1e-12 * size(&face));
        }
    }

    /// Exact up to rounding in f64, and to a hundred-thousandth of the face in f32, which devices use.
    #[test]
    fn a_rigid_motion_of_170_degrees_is_rigid(face in faces_for_both_methods(), seed: u64) {
        let mut face = turning(face);
        face.examples.clear();
        let rig = solve(&face, &NoProgress).unwrap();
        let mut numbers = Numbers::new(seed);
        let axis = DVec3::new(numbers.signed(), numbers.signed(), 1.0 + numbers.unit()).normalize();
        let turn = DQuat::from_axis_angle(axis, 170f64.to_radians());
        let shift = 5.0 * DVec3::new(numbers.signed(), numbers.signed(), numbers.signed());
        let moved = |ps: &[[f64; 3]]| -> Vec<[f64; 3]> {
            ps.iter().map(|p| (turn * DVec3::from_array(*p) + shift).to_array()).collect()
        };
        let pose = moved(&handles_at_rest(&rig));
        let mut expected = moved(&rig.surface().rest);
        for ((row, rest), expected) in rig.basis().rows().zip(&rig.surface().rest).zip(&mut expected) {
            if row.iter().all(|b| *b == 0.0) {
                *expected = *rest;
            }
        }
        let found = evaluate(&rig, &pose).large_scale;
        prop_assert!(worst(&found, &expected) < 1e-7 * size(&face));
        prop_assert!(worst(&on_cpu(&rig, &pose), &expected) < 1e-5 * size(&face));
    }
}

/// RMS, 99.9th percentile and largest of the distances in mm, of the large scale and of all.
fn errors(rig: &Rig<f64>, frames: &[usize], truth: &[f32], handles: &[[f64; 3]]) -> [[f64; 3]; 2] {
    let (h, v) = (rig.handles().len(), rig.vertices());
    let mut distances = [const { Vec::new() }; 2];
    for (&frame, truth) in frames.iter().zip(truth.as_chunks::<3>().0.chunks_exact(v)) {
        let results = evaluate(rig, &handles[frame * h..][..h]);
        for (distances, positions) in distances.iter_mut().zip([results.large_scale, results.positions]) {
            let off = positions.iter().zip(truth);
            distances.extend(
                off.map(|(x, t)| 10.0 * (0..3).map(|c| (x[c] - f64::from(t[c])).powi(2)).sum::<f64>().sqrt()),
            );
        }
    }
    distances.map(|mut all| {
        all.sort_by(f64::total_cmp);
        let rms = (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt();
        [rms, all[(0.999 * all.len() as f64) as usize], all[all.len() - 1]]
    })
}

/// Rotations do not improve faces, so a project has to ask for them. Far from all handles the rotation of the
/// last handles continues. The examples are reproduced as well as without rotations.
#[test]
fn an_unseen_capture_is_no_nearer() {
    let Some(shared) = shared("") else { return };
    let (frames, truth) = real::truth(&shared);
    let found = [false, true].map(|rotations| {
        let face = real::face(&shared, "face", Settings { rotations, ..Settings::default() });
        let rig = solve(&face, &NoProgress).unwrap();
        let handles = real::clean_handles(&shared, &rig);
        let found = errors(&rig, &frames, &truth, &handles);
        println!(
            "rotations {rotations}: RMS, 99.9 % and worst of the large scale {:.3?} mm, of all {:.3?} mm",
            found[0], found[1]
        );
        for example in &face.examples {
            let handles: Vec<[f64; 3]> =
                rig.handles().points.iter().map(|point| point.at(&example.positions)).collect();
            let off = 10.0 * worst(&evaluate(&rig, &handles).positions, &example.positions);
            assert!(off < 0.02, "{}: {off} mm", example.name);
        }
        found[1]
    });
    assert!((found[0][0] - 0.157).abs() < 0.001, "{found:?}");
    assert!(found[1][0] > found[0][0] && found[1][0] < 0.25, "{found:?}");
}

/// Without the clamp the learned part goes into the basis, which also blends rotations.
#[test]
fn a_share_below_1_is_refused() {
    for reach in [None, Some(f64::INFINITY)] {
        let mut face = crate::support::random_face::random_face(1, 7, 8, 2, 0.1, false);
        face.settings.method =
            Method::Learned(LearnedSettings { share: Some(0.2), reach, ..LearnedSettings::default() });
        face.settings.rotations = true;
        let error = solve(&face, &NoProgress).unwrap_err().to_string();
        assert!(error.contains("rotations go with share = 1 alone"), "{error}");
        face.settings.rotations = false;
        solve(&face, &NoProgress).unwrap();
    }
}
