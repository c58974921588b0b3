//! The learned method on another head in another unit, with few and unlike examples: poses that no example
//! shows, and another actor's capture.
use crate::support::real;
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{Numbers, evaluate};
use rhytid_core::{Backend, Example, Face, Handles, Method, NoProgress, Rig, Settings, UpAxis, VertexId};
use rhytid_formats::export::OutputStage;
use rhytid_formats::mesh;
use rhytid_kernels::vec3;
use rhytid_playback::Playback;
use rhytid_solve::solve;
use rhytid_test_support::shared;
use std::path::Path;

/// Millimetres in the head's unit, the decimetre.
const MM: f64 = 100.0;

/// How far a vertex may move, as a multiple of what the marker that moves most does. The lips and lids of the
/// examples themselves move up to 4.2 times as far between 31 markers.
const FARTHEST: f64 = 2.1;

fn length(v: [f64; 3]) -> f64 {
    vec3::dot(v, v).sqrt()
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    length(vec3::sub(a, b))
}

fn at_handles(face: &Face, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    face.handles.points.iter().map(|point| point.at(positions)).collect()
}

/// The largest distance between corresponding points.
fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| apart(*a, *b)).fold(0.0, f64::max)
}

/// The sum of the squared distances.
fn squared(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| apart(*a, *b).powi(2)).sum()
}

/// The head with `count` handles, placed by farthest points on what moves in any pose: the face, without the
/// eyes and the back of the head.
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
            noise: None,
        })
        .collect();
    assert_eq!(examples.len(), 8);
    let moves: Vec<usize> = (0..neutral.positions.len())
        .filter(|&v| examples.iter().any(|e| apart(e.positions[v], neutral.positions[v]) > 0.01))
        .collect();
    let mut handles = vec![moves[0]];
    let mut nearest = vec![f64::INFINITY; moves.len()];
    while handles.len() < count {
        let last = neutral.positions[*handles.last().unwrap()];
        for (d, &v) in nearest.iter_mut().zip(&moves) {
            *d = d.min(apart(neutral.positions[v], last));
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
            points: handles.into_iter().map(|v| VertexId::from_index(v).into()).collect(),
        },
        examples,
        prior: None,
        settings: Settings::default(),
    }
}

/// The head's handle positions from the capture of another face: every tenth frame, frames × H.
///
/// The faces are laid over each other by ten landmarks, with one scale and no rotation. A handle gets the
/// mean displacement of its nearest markers. A handle more than 2.5 cm from any marker moves less, and at 5
/// cm not at all.
fn capture(shared: &Path, face: &Face) -> Vec<[f64; 3]> {
    let other = real::face(shared, "face", Settings::default());
    let rest = at_handles(&other, &other.neutral.positions);
    let landmarks = [
        ("mp30", [0.0, 6.909, 1.681]),
        ("jaw08", [0.0, 6.227, 1.455]),
        ("mp48", [-0.253, 6.609, 1.420]),
        ("mp54", [0.253, 6.609, 1.420]),
        ("mp51", [0.0, 6.696, 1.597]),
        ("mp57", [0.0, 6.527, 1.562]),
        ("mp27", [0.0, 7.351, 1.507]),
        ("mp33", [0.0, 6.789, 1.563]),
        ("mp18", [-0.483, 7.452, 1.326]),
        ("mp25", [0.483, 7.452, 1.326]),
    ]
    .map(|(label, here)| (rest[other.handles.labels.iter().position(|l| l == label).unwrap()], here));
    let mean = |points: [[f64; 3]; 10]| {
        [0, 1, 2].map(|c| points.iter().map(|p| p[c]).sum::<f64>() / points.len() as f64)
    };
    let (from, to) = (mean(landmarks.map(|pair| pair.0)), mean(landmarks.map(|pair| pair.1)));
    let (mut together, mut square) = (0.0, 0.0);
    for (there, here) in landmarks {
        let there = vec3::sub(there, from);
        together += vec3::dot(there, vec3::sub(here, to));
        square += vec3::dot(there, there);
    }
    let scale = together / square;
    let weights: Vec<Vec<(usize, f64)>> = at_handles(face, &face.neutral.positions)
        .into_iter()
        .map(|x| {
            let here = |p: &[f64; 3]| [0, 1, 2].map(|c| to[c] + scale * (p[c] - from[c]));
            let mut near: Vec<(f64, usize)> = rest.iter().map(|p| apart(here(p), x)).zip(0..).collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0));
            near.truncate(6);
            let least = near[0].0;
            let weight = |d: f64| ((least * least - d * d) / 0.25_f64.powi(2)).exp();
            let sum: f64 = near.iter().map(|(d, _)| weight(*d)).sum();
            let moves = ((0.5 - least) / 0.25).clamp(0.0, 1.0);
            near.iter().map(|&(d, m)| (m, moves * scale * weight(d) / sum)).collect()
        })
        .collect();
    let rig = solve(&Face { examples: Vec::new(), ..other }, &NoProgress).unwrap();
    let handles = at_handles(face, &face.neutral.positions);
    real::clean_handles(shared, &rig)
        .chunks_exact(rest.len())
        .step_by(10)
        .flat_map(|frame| {
            handles.iter().zip(&weights).map(|(x, weights)| {
                let add = |x: [f64; 3], &(m, w): &(usize, f64)| {
                    [0, 1, 2].map(|c| x[c] + w * (frame[m][c] - rest[m][c]))
                };
                weights.iter().fold(*x, add)
            })
        })
        .collect()
}

