//! Made-up animations with a known answer; every error is computed anew from the stored numbers.

use super::factors::Fit;
use super::fit::fit;
use super::frames::Centred;
use super::{Frames, Morphs, Settings, Values};
use rhytid_core::{Error, NoProgress, Progress, Remedy, Result};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The same numbers in every run: uniform in −1 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// F frames of V vertices: a base of size 10 plus `rank` shapes of size 1 with weights of size 1.
fn made_up(frames: usize, vertices: usize, rank: usize) -> Vec<Vec<f32>> {
    let mut random = Random(7);
    let base: Vec<f64> = (0..3 * vertices).map(|_| 10.0 * random.next()).collect();
    let shapes: Vec<Vec<f64>> =
        (0..rank).map(|_| (0..3 * vertices).map(|_| random.next()).collect()).collect();
    (0..frames)
        .map(|_| {
            let weights: Vec<f64> = (0..rank).map(|_| random.next()).collect();
            (0..3 * vertices)
                .map(|i| (base[i] + weights.iter().zip(&shapes).map(|(w, s)| w * s[i]).sum::<f64>()) as f32)
                .collect()
        })
        .collect()
}

fn settings(max_error: f64, quantize: bool) -> Settings {
    Settings { max_error, most_targets: 256, quantize }
}

fn bake(animation: &[Vec<f32>], shapes: usize, quantize: bool) -> Morphs {
    let morphs = spooled(animation, None).bake(shapes, quantize, &NoProgress).unwrap();
    assert!(morphs.targets.len() <= shapes);
    check(animation, &morphs, morphs.worst());
    morphs
}

#[test]
fn so_many_shapes_are_as_near_as_they_come() {
    let animation = made_up(40, 300, 12);
    let mut before = f64::INFINITY;
    for shapes in [1, 3, 6, 11] {
        let worst = bake(&animation, shapes, false).worst();
        assert!(worst < before, "{shapes} shapes: {worst}, fewer: {before}");
        before = worst;
        // With the stated error as the bound, a search for the fewest targets needs as many, or one more if
        // it misses the best.
        let fewest = compress(&animation, settings(1.02 * worst, false)).unwrap().targets.len();
        assert!(fewest <= shapes + 1, "{shapes} shapes are within {worst}, for which {fewest} are needed");
        let tighter = compress(&animation, settings(0.85 * worst, false)).unwrap().targets.len();
        assert!(tighter > shapes, "{tighter} targets are within 0.85 of what {shapes} shapes are");
    }
    // As many shapes as there are directions of motion, and more.
    for shapes in [12, 13, 39, 1000] {
        let morphs = bake(&animation, shapes, false);
        assert!(morphs.worst() < 1e-3, "{shapes} shapes: {}", morphs.worst());
    }
    let (floats, integers) = (bake(&animation, 6, false), bake(&animation, 6, true));
    assert!(integers.worst() < 1.6 * floats.worst(), "{} {}", integers.worst(), floats.worst());
    assert!(integers.targets.iter().all(|target| !matches!(target.positions, Values::F32(_))));
}

#[test]
fn shapes_of_what_does_not_move() {
    let still = vec![made_up(1, 30, 1).remove(0); 5];
    assert!(bake(&still, 4, false).worst() < 1e-5);
    assert!(bake(&still[..1], 4, true).worst() < 1e-3);
    let error = spooled(&still, None).bake(0, false, &NoProgress).unwrap_err().to_string();
    assert!(error.contains("0 shapes were asked for, expected at least 1"), "{error}");
}

