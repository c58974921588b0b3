//! The learned method on what it was not made with: noise, thrown markers, a raw take, a head of many parts, another topology
//! with other markers.
use crate::support::real;
use glam::{DMat3, DVec3};
use rhytid_backend_cpu::Cpu;
use rhytid_capture::{Settings as CleanUp, Target, clean};
use rhytid_conformance::{Numbers, evaluate};
use rhytid_core::{
    Animator, Backend, Example, Face, Handles, Method, NoProgress, Rig, Settings, Stage, UpAxis,
    UploadOptions,
};
use rhytid_formats::{mesh, raw_take};
use rhytid_kernels::vec3;
use rhytid_solve::{solve, solve_and_account};
use rhytid_test_support::shared;
use std::path::Path;

/// Frames of a batch.
const BATCH: usize = 16;

/// Positions of all vertices in each of frames × H handle positions, on the CPU backend.
fn play(rig: &Rig<f64>, handle_positions: &[[f64; 3]], mut each: impl FnMut(usize, &[[f32; 3]])) {
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, &rig.cast(), UploadOptions::frames(BATCH)).unwrap();
    let mut found = Vec::new();
    for (i, frames) in handle_positions.chunks(BATCH * rig.handles.len()).enumerate() {
        let positions: Vec<f32> = frames.as_flattened().iter().map(|&x| x as f32).collect();
        animator.evaluate(&positions).unwrap();
        animator.read(Stage::Positions, &mut found).unwrap();
        for (j, frame) in found.chunks_exact(3 * rig.vertices()).enumerate() {
            each(i * BATCH + j, frame.as_chunks().0);
        }
    }
}

fn length(v: [f64; 3]) -> f64 {
    vec3::dot(v, v).sqrt()
}

fn widened(p: [f32; 3]) -> [f64; 3] {
    p.map(f64::from)
}

fn at_rest(rig: &Rig<f64>) -> Vec<[f64; 3]> {
    rig.handles.iter().map(|&v| rig.rest[v as usize]).collect()
}

/// A normally distributed number with the standard deviation 1: the sum of twelve numbers in 0..1, less 6.
fn normal(numbers: &mut Numbers) -> f64 {
    (0..12).map(|_| numbers.unit()).sum::<f64>() - 6.0
}

#[test]
fn noise_of_the_markers_stays_noise() {
    let Some(shared) = shared("") else { return };
    let rig = solve(&real::face(&shared, "face", Settings::default()), &NoProgress).unwrap();
    let count = rig.handles.len();
    let clean: Vec<[f64; 3]> =
        real::clean_handles(&shared, &rig).chunks_exact(count).step_by(40).flatten().copied().collect();
    let mut numbers = Numbers::new(7);
    // 0.1 mm per axis, in cm.
    let noisy: Vec<[f64; 3]> = clean.iter().map(|p| p.map(|x| x + 0.01 * normal(&mut numbers))).collect();
    let mut without: Vec<Vec<[f32; 3]>> = Vec::new();
    play(&rig, &clean, |_, frame| without.push(frame.to_vec()));
    let (mut squares, mut worst, mut frames) = (0.0, 0.0_f64, 0);
    play(&rig, &noisy, |i, frame| {
        frames += 1;
        for (a, b) in frame.iter().zip(&without[i]) {
            let off = 10.0 * length(vec3::sub(widened(*a), widened(*b)));
            squares += off * off;
            worst = worst.max(off);
        }
    });
    let rms = (squares / (frames * rig.vertices()) as f64).sqrt();
    println!("0.1 mm of noise: RMS {rms:.3} mm, worst {worst:.2} mm in {frames} frames");
    assert!(rms <= 0.17 && worst <= 0.8, "RMS {rms} mm, worst {worst} mm");
}

#[test]
fn thrown_markers_give_a_bounded_face() {
    let Some(shared) = shared("") else { return };
    let rig = solve(&real::face(&shared, "face", Settings::default()), &NoProgress).unwrap();
    let (rest, count) = (at_rest(&rig), rig.handles.len());
    let clean: Vec<[f64; 3]> =
        real::clean_handles(&shared, &rig).chunks_exact(count).step_by(200).flatten().copied().collect();
    let mut numbers = Numbers::new(11);
    let five: Vec<[f64; 3]> = clean
        .iter()
        .zip(rest.iter().cycle())
        .map(|(p, r)| [0, 1, 2].map(|c| r[c] + 5.0 * (p[c] - r[c])))
        .collect();
    let noise: Vec<[f64; 3]> = clean.iter().map(|p| p.map(|x| x + 10.0 * normal(&mut numbers))).collect();
    for (what, thrown) in [("five times", five), ("10 cm of noise", noise)] {
        let mut largest = 0.0_f64;
        for (p, r) in thrown.iter().zip(rest.iter().cycle()) {
            largest = largest.max(length(vec3::sub(*p, *r)));
        }
        let mut moved = 0.0_f64;
        play(&rig, &thrown, |_, frame| {
            for (p, r) in frame.iter().zip(&rig.rest) {
                assert!(p.iter().all(|x| x.is_finite()));
                moved = moved.max(length(vec3::sub(widened(*p), *r)));
            }
        });
        println!("{what}: the markers move by {largest:.1} cm at most, the face by {moved:.1}");
        assert!(moved < 2.0 * largest, "{what}: {moved} cm where the markers move by {largest}");
    }
}

