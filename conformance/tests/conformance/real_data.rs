//! A real face and a real head with a real take: the method's promises, and its distance from the truth.

use crate::support::real::{self, clean_take, face, settings, solved_face};
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{evaluate, worst_difference};
use rhytid_core::{
    Animator, Backend, BasisStorage, Bind, ClusteredBasis, Face, Method, NoProgress, Rig, Settings, Stage,
    UploadOptions,
};
use rhytid_solve::solve;
use rhytid_test_support::shared;
use std::path::Path;

/// Millimetres in the data's unit, the centimetre.
const MM: f64 = 10.0;

/// Vertices of the face that are compared with the truth: the skin without its inner rims.
const COMPARED: usize = 6706;

/// Asserts that each example's own markers reproduce it, and that every marker of the take is met in every
/// frame. The limit is 0.01 mm.
fn check(shared: &Path, face: &Face, rig: &Rig<f64>) {
    let h = rig.handles().len();
    let batch = 31;
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, &rig.rounded().unwrap(), UploadOptions::frames(batch)).unwrap();
    let mut found = Vec::new();
    let mut compared = 0;
    for example in &face.examples {
        let handles = rig.handles().at(&example.positions);
        let results = evaluate(rig, &handles);
        let handles: Vec<f32> = handles.as_flattened().iter().map(|&x| x as f32).collect();
        animator.evaluate(&handles).unwrap();
        animator.read(Stage::Positions, &mut found).unwrap();
        let (on_cpu, _) = found.as_chunks::<3>();
        let moving: Vec<usize> =
            (0..rig.vertices()).filter(|&v| rig.basis().row(v).iter().any(|&b| b != 0.0)).collect();
        let apart: Vec<usize> =
            moving.iter().copied().filter(|&v| crate::support::told_apart(rig, v, 0.01)).collect();
        let expected: Vec<[f64; 3]> = apart.iter().map(|&v| example.positions[v]).collect();
        let reference: Vec<[f64; 3]> = apart.iter().map(|&v| results.positions[v]).collect();
        let cpu: Vec<[f32; 3]> = apart.iter().map(|&v| on_cpu[v]).collect();
        let reference = MM * worst_difference(reference.as_flattened(), expected.as_flattened()).size;
        let cpu = MM * worst_difference(cpu.as_flattened(), expected.as_flattened()).size;
        println!(
            "{}: given back within {reference:.1e} mm by the reference, {cpu:.1e} by cpu:0, at {} of {} moving vertices",
            example.name,
            apart.len(),
            moving.len()
        );
        assert!(
            reference.max(cpu) < 0.01,
            "{} is off by {reference} mm (reference), {cpu} mm (cpu:0)",
            example.name
        );
        compared += apart.len();
    }
    assert!(compared > rig.vertices() / 4, "only {compared} vertices told the poses apart");

    let take = clean_take(shared, rig);
    assert_eq!(take.frames(), 4030);
    let markers = take.handle_positions(&rig.handles().labels).unwrap();
    let mut worst = [0.0f64; 2];
    for frames in markers.chunks(batch * 3 * h) {
        animator.evaluate(frames).unwrap();
        for (worst, stage) in worst.iter_mut().zip([Stage::LargeScale, Stage::Positions]) {
            animator.read(stage, &mut found).unwrap();
            let at: Vec<f32> = found
                .chunks_exact(3 * rig.vertices())
                .flat_map(|frame| {
                    rig.handles().points.iter().flat_map(|point| point.at(frame.as_chunks::<3>().0))
                })
                .collect();
            *worst = worst.max(MM * worst_difference(&at, frames).size);
        }
    }
    println!(
        "markers of {} frames met within {:.1e} (large scale) and {:.1e} mm",
        take.frames(),
        worst[0],
        worst[1]
    );
    assert!(worst.iter().all(|w| *w < 0.01), "a marker is missed by {worst:?} mm");
    check_clusters(rig, &markers[..800 * 3 * h]);
}