/// Strains that are linear in the weights are reproduced. For other strains the stated error is the true one.
#[test]
fn strains_follow_the_weights() {
    let animation = made_up(12, 200, 3);
    let linear: Vec<Vec<f32>> =
        animation.iter().map(|frame| frame.iter().map(|x| 0.1 * x + 0.2).collect()).collect();
    let curved: Vec<Vec<f32>> =
        animation.iter().map(|frame| frame.iter().map(|x| (0.3 * x).sin()).collect()).collect();
    for (strains, quantize, is_linear) in
        [(&linear, false, true), (&linear, true, true), (&curved, false, false)]
    {
        let mut frames =
            Frames::new(tempfile::tempfile().unwrap(), Path::new("out.glb"), 200, false, vec![2]);
        for (positions, strain) in animation.iter().zip(strains) {
            frames.push(positions, None, std::slice::from_ref(strain)).unwrap();
        }
        let morphs = frames.compress(&settings(0.02, quantize), &NoProgress).unwrap();
        let strain = &morphs.extras[0];
        let (k, mut worst, mut sum) = (morphs.targets.len(), 0.0_f64, 0.0);
        for (f, given) in strains.iter().enumerate() {
            for v in 0..200 {
                let square = |i: usize| {
                    let moved: f64 = (0..k)
                        .map(|j| f64::from(morphs.weights[f * k + j]) * f64::from(strain.targets[j][i]))
                        .sum();
                    (f64::from(strain.base[i]) + moved - f64::from(given[i])).powi(2)
                };
                let square = square(3 * v) + square(3 * v + 1);
                worst = worst.max(square.sqrt());
                sum += square;
            }
        }
        let rms = (sum / (200.0 * 12.0_f64)).sqrt();
        let off = morphs.clips[0].extras[0];
        assert!((off.worst - worst).abs() < 1e-9 && (off.rms - rms).abs() < 1e-9, "{worst} {rms}");
        assert_eq!(worst < 1e-3, is_linear, "{worst}");
    }
}

fn spooled(animation: &[Vec<f32>], normals: Option<&[Vec<f32>]>) -> Frames {
    let vertices = animation.first().map_or(0, |frame| frame.len() / 3);
    let mut frames = Frames::new(
        tempfile::tempfile().unwrap(),
        Path::new("out.glb"),
        vertices,
        normals.is_some(),
        Vec::new(),
    );
    for (i, frame) in animation.iter().enumerate() {
        frames.push(frame, normals.map(|normals| &normals[i][..]), &[]).unwrap();
    }
    frames
}

fn compress(animation: &[Vec<f32>], settings: Settings) -> Result<Morphs> {
    let morphs = spooled(animation, None).compress(&settings, &NoProgress)?;
    check(animation, &morphs, settings.max_error);
    Ok(morphs)
}

fn number(values: &Values, i: usize) -> f32 {
    match values {
        Values::F32(v) => v[i],
        Values::I16(v) => f32::from(v[i]) / 32767.0,
        Values::I8(v) => f32::from(v[i]) / 127.0,
    }
}

/// Recomputes every vertex of every frame as a reader does, in float32, forwards and backwards through the
/// targets.
fn check(animation: &[Vec<f32>], morphs: &Morphs, max_error: f64) {
    let k = morphs.targets.len();
    assert_eq!(morphs.weights.len(), animation.len() * k);
    assert!(morphs.weights.iter().all(|w| (0.0..=1.0).contains(w)));
    let (mut worst, mut sum) = (0.0_f64, 0.0);
    for (f, frame) in animation.iter().enumerate() {
        let weights = &morphs.weights[f * k..][..k];
        for v in 0..frame.len() / 3 {
            let mut squares = [0.0_f64; 2];
            for c in 0..3 {
                let i = 3 * v + c;
                let term = |j: usize| weights[j] * number(&morphs.targets[j].positions, i);
                let forwards = (0..k).fold(number(&morphs.base, i), |x, j| x + term(j));
                let backwards = (0..k).rev().map(term).sum::<f32>() + number(&morphs.base, i);
                for (square, x) in squares.iter_mut().zip([forwards, backwards]) {
                    let x = morphs.scale * x + morphs.translation[c];
                    *square += (f64::from(x) - f64::from(frame[i])).powi(2);
                }
            }
            worst = squares.iter().fold(worst, |worst, s| worst.max(s.sqrt()));
            sum += squares[0];
        }
    }
    let rms = (sum / (animation.len() * animation[0].len() / 3) as f64).sqrt();
    let stated = morphs.worst();
    assert!(worst <= stated && stated <= max_error, "found {worst}, stated {stated}, allowed {max_error}");
    let size = animation.iter().flatten().fold(0.0, |size: f64, x| size.max(f64::from(x.abs())));
    assert!(stated <= 1.1 * worst + 1e-5 * size, "stated {stated} is far more than {worst}");
    assert!(
        (rms - morphs.clips[0].rms).abs() <= 0.01 * rms + 1e-7 * size,
        "rms {rms}, stated {}",
        morphs.clips[0].rms
    );
}

