//! The learned method against golden vectors by an independent implementation. Also its distance from the
//! truth on a capture that no example comes from.
use crate::support::golden_learned::{cases, diagonal, face, numbers, vectors};
use crate::support::real;
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{evaluate, worst_difference};
use rhytid_core::{
    Animator, Backend, Face, LearnedSettings, Method, NoProgress, Rig, Settings, Stage, UploadOptions,
    WrinkleStrains,
};
use rhytid_kernels::vec3;
use rhytid_solve::{Solved, solve, solve_in_full};
use rhytid_test_support::shared;
use std::path::Path;

/// Positions of the large scale and of all, frames × V, from the CPU backend with inputs in f32.
fn on_cpu(rig: &Rig<f64>, handle_positions: &[[f64; 3]]) -> [Vec<f32>; 2] {
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let frames = handle_positions.len() / rig.handles().len();
    let mut animator = Animator::new(&cpu, &rig.rounded().unwrap(), UploadOptions::frames(frames)).unwrap();
    let positions: Vec<f32> = handle_positions.as_flattened().iter().map(|&x| x as f32).collect();
    animator.evaluate(&positions).unwrap();
    [Stage::LargeScale, Stage::Positions].map(|stage| {
        let mut out = Vec::new();
        animator.read(stage, &mut out).unwrap();
        out
    })
}

#[test]
fn golden_frames_are_met_by_the_learned_method() {
    let cases = cases();
    let mut compared = 0;
    for (case, i) in cases.iter().zip(1..) {
        let face = face(case);
        let rig = solve(&face, &NoProgress).unwrap();
        // The learned part can be taken out again, in f32 too.
        let shell = numbers(&case["expected"]["shell_basis"]);
        assert!(worst_difference(rig.clone().shell().unwrap().basis().as_slice(), &shell).size < 1e-12);
        let of_f32 = rig.rounded().unwrap().shell().unwrap().widened();
        assert!(worst_difference(of_f32.basis().as_slice(), &shell).size < 1e-6);
        for frame in case["expected"]["frames"].as_array().unwrap() {
            let handle_positions = vectors(&frame["handle_positions"]);
            let results = evaluate(&rig, &handle_positions);
            let on_cpu = on_cpu(&rig, &handle_positions);
            let stages = [("large_scale", &results.large_scale), ("positions", &results.positions)];
            for ((what, reference), cpu) in stages.into_iter().zip(on_cpu) {
                let expected = numbers(&frame[what]);
                assert_eq!(reference.as_flattened().len(), expected.len());
                let off = worst_difference(reference.as_flattened(), &expected).size;
                assert!(off < 1e-9, "{i}: {what}: {off}");
                let off = worst_difference(&cpu, &expected).size / diagonal(&face);
                println!("{i}: {what}: cpu:0 within {off:.1e} of the diagonal");
                assert!(off < 2e-5, "{i}: {what}: {off} of the diagonal");
                compared += expected.len();
            }
        }
    }
    assert!(cases.is_empty() || compared == 2 * 5 * 3 * (240 + 277 + 221), "{compared}");
}

/// With eight examples. An independent implementation, which continues linearly to any frame, has 0.173 mm;
/// the chapter's method has 0.500.
#[test]
fn the_learned_method_is_three_times_closer_to_the_truth() {
    let Some(shared) = shared("") else { return };
    let face = real::face(&shared, "face", Settings::default());
    let Solved { rig, report, .. } = solve_in_full(&face, false, &NoProgress).unwrap();
    for candidate in &report.candidates {
        println!("{candidate:?}");
    }
    let chosen = report.candidates[0];
    assert_eq!((chosen.share, chosen.ridge, chosen.reach), (0.3, 1e-4, 1.5));

    let rest: Vec<[f64; 3]> = rig.handles().rest.clone();
    let at_rest = evaluate(&rig, &rest).positions;
    assert!(worst_difference(at_rest.as_flattened(), rig.surface().rest.as_flattened()).size < 1e-12);
    let [_, at_rest] = on_cpu(&rig, &rest);
    let off = worst_difference(&at_rest, rig.surface().rest.as_flattened()).size / diagonal(&face);
    assert!(off < 1e-6, "cpu:0 is off by {off} of the diagonal at rest");
    for example in &face.examples {
        let handles: Vec<[f64; 3]> =
            rig.handles().points.iter().map(|point| point.at(&example.positions)).collect();
        let [_, on_cpu] = on_cpu(&rig, &handles);
        let off = 10.0 * worst_difference(&on_cpu, example.positions.as_flattened()).size;
        println!("{}: {off:.4} mm", example.name);
        assert!(off < 0.02, "{}: {off} mm", example.name);
    }

    let (rms, worst) = off_the_truth(&shared, &rig);
    println!("RMS to the truth {rms:.3} mm, worst {worst:.2} mm");
    assert!(rms <= 0.16 && worst < 4.2, "{rms} mm, worst {worst} mm");
    // What the independent implementation chooses.
    let as_documented = LearnedSettings {
        share: Some(0.2),
        ridge: Some(1e-2),
        fade: false,
        reach: Some(f64::INFINITY),
        wrinkle_strains: WrinkleStrains::Lengths,
        ..LearnedSettings::default()
    };
    let settings = Settings { method: Method::Learned(as_documented), ..Settings::default() };
    let rig = solve(&Face { settings, ..face }, &NoProgress).unwrap();
    let (rms, worst) = off_the_truth(&shared, &rig);
    println!("without a bound {rms:.3} mm, worst {worst:.2} mm");
    assert!(rms < 0.18 && worst < 4.5, "{rms} mm, worst {worst} mm");
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Mirror images are no scans of this actor, whose own poses these are. They must not spoil the face.
#[test]
fn mirror_images_are_examples_like_others() {
    let Some(shared) = shared("") else { return };
    let mut face = real::face(&shared, "face", Settings::default());
    face.examples.iter_mut().for_each(|example| example.mirror = true);
    let rig = solve(&face, &NoProgress).unwrap();
    println!("{:?}", rig.examples().names);
    assert_eq!(rig.examples().names.len(), 16);
    let (rms, worst) = off_the_truth(&shared, &rig);
    println!("RMS to the truth {rms:.3} mm, worst {worst:.2} mm");
    assert!(rms < 0.2, "{rms} mm");
}

/// The RMS and the largest distance from the truth of a capture that no example comes from, in mm, on the CPU
/// backend.
fn off_the_truth(shared: &Path, rig: &Rig<f64>) -> (f64, f64) {
    let (frames, truth) = real::truth(shared);
    let (markers, count) = (real::clean_handles(shared, rig), rig.handles().len());
    let at_frames: Vec<[f64; 3]> =
        frames.iter().flat_map(|frame| markers[frame * count..][..count].to_vec()).collect();
    let [_, on_cpu] = on_cpu(rig, &at_frames);
    let (mut squares, mut worst) = (0.0, 0.0_f64);
    for (x, truth) in on_cpu.as_chunks::<3>().0.iter().zip(truth.as_chunks::<3>().0) {
        let off = 10.0 * length(vec3::sub(x.map(f64::from), truth.map(f64::from)));
        squares += off * off;
        worst = worst.max(off);
    }
    let rms = (squares / (100 * rig.vertices()) as f64).sqrt();
    (rms, worst)
}