#[test]
fn a_still_face_of_a_raw_take_is_still() {
    let Some(shared) = shared("") else { return };
    // On the head, whose examples ask for a smaller ridge, noise comes through a little more.
    for (folder, most) in [("face", 0.55), ("head", 0.7)] {
        let rig = solve(&real::face(&shared, folder, Settings::default()), &NoProgress).unwrap();
        let raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
        let target = Target::of(&rig.cast());
        let cleaned = clean(raw, &target, &CleanUp::default(), &NoProgress).unwrap();
        // The first half second is the neutral face.
        let take = cleaned.take.slice(0..60);
        let handles = take.handle_positions(&rig.labels).unwrap();
        let handles: Vec<[f64; 3]> = handles.as_chunks::<3>().0.iter().map(|p| widened(*p)).collect();
        let (mut before, mut worst) = (Vec::new(), (0.0_f64, 0));
        play(&rig, &handles, |_, frame| {
            for (v, (a, b)) in frame.iter().zip(&before).enumerate() {
                let jump = 10.0 * length(vec3::sub(widened(*a), widened(*b)));
                if jump > worst.0 {
                    worst = (jump, v);
                }
            }
            before = frame.to_vec();
        });
        println!("{folder}: no vertex jumps by more than {:.3} mm (vertex {})", worst.0, worst.1);
        assert!(worst.0 <= most, "{folder}: {worst:?}");
    }
}

#[test]
fn teeth_and_eyes_stay_what_they_are() {
    let Some(shared) = shared("") else { return };
    let (rig, account) =
        solve_and_account(&real::face(&shared, "head", Settings::default()), &NoProgress).unwrap();
    let rigid: Vec<_> = account.parts.iter().filter(|part| part.rigid).collect();
    assert!(rigid.len() > 20, "only {} parts are rigid", rigid.len());
    let count = rig.handles.len();
    let frames: Vec<[f64; 3]> =
        real::clean_handles(&shared, &rig).chunks_exact(count).step_by(100).flatten().copied().collect();
    let mut worst = 0.0_f64;
    play(&rig, &frames, |_, frame| {
        for part in &rigid {
            let first = part.first_vertex as usize;
            let vertices: Vec<usize> = (first..first + part.vertices).collect();
            worst = worst.max(off_rigid(&rig.rest, frame, &vertices));
        }
    });
    println!("{} rigid parts are within {:.2} % of their size of a rigid motion", rigid.len(), 100.0 * worst);
    assert!(worst < 0.01, "a rigid part is off by {worst} of its size");
}

/// The RMS distance to the best rigid motion over the diagonal of the part's bounding box. The rotation is the orthogonal factor of the correlations, by
/// Newton's iteration (Higham 1986).
fn off_rigid(rest: &[[f64; 3]], moved: &[[f32; 3]], part: &[usize]) -> f64 {
    let centered = |points: Vec<DVec3>| {
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        points.into_iter().map(|p| p - mean).collect::<Vec<_>>()
    };
    let from = centered(part.iter().map(|&v| DVec3::from_array(rest[v])).collect());
    let to = centered(part.iter().map(|&v| DVec3::from_array(widened(moved[v]))).collect());
    let mut rotation = DMat3::ZERO;
    for (a, b) in from.iter().zip(&to) {
        rotation += DMat3::from_cols(*b * a.x, *b * a.y, *b * a.z);
    }
    for _ in 0..100 {
        rotation = 0.5 * (rotation + rotation.inverse().transpose());
    }
    assert!((rotation.determinant() - 1.0).abs() < 1e-9, "no rotation");
    let off: f64 = from.iter().zip(&to).map(|(a, b)| (rotation * *a - *b).length_squared()).sum();
    let (low, high) = from.iter().fold((from[0], from[0]), |(low, high), p| (low.min(*p), high.max(*p)));
    (off / from.len() as f64).sqrt() / low.distance(high)
}

/// Another head in another unit, with `count` handles by farthest points of its skin.
fn makehuman(shared: &Path, count: usize) -> Face {
    let folder = shared.join("data/makehuman");
    let neutral_path = folder.join("neutral.obj");
    let neutral = mesh::read(&neutral_path).unwrap();
    let mut poses: Vec<_> =
        std::fs::read_dir(folder.join("poses")).unwrap().map(|entry| entry.unwrap().path()).collect();
    poses.sort();
    let examples: Vec<Example> = poses
        .iter()
        .map(|path| Example {
            mirror: false,
            name: path.file_stem().unwrap().to_string_lossy().into_owned(),
            positions: mesh::read_like(&neutral, &neutral_path, path).unwrap(),
        })
        .collect();
    assert_eq!(examples.len(), 8);
    // Of what moves in any pose: the face, without the eyes and the back of the head.
    let moves: Vec<usize> = (0..neutral.positions.len())
        .filter(|&v| examples.iter().any(|e| length(vec3::sub(e.positions[v], neutral.positions[v])) > 0.01))
        .collect();
    let mut handles = vec![moves[0]];
    let mut nearest = vec![f64::INFINITY; moves.len()];
    while handles.len() < count {
        let last = neutral.positions[*handles.last().unwrap()];
        for (d, &v) in nearest.iter_mut().zip(&moves) {
            *d = d.min(length(vec3::sub(neutral.positions[v], last)));
        }
        let farthest = (0..moves.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b])).unwrap();
        handles.push(moves[farthest]);
    }
    Face {
        name: "makehuman".into(),
        neutral,
        metres_per_unit: 0.1,
        up_axis: UpAxis::Y,
        handles: Handles {
            labels: (0..count).map(|h| format!("m{h}")).collect(),
            vertices: handles.into_iter().map(|v| v as u32).collect(),
        },
        examples,
        settings: Settings::default(),
    }
}