#[test]
fn an_animation_of_rank_r_needs_r_targets() {
    for rank in [1, 2, 5, 11] {
        let animation = made_up(40, 300, rank);
        let exact = compress(&animation, settings(2e-4, false)).unwrap();
        assert_eq!(exact.targets.len(), rank);
        let quantized = compress(&animation, settings(2e-2, true)).unwrap();
        assert_eq!(quantized.targets.len(), rank);
        assert!(quantized.targets.iter().all(|target| !matches!(target.positions, Values::F32(_))));
    }
}

#[test]
fn what_does_not_move_needs_no_targets() {
    for frames in [1, 2, 7] {
        let animation = vec![made_up(1, 50, 0).remove(0); frames];
        for quantize in [false, true] {
            let morphs = compress(&animation, settings(1e-3, quantize)).unwrap();
            assert!(morphs.targets.is_empty() && morphs.weights.is_empty());
        }
    }
}

#[test]
fn a_bound_above_all_motion_needs_no_targets() {
    let animation = made_up(20, 50, 3);
    let morphs = compress(&animation, settings(30.0, false)).unwrap();
    assert!(morphs.targets.is_empty());
}

#[test]
fn few_frames_and_few_vertices() {
    for frames in [2, 3, 5] {
        for vertices in [1, 2, 300] {
            let animation = made_up(frames, vertices, 20);
            for quantize in [false, true] {
                let morphs = compress(&animation, settings(2e-3, quantize)).unwrap();
                assert!(morphs.targets.len() < frames);
            }
        }
    }
}

/// 400 vertices shiver in 8 independent ways, with a size a little below the bound. A single vertex moves
/// far. Principal components describe the 400 first and the single vertex last.
#[test]
fn one_vertex_that_principal_components_miss() {
    let mut random = Random(3);
    let mut animation = made_up(60, 400, 8);
    for frame in &mut animation {
        frame[3 * 123] += random.next() as f32;
    }
    let bound = 0.1;
    // 8 shapes for the 400 vertices and one for the single vertex.
    let morphs = compress(&animation, settings(bound, false)).unwrap();
    assert!(morphs.targets.len() <= 9);
    // If the 400 vertices stay within the bound, only the single vertex needs a target.
    let base = animation[0].clone();
    for frame in &mut animation {
        for (i, x) in frame.iter_mut().enumerate() {
            if i / 3 != 123 {
                *x = base[i] + (0.04 * random.next()) as f32;
            } else if i % 3 != 0 {
                *x = base[i];
            }
        }
    }
    let morphs = compress(&animation, settings(bound, false)).unwrap();
    assert_eq!(morphs.targets.len(), 1);
}

/// Independent motion of all vertices cannot be compressed. With heavy tails, fitting to the worst vertex
/// pays. Eigenvalues say how many principal components suffice for the mean, never for the worst vertex.
#[test]
fn fewer_targets_than_principal_components_need() {
    let mut random = Random(11);
    let mut animation = made_up(80, 500, 4);
    // Small local motions, each of some vertices in some frames: 60 further directions.
    for bump in 0..60 {
        let (vertex, frame) = ((bump * 37) % 490, (bump * 13) % 76);
        for positions in &mut animation[frame..frame + 4] {
            for x in &mut positions[3 * vertex..3 * (vertex + 8)] {
                *x += (0.08 * random.next()) as f32;
            }
        }
    }
    let morphs = compress(&animation, settings(0.05, false)).unwrap();
    let components = principal_components_needed(&animation, 0.05);
    let found = morphs.targets.len();
    assert!(found * 5 <= components * 4, "{found} targets, {components} principal components");
}