/// Asserts that a basis in clusters has the large scale of the whole one, to its bound, and meets the
/// markers.
/// The details of these rigs turn with the surface, which magnifies the difference.
fn check_clusters(rig: &Rig<f64>, markers: &[f32]) {
    let h = rig.handles().len();
    let batch = 32;
    let rounded = rig.rounded().unwrap();
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animators = [BasisStorage::F32, BasisStorage::Clustered]
        .map(|basis| Animator::new(&cpu, &rounded, UploadOptions { max_frames: batch, basis }).unwrap());
    let rest = rounded.handles().rest.as_flattened().iter().cycle();
    let farthest = markers.iter().zip(rest).map(|(x, rest)| f64::from((x - rest).abs())).fold(0.0, f64::max);
    let stages = [Stage::LargeScale, Stage::Positions, Stage::Normals];
    let (mut worst, mut worst_marker, mut turned, mut count) = ([0.0_f64; 2], 0.0_f64, 0.0_f64, 0);
    for frames in markers.chunks(batch * 3 * h) {
        let results = animators.each_mut().map(|animator| {
            animator.evaluate(frames).unwrap();
            stages.map(|stage| {
                let mut out = Vec::new();
                animator.read(stage, &mut out).unwrap();
                out
            })
        });
        let [whole, clustered] = &results;
        for (worst, (a, b)) in worst.iter_mut().zip(whole.iter().zip(clustered)) {
            *worst = worst.max(worst_difference(a, b).size);
        }
        for (frame, markers) in clustered[1].chunks_exact(3 * rig.vertices()).zip(frames.chunks_exact(3 * h))
        {
            let positions = frame.as_chunks::<3>().0;
            let at: Vec<f32> =
                rounded.handles().points.iter().flat_map(|point| point.at(positions)).collect();
            worst_marker = worst_marker.max(worst_difference(&at, markers).size);
        }
        // The chord of a small angle is about as long as the angle.
        let squares = whole[2].iter().zip(&clustered[2]).map(|(a, b)| f64::from(a - b).powi(2));
        turned += squares.sum::<f64>();
        count += whole[2].len() / 3;
    }
    // Positions are rounded as well.
    let bound = ClusteredBasis::LARGEST_ERROR * farthest + 3e-6 * farthest;
    println!(
        "in clusters: the large scale is within {:.1e} mm where the bound is {:.1e} mm, positions within \
         {:.1e} mm, markers within {:.1e} mm, normals within {:.4}° RMS",
        MM * worst[0],
        MM * bound,
        MM * worst[1],
        MM * worst_marker,
        (turned / f64::from(count as u32)).sqrt().to_degrees()
    );
    assert!(worst[0] > 0.0 && worst[0] < bound, "{worst:?} with a bound of {bound}");
    assert!(MM * worst[1] < 0.1, "{} mm", MM * worst[1]);
    assert!(MM * worst_marker < 0.01, "a marker is missed by {} mm", MM * worst_marker);
}

#[test]
fn the_face_meets_its_markers_and_gives_its_examples_back() {
    let Some(shared) = shared("") else { return };
    let (face, rig) = solved_face(&shared);
    assert_eq!(rig.handles().strain_edges.len(), 236);
    check(&shared, face, rig);
}

#[test]
fn the_head_meets_its_markers_and_gives_its_examples_back() {
    let Some(shared) = shared("") else { return };
    let mut face = face(&shared, "head", settings());
    let rigid = solve(&face, &NoProgress).unwrap();
    check(&shared, &face, &rigid);
    face.settings.bind = Bind::Nearest;
    let bound = solve(&face, &NoProgress).unwrap();
    assert!(bound.basis().rows().all(|row| (row.iter().sum::<f64>() - 1.0).abs() < 1e-9));
    check(&shared, &face, &bound);
}

/// RMS distances from the truth in mm, for large scale and full.
fn errors_to_the_truth(shared: &Path, rig: &Rig<f64>) -> [f64; 2] {
    let (frames, truth) = real::truth(shared);
    let markers = real::clean_handles(shared, rig);
    let mut sums = [0.0; 2];
    for (&frame, truth) in frames.iter().zip(truth.chunks_exact(9409 * 3)) {
        let h = rig.handles().len();
        let results = evaluate(rig, &markers[frame * h..][..h]);
        for (sum, positions) in sums.iter_mut().zip([&results.large_scale, &results.positions]) {
            let compared = positions[..COMPARED].as_flattened().iter().zip(truth);
            *sum += compared.map(|(x, t)| (x - f64::from(*t)).powi(2)).sum::<f64>();
        }
    }
    sums.map(|sum| MM * (sum / (100 * COMPARED) as f64).sqrt())
}

#[test]
fn the_errors_to_the_truth_are_those_of_an_independent_implementation() {
    let Some(shared) = shared("") else { return };
    let (_, rig) = solved_face(&shared);
    let [large_scale, full] = errors_to_the_truth(&shared, rig);
    println!("RMS to the truth: large scale {large_scale:.3} mm, full {full:.3} mm");
    assert!((large_scale - 1.000).abs() < 0.002, "large scale: {large_scale:.4} mm");
    assert!((full - 0.484).abs() < 0.002, "full: {full:.4} mm");
}

#[test]
fn the_default_bending_length_is_nearly_as_good_as_any() {
    let Some(shared) = shared("") else { return };
    let mut face = face(&shared, "face", Settings { method: Method::Chapter, ..Settings::default() });
    let rig = solve(&face, &NoProgress).unwrap();
    let default = errors_to_the_truth(&shared, &rig);
    println!("bending_length {:.3} (default): {default:.3?} mm", rig.bending_length());
    let mut best = f64::MAX;
    for factor in [0.25, 0.5, 2.0, 4.0] {
        face.settings.bending_length = Some(factor * rig.bending_length());
        let errors = errors_to_the_truth(&shared, &solve(&face, &NoProgress).unwrap());
        println!("bending_length {:.3}: {errors:.3?} mm", factor * rig.bending_length());
        best = best.min(errors[1]);
    }
    assert!(default[1] < 1.05 * best, "{} mm, where {best} mm can be had", default[1]);
}
