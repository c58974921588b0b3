//! The parts of a real take that its examples do not show, compared with a plain computation.

use crate::support::real::{clean_take, solved_face};
use rhytid_capture::coverage::coverage;
use rhytid_core::{HandleId, Rig, Table, Take};
use rhytid_test_support::{changed, shared};

/// Strains by their plain formula.
fn strains(rig: &Rig<f64>, positions: &[[f64; 3]]) -> Vec<f64> {
    let length = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let rest = |h: HandleId| rig.handles().rest[h.index()];
    let edges = rig.handles().strain_edges.iter();
    edges
        .map(|&[a, b]| {
            let l = length(rest(a), rest(b));
            (length(positions[a.index()], positions[b.index()]) - l) / l
        })
        .collect()
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / a.len() as f64).sqrt()
}

fn frame(take: &Take, frame: usize) -> &[[f64; 3]] {
    let m = take.labels.len();
    &take.positions[frame * m..][..m]
}

#[test]
fn the_first_expression_is_the_frame_that_is_farthest_from_all_examples() {
    let Some(shared) = shared("") else { return };
    let (face, rig) = solved_face(&shared);
    let take = clean_take(&shared, rig);
    let found = coverage(rig, &take, 5).unwrap();

    let at_handles =
        |p: &[[f64; 3]]| rig.handles().points.iter().map(|point| point.at(p)).collect::<Vec<_>>();
    let mut known = vec![vec![0.0; rig.handles().strain_edges.len()]];
    known.extend(face.examples.iter().map(|e| strains(rig, &at_handles(&e.positions))));
    let nearest = |known: &[Vec<f64>], frame_strains: &[f64]| {
        known.iter().map(|k| rms(k, frame_strains)).fold(f64::INFINITY, f64::min)
    };
    let all: Vec<Vec<f64>> = (0..take.frames()).map(|i| strains(rig, frame(&take, i))).collect();
    assert_eq!(found.expressions.len(), 5);
    let mut before = f64::INFINITY;
    let mut known_then = known.clone();
    for expression in &found.expressions {
        let distances: Vec<f64> = all.iter().map(|s| nearest(&known_then, s)).collect();
        let farthest = distances.iter().copied().fold(0.0, f64::max);
        println!(
            "frame {} ({:.2} s): {:.4} from {}, {:.2} spacings; {} of {} frames covered then",
            expression.frame,
            expression.time,
            expression.distance,
            expression.nearest,
            expression.relative.unwrap(),
            expression.covered,
            found.frames
        );
        assert!((expression.distance - farthest).abs() < 1e-5, "{} and {farthest}", expression.distance);
        assert!((distances[expression.frame] - farthest).abs() < 1e-5);
        assert!(expression.distance <= before);
        before = expression.distance;
        known_then.push(all[expression.frame].clone());
    }
    let first = &found.expressions[0];
    assert!(first.relative.unwrap() > 0.7, "the examples show nearly all: {first:?}");
    // A pose is named after its frame in the take.
    for example in &face.examples {
        let number: usize = example.name.rsplit('_').next().unwrap().parse().unwrap();
        assert!(found.distances[number] < 0.02 * found.spacing.unwrap(), "{}", example.name);
    }

    // Once scanned, the first expression leaves the top of the list, and fewer frames are uncovered.
    let scanned = changed(rig, |r| {
        let (vertices, centers, handles) = (r.surface.rest.len(), r.examples.len() + 2, r.handles.len());
        r.examples.names.push("scan".into());
        let features = [r.fine_scale.pose_features.as_slice(), &all[first.frame]].concat();
        r.fine_scale.pose_features = Table::new(centers, r.handles.strain_edges.len(), features);
        // Only the strains of its edges matter.
        r.fine_scale.rbf_weights = Table::filled(vertices, centers, [0.0; 3]);
        r.examples.handles = Table::filled(centers - 1, handles, [0.0; 3]);
        r.learned = None;
    })
    .unwrap();
    let then = coverage(&scanned, &take, 5).unwrap();
    assert!(then.distances[first.frame] < 1e-5);
    assert!(then.expressions[0].distance < first.distance && then.expressions[0].frame != first.frame);
    let mean = |distances: &[f64]| distances.iter().sum::<f64>() / distances.len() as f64;
    assert!(mean(&then.distances) < mean(&found.distances));

    // The edge that goes farthest is beyond every example in its frame. No edge of any frame goes farther.
    let edge = &found.edges[0];
    let over = |s: f64, e: usize| {
        let (low, high) =
            known.iter().fold((0.0_f64, 0.0_f64), |(low, high), k| (low.min(k[e]), high.max(k[e])));
        (s - high).max(low - s).max(0.0)
    };
    let millimetres = |e: usize| rig.handles().rest_lengths()[e] * 10.0;
    let mut worst = 0.0_f64;
    for strains in &all {
        for (e, &s) in strains.iter().enumerate().filter(|(e, s)| over(**s, *e) * millimetres(*e) > 0.5) {
            worst = worst.max(over(s, e));
        }
    }
    println!("{edge:?}");
    assert!((edge.beyond.abs() - worst).abs() < 1e-5, "{edge:?}, expected {worst}");
}