/// A fit that is exact except for one vertex, which no iteration has pulled yet. The work is on the vertices
/// near the bound. That this vertex is beyond the bound shows only when all vertices are examined.
#[test]
fn a_vertex_that_nothing_pulled_is_found_beyond_the_bound() {
    let (count, columns, bound) = (700, 4, 1e-2);
    let animation = made_up(40, count, columns - 1);
    // The first vertex, one at the border of two tasks, and one of the last task.
    for vertex in [0, 256, 690] {
        let mut frames = spooled(&animation, None);
        let gram = frames.gram(&NoProgress).unwrap();
        let q = super::linear::principal(&gram.matrix).unwrap().vectors.subcols(0, columns).to_owned();
        let mut start = Fit::on(&mut frames, &gram, q).unwrap();
        assert!(worst(&start, &animation, &gram.center).0 < 1e-4);
        start.t[3 * vertex * columns] += 1.0;
        let (error, at) = worst(&start, &animation, &gram.center);
        assert!(error > 10.0 * bound && at == vertex);
        assert!(start.multipliers.iter().all(Vec::is_empty));
        let mut centred = Centred::new(&mut frames, &gram);
        let found = fit(&mut centred, start, bound, &mut |_| Ok(())).unwrap().unwrap();
        let (error, at) = worst(&found, &animation, &gram.center);
        assert!(error <= bound * 1.0001, "vertex {at} is off by {error}");
    }
}

/// The largest distance of a vertex from its place, with that vertex.
fn worst(fit: &Fit, animation: &[Vec<f32>], center: &[f32]) -> (f64, usize) {
    let n = fit.q.ncols();
    let mut worst = (0.0, 0);
    for (f, frame) in animation.iter().enumerate() {
        for v in 0..frame.len() / 3 {
            let off = |i: usize| {
                let m: f64 = (0..n).map(|k| fit.q[(f, k)] * f64::from(fit.t[i * n + k])).sum();
                m + f64::from(center[i]) - f64::from(frame[i])
            };
            let error = (3 * v..3 * v + 3).map(|i| off(i).powi(2)).sum::<f64>().sqrt();
            if error > worst.0 {
                worst = (error, v);
            }
        }
    }
    worst
}

/// How many plain principal components keep every vertex within the bound.
fn principal_components_needed(animation: &[Vec<f32>], bound: f64) -> usize {
    let mut frames = spooled(animation, None);
    let gram = frames.gram(&NoProgress).unwrap();
    let start = super::linear::principal(&gram.matrix).unwrap();
    let error = |n: usize| {
        let q = start.vectors.as_ref().subcols(0, n).to_owned();
        let columns = (0..animation[0].len()).map(|i| {
            let y: Vec<f64> = animation.iter().map(|frame| f64::from(frame[i] - gram.center[i])).collect();
            let t: Vec<f64> = (0..n).map(|k| (0..y.len()).map(|f| q[(f, k)] * y[f]).sum()).collect();
            (0..y.len()).map(|f| y[f] - (0..n).map(|k| q[(f, k)] * t[k]).sum::<f64>()).collect::<Vec<_>>()
        });
        let columns: Vec<Vec<f64>> = columns.collect();
        let squares =
            columns.chunks(3).flat_map(|c| (0..animation.len()).map(|f| c.iter().map(|c| c[f] * c[f]).sum()));
        squares.fold(0.0, f64::max).sqrt()
    };
    (0..animation.len()).find(|&k| error(k + 1) <= bound).unwrap()
}

#[test]
fn units_do_not_matter() {
    let animation = made_up(30, 200, 6);
    for scale in [1e-4_f32, 1.0, 1e5] {
        let scaled: Vec<Vec<f32>> =
            animation.iter().map(|frame| frame.iter().map(|x| x * scale).collect()).collect();
        for (quantize, bound) in [(false, 1e-3), (true, 1e-2)] {
            let morphs = compress(&scaled, settings(bound * f64::from(scale), quantize)).unwrap();
            assert_eq!(morphs.targets.len(), 6, "units × {scale}, quantize {quantize}");
        }
    }
}