/// Whether each triangle of `positions` is turned over, compared with its direction at rest.
fn turned(rig: &Rig<f64>, positions: &[[f64; 3]]) -> Vec<bool> {
    let normal = |positions: &[[f64; 3]], corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        vec3::cross(vec3::sub(b, a), vec3::sub(c, a))
    };
    rig.surface()
        .triangles
        .iter()
        .map(|t| vec3::dot(normal(positions, t), normal(&rig.surface().rest, t)) < 0.0)
        .collect()
}

/// The frames of frames × H handle positions, as `animate` would write them.
fn played(rig: &Rig<f64>, handles: &[[f64; 3]], stage: OutputStage) -> Vec<Vec<[f64; 3]>> {
    let rig = rig.rounded().unwrap();
    let handles: Vec<f32> = handles.as_flattened().iter().map(|x| *x as f32).collect();
    let mut playback = Playback::new(&rig, &Cpu::devices().unwrap(), 16).unwrap();
    let mut frames = Vec::new();
    let each = |positions: &[f32], _: &[f32]| {
        frames.push(positions.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect());
        Ok(())
    };
    playback.evaluate(&handles, stage, false, &NoProgress, each).unwrap();
    frames
}

/// The result of one frame.
struct Held {
    /// Positions of the shell, the large scale and all.
    stages: [Vec<[f64; 3]>; 3],
    /// The largest displacement of a handle, and of a vertex of the large scale and of all, in mesh units.
    markers: f64,
    moved: [f64; 2],
    /// Triangles that are turned over where the shell turns none: of the large scale and of all.
    turned: [usize; 2],
}

fn held(rig: &Rig<f64>, handles: &[[f64; 3]]) -> Vec<Held> {
    let rest: Vec<[f64; 3]> = rig.handles().rest.clone();
    let shell = played(&rig.clone().shell().unwrap(), handles, OutputStage::Shell);
    let smooth = played(rig, handles, OutputStage::LargeScale);
    let full = played(rig, handles, OutputStage::Full);
    let stages = shell.into_iter().zip(smooth).zip(full).map(|((shell, smooth), full)| [shell, smooth, full]);
    stages
        .zip(handles.chunks_exact(rest.len()))
        .map(|(stages, handles)| {
            let [by_shell, smooth, full] = stages.each_ref().map(|stage| turned(rig, stage));
            let beyond =
                |now: Vec<bool>| now.iter().zip(&by_shell).filter(|(now, shell)| **now && !**shell).count();
            let moved = [&stages[1], &stages[2]].map(|stage| farthest(stage, &rig.surface().rest));
            Held { markers: farthest(handles, &rest), moved, turned: [beyond(smooth), beyond(full)], stages }
        })
        .collect()
}