#[test]
fn another_head_with_other_markers_does_not_break() {
    let Some(shared) = shared("") else { return };
    let farthest = |p: &[[f64; 3]], r: &[[f64; 3]]| {
        p.iter().zip(r).map(|(p, r)| length(vec3::sub(*p, *r))).fold(0.0, f64::max)
    };
    for count in [31, 90] {
        let whole = makehuman(&shared, count);
        let at_handles = |pose: &Example| -> Vec<[f64; 3]> {
            whole.handles.vertices.iter().map(|&v| pose.positions[v as usize]).collect()
        };
        // What it was made with comes back.
        let rig = solve(&whole, &NoProgress).unwrap();
        for pose in &whole.examples {
            let positions = evaluate(&rig, &at_handles(pose)).positions;
            let off = 100.0 * farthest(&positions, &pose.positions);
            println!("{count} handles, {}: within {off:.3} mm", pose.name);
            // Few markers, spread without a thought, do not see every lid and lip.
            assert!(count < 90 || off < 1.5, "{}: {off} mm", pose.name);
        }
        // And of what it was not made with, nothing goes where no marker does.
        for left_out in 0..whole.examples.len() {
            let mut face = whole.clone();
            let pose = face.examples.remove(left_out);
            let rig = solve(&face, &NoProgress).unwrap();
            let handles = at_handles(&pose);
            let results = evaluate(&rig, &handles);
            let markers = farthest(&handles, &at_rest(&rig));
            let [smooth, full] =
                [&results.large_scale, &results.positions].map(|p| farthest(p, &rig.rest) / markers);
            let off = results.positions.iter().zip(&pose.positions);
            let off = off.map(|(a, b)| length(vec3::sub(*a, *b)).powi(2)).sum::<f64>();
            println!(
                "{count} handles, without {}: RMS {:.2} mm; moves by {smooth:.2} (large scale) and {full:.2} of what the \
                 markers do",
                pose.name,
                100.0 * (off / rig.vertices() as f64).sqrt()
            );
            assert!(smooth < 2.0 && full < 2.5, "{}: {smooth}, {full}", pose.name);
        }
    }
}

/// Expressions of different muscles, as artists make them, do not predict each other; what is seen of them together must come of
/// them all the same.
#[test]
fn mixtures_of_the_examples_are_what_they_are_mixed_of() {
    let Some(shared) = shared("") else { return };
    let face = makehuman(&shared, 90);
    let chapter =
        Face { settings: Settings { method: Method::Chapter, ..Settings::default() }, ..face.clone() };
    let mut numbers = Numbers::new(5);
    let rest = &face.neutral.positions;
    let mixtures: Vec<Vec<[f64; 3]>> = (0..20)
        .map(|_| {
            let weights: Vec<f64> = face
                .examples
                .iter()
                .map(|_| if numbers.unit() < 0.4 { numbers.unit() } else { 0.0 })
                .collect();
            let mixed = |v: usize| {
                let moved = |c: usize| {
                    let of_examples = face.examples.iter().zip(&weights);
                    of_examples.map(|(e, w)| w * (e.positions[v][c] - rest[v][c])).sum::<f64>()
                };
                [0, 1, 2].map(|c| rest[v][c] + moved(c))
            };
            (0..rest.len()).map(mixed).collect()
        })
        .collect();
    let rms = |face: &Face| {
        let rig = solve(face, &NoProgress).unwrap();
        let mut squares = 0.0;
        for mixture in &mixtures {
            let handles: Vec<[f64; 3]> = rig.handles.iter().map(|&v| mixture[v as usize]).collect();
            let found = evaluate(&rig, &handles).positions;
            squares += found.iter().zip(mixture).map(|(a, b)| length(vec3::sub(*a, *b)).powi(2)).sum::<f64>();
        }
        // In decimetres.
        100.0 * (squares / (mixtures.len() * rest.len()) as f64).sqrt()
    };
    let (learned, chapter) = (rms(&face), rms(&chapter));
    println!("mixtures of MakeHuman's expressions: {learned:.3} mm, the chapter's {chapter:.3} mm");
    assert!(learned < 0.6 * chapter, "{learned} mm, the chapter's {chapter} mm");
}