#[test]
fn refusals_say_what_to_do() {
    let animation = made_up(40, 100, 30);
    let few = Settings { most_targets: 12, ..settings(1e-3, false) };
    for (what, settings, expected) in [
        ("too many targets", few, "more than 12 morph targets"),
        ("below float32", settings(1e-9, false), "finer than the float32"),
        ("below float32, integers", settings(1e-9, true), "finer than the float32"),
        ("no bound", settings(0.0, false), "expected a positive number"),
        ("not a number", settings(f64::NAN, false), "expected a positive number"),
    ] {
        match compress(&animation, settings) {
            Err(Error::Input(message)) => {
                assert!(
                    message.sentence().contains(expected) && message.sentence().starts_with("out.glb: "),
                    "{what}: {message}"
                );
                // A program says which option lifts the limit on targets.
                let is_of_targets = message.remedies().contains(&Remedy::MostTargets);
                assert_eq!(is_of_targets, what == "too many targets", "{what}");
            }
            other => panic!("{what}: {other:?}"),
        }
    }
    assert!(matches!(compress(&[], settings(1.0, false)), Err(Error::Input(_))));
}

#[test]
fn the_bound_that_a_refusal_names_can_be_met() {
    let animation = made_up(20, 100, 6);
    for quantize in [false, true] {
        let Err(Error::Input(message)) = compress(&animation, settings(1e-9, quantize)) else { panic!() };
        let named = message.sentence().split("expected ").nth(1).unwrap().split_whitespace().next().unwrap();
        compress(&animation, settings(named.parse().unwrap(), quantize)).unwrap();
    }
}

/// Unit normals that follow the same shapes as the positions are found again, to the precision that is
/// stored.
#[test]
fn normals_follow_the_weights() {
    let animation = made_up(30, 200, 3);
    let normals: Vec<Vec<f32>> = animation
        .iter()
        .map(|frame| frame.chunks(3).flat_map(|p| unit([0.1 * p[0], 0.1 * p[1], 4.0 + 0.1 * p[2]])).collect())
        .collect();
    for (quantize, allowed) in [(false, 0.02), (true, 0.06)] {
        let settings = settings(0.02, quantize);
        let morphs = spooled(&animation, Some(&normals)).compress(&settings, &NoProgress).unwrap();
        check(&animation, &morphs, settings.max_error);
        let k = morphs.targets.len();
        for (f, normals) in normals.iter().enumerate() {
            for v in 0..200 {
                let at = |c: usize| {
                    let i = 3 * v + c;
                    let targets = morphs.targets.iter().zip(&morphs.weights[f * k..]);
                    let offsets = targets.map(|(t, w)| w * number(t.normals.as_ref().unwrap(), i));
                    number(morphs.base_normals.as_ref().unwrap(), i) + offsets.sum::<f32>()
                };
                let found = unit([at(0), at(1), at(2)]);
                let d = [0, 1, 2].map(|c| found[c] - normals[3 * v + c]);
                assert!(
                    d.iter().all(|d| d.abs() < allowed),
                    "frame {f}, vertex {v}, quantize {quantize}: {d:?}"
                );
            }
        }
        for v in 0..200 {
            let n = [0, 1, 2].map(|c| number(morphs.base_normals.as_ref().unwrap(), 3 * v + c));
            let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((length - 1.0).abs() < 0.01);
        }
    }
}

/// The normals of one vertex turn all the way round, so that they cancel in the mean and where all weights
/// are 0. The normals of the others nod.
#[test]
fn normals_that_cancel_do_not_make_whole_targets_larger() {
    let animation = made_up(60, 200, 3);
    let mut random = Random(3);
    let tilts: Vec<f32> = (0..200).map(|_| 0.2 * random.next() as f32).collect();
    let normals: Vec<Vec<f32>> = (0..60)
        .map(|f| {
            let turn = f as f32 / 60.0 * std::f32::consts::TAU;
            let of_vertex = |(v, tilt): (usize, &f32)| match v {
                7 => [turn.cos(), turn.sin(), 0.0],
                _ => unit([tilt * turn.cos(), tilt * turn.sin(), 1.0]),
            };
            tilts.iter().enumerate().flat_map(of_vertex).collect()
        })
        .collect();
    let frames = spooled(&animation, Some(&normals));
    let morphs = frames.compress(&settings(0.02, true), &NoProgress).unwrap();
    assert!(!morphs.targets.is_empty());
    for target in &morphs.targets {
        assert!(matches!(target.normals, Some(Values::I8(_))), "{target:?}");
    }
}