#[test]
fn poses_that_no_example_shows_hold_on_another_head() {
    let Some(shared) = shared("") else { return };
    for count in [31, 90] {
        let whole = makehuman(&shared, count);
        // The rig reproduces its own examples.
        let rig = solve(&whole, &NoProgress).unwrap();
        for pose in &whole.examples {
            let handles = at_handles(&whole, &pose.positions);
            let exact = evaluate(&rig, &handles).positions;
            let off = MM * farthest(&exact, &pose.positions);
            // An example may turn triangles over by itself. Playback keeps such triangles.
            let [positions] = &played(&rig, &handles, OutputStage::Full)[..] else { unreachable!() };
            // Where the rig misses its example by more, lids may come nearer to it.
            let moved = farthest(positions, &exact);
            assert!(moved < 1e-5 || MM * moved < off, "{}: {moved}, the rig is {off} mm off", pose.name);
            let [played, evaluated] = [positions, &exact].map(|x| squared(x, &pose.positions));
            assert!(played < 1.001 * evaluated + 1e-7, "{}: {played} instead of {evaluated}", pose.name);
            println!("{count} handles, {}: within {off:.3} mm", pose.name);
            // A few evenly spread markers do not see every lid and lip.
            assert!(count < 90 || off < 1.5, "{}: {off} mm", pose.name);
        }
        // In other poses nothing moves where no marker moves, and smooth parts stay smooth.
        let (mut squares, mut of_shell) = (0.0, 0.0);
        for left_out in 0..whole.examples.len() {
            let mut face = whole.clone();
            let pose = face.examples.remove(left_out);
            let rig = solve(&face, &NoProgress).unwrap();
            let frame = held(&rig, &at_handles(&face, &pose.positions)).remove(0);
            let square = |positions: &[[f64; 3]]| {
                let off = positions.iter().zip(&pose.positions).map(|(a, b)| apart(*a, *b).powi(2));
                off.sum::<f64>() / rig.vertices() as f64
            };
            let off = square(&frame.stages[2]);
            squares += off;
            of_shell += square(&frame.stages[0]);
            let [smooth, full] = frame.moved.map(|moved| moved / frame.markers);
            println!(
                "{count} handles, without {}: RMS {:.2} mm; moves by {smooth:.2} (large scale) and {full:.2} of what the \
                 markers do; {:?} triangles turned over",
                pose.name,
                MM * off.sqrt(),
                frame.turned
            );
            assert!(smooth < FARTHEST && full < FARTHEST, "{}: {smooth}, {full}", pose.name);
            assert_eq!(frame.turned, [0; 2], "{}", pose.name);
        }
        let [rms, of_shell] = [squares, of_shell].map(|sum| MM * (sum / whole.examples.len() as f64).sqrt());
        println!("{count} handles: RMS {rms:.2} mm, the shell alone {of_shell:.2} mm");
        // A few evenly spread markers tell expressions of different muscles hardly apart.
        let bound = if count < 90 { 1.05 } else { 1.0 };
        assert!(rms < bound * of_shell, "{count} handles: {rms} mm, the shell alone {of_shell} mm");
    }
}

/// Artists' expressions of different muscles do not predict each other. Combined, they must still show what
/// each of them shows.
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
            let handles: Vec<[f64; 3]> = rig.handles().points.iter().map(|point| point.at(mixture)).collect();
            let found = evaluate(&rig, &handles).positions;
            squares += found.iter().zip(mixture).map(|(a, b)| apart(*a, *b).powi(2)).sum::<f64>();
        }
        MM * (squares / (mixtures.len() * rest.len()) as f64).sqrt()
    };
    let (learned, chapter) = (rms(&face), rms(&chapter));
    println!("mixtures of MakeHuman's expressions: {learned:.3} mm, the chapter's {chapter:.3} mm");
    assert!(learned < 0.6 * chapter, "{learned} mm, the chapter's {chapter} mm");
}

#[test]
fn another_actors_capture_holds_on_another_head() {
    let Some(shared) = shared("") else { return };
    for count in [31, 90] {
        let face = makehuman(&shared, count);
        let rig = solve(&face, &NoProgress).unwrap();
        let (mut frames, mut most, mut beyond) = (0, [0.0_f64; 2], 0.0_f64);
        for frame in held(&rig, &capture(&shared, &face)) {
            frames += 1;
            let [smooth, full] = frame.moved.map(|moved| moved / frame.markers.max(1e-12));
            most = [most[0].max(smooth), most[1].max(full)];
            // An open mouth moves the lower lip by 31 mm in an example. So the lip follows a jaw that goes
            // where no example does.
            let bound = 2.0 * frame.markers + 10.0 / MM;
            beyond = beyond.max(frame.moved[1] - 2.0 * frame.markers);
            assert!(
                frame.moved.iter().all(|moved| *moved < bound),
                "frame {frames}: {:?}, the markers {}",
                frame.moved,
                frame.markers
            );
            assert_eq!(frame.turned, [0; 2], "frame {frames}");
        }
        println!(
            "{count} handles, {frames} frames: moves by {most:.2?} of what the markers do, {:.1} mm over twice that",
            MM * beyond
        );
        assert_eq!(frames, 403);
    }
}