fn unit(n: [f32; 3]) -> [f32; 3] {
    let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
    n.map(|x| x / length)
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mut animation = made_up(50, 1000, 12);
    let mut random = Random(5);
    animation.iter_mut().flatten().for_each(|x| *x += (0.01 * random.next().powi(5)) as f32);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| compress(&animation, settings(0.012, true)).unwrap())
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn the_number_of_threads_does_not_matter_for_a_long_take() {
    let mut animation = long(640);
    let mut random = Random(5);
    animation.iter_mut().flatten().for_each(|x| *x += (0.01 * random.next().powi(5)) as f32);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| compress(&animation, settings(0.012, true)).unwrap())
    };
    assert_eq!(on(1), on(3));
}

/// More frames than the first search looks at. Two vertices move alone, each in a few frames, and so little
/// that hardly any comparison of whole frames would show it.
fn long(frames: usize) -> Vec<Vec<f32>> {
    let mut animation = made_up(frames, 60, 6);
    for (vertex, alone) in [(5, 217..219), (33, frames - 20..frames - 18)] {
        animation[alone].iter_mut().for_each(|frame| frame[3 * vertex] += 0.08);
    }
    animation
}

#[test]
fn a_long_take_is_within_the_bound_in_every_frame() {
    let animation = long(2100);
    for (quantize, bound) in [(false, 0.01), (true, 0.02)] {
        let morphs = compress(&animation, settings(bound, quantize)).unwrap();
        assert_eq!(morphs.targets.len(), 8, "6 shapes, and one for each vertex that moves alone");
    }
    let few = Settings { most_targets: 7, ..settings(0.01, false) };
    let error = compress(&animation, few).unwrap_err().to_string();
    assert!(error.contains("more than 7 morph targets"), "{error}");
}

/// Beside the search that compares all frames, with motion that is not of low rank.
#[test]
fn a_long_take_needs_hardly_more_targets_than_if_all_its_frames_are_compared() {
    let mut animation = made_up(640, 40, 6);
    let mut random = Random(9);
    for bump in 0..30 {
        let (vertex, frame) = ((bump * 37) % 32, (bump * 131) % 630);
        for positions in &mut animation[frame..frame + 8] {
            for x in &mut positions[3 * vertex..3 * (vertex + 6)] {
                *x += (0.08 * random.next()) as f32;
            }
        }
    }
    let mut frames = spooled(&animation, None);
    let gram = frames.gram(&NoProgress).unwrap();
    let start = super::linear::principal(&gram.matrix).unwrap();
    let bound = 0.05;
    let numbers = super::search::Numbers { least: 0, most: 256, spare: 0.0 };
    let of_all =
        super::search::fewest(&mut frames, &gram, &start, bound, numbers, &NoProgress).unwrap().unwrap();
    let of_all = of_all.q.ncols() - 1;
    let found = compress(&animation, settings(bound / 0.98, false)).unwrap().targets.len();
    assert!(found <= of_all + 1 + of_all / 20, "{found} targets, {of_all} if all frames are compared");

    let nearest = super::search::nearest(&mut frames, &gram, &start, 10, None, &NoProgress).unwrap().1;
    let worst = bake(&animation, 10, false).worst();
    assert!(worst < 1.1 * nearest, "10 shapes are within {worst}, {nearest} if all frames are compared");
}

/// Cancels after some reports.
struct Stops(AtomicUsize);

impl Progress for Stops {
    fn report(&self, _: &'static str, done: u64, total: u64) {
        assert!(done <= total);
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
    fn cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

#[test]
fn it_stops_when_asked() {
    let animation = made_up(30, 100, 4);
    for reports in [1, 2, 3, 4] {
        let stopped =
            spooled(&animation, None).compress(&settings(1e-3, true), &Stops(AtomicUsize::new(reports)));
        assert!(matches!(stopped, Err(Error::Cancelled)), "after {reports} reports");
    }
}

#[test]
fn a_frame_of_another_length_is_an_error() {
    let mut frames = spooled(&made_up(2, 10, 1), None);
    assert!(frames.push(&[0.0; 27], None, &[]).is_err());
    assert!(frames.push(&[0.0; 30], Some(&[0.0; 30]), &[]).is_err());
}
