//! Comparison of variances and planned scans with their definitions by dense matrices.
use faer::Mat;
use faer::linalg::solvers::Solve;
use rhytid_core::{Example, Face, LearnedSettings, Method, NoProgress, Rig, VertexId};
use rhytid_kernels::bands::EDGES_SHARE;
use rhytid_solve::{Confidence, plan_scans, solve};
use rhytid_test_support::sheet;

/// Numbers without a pattern, in −1..1.
fn number(i: usize) -> f64 {
    ((i as f64 * 12.9898).sin() * 43758.5453).fract()
}

fn face(examples: usize, share: f64) -> Face {
    let mut face = sheet::face();
    let learned = LearnedSettings {
        share: Some(share),
        ridge: Some(1e-2),
        // Without noise, the examples explain everything.
        marker_noise: 0.0,
        // σ is of the whole band.
        fade: false,
        ..LearnedSettings::default()
    };
    face.settings.method = Method::Learned(learned);
    face.examples = (0..examples)
        .map(|p| {
            let moved = |(v, x): (usize, &[f64; 3])| [0, 1, 2].map(|c| x[c] + number(97 * p + 3 * v + c));
            let positions = face.neutral.positions.iter().enumerate().map(moved).collect();
            Example { name: format!("p{p}"), positions, mirror: false, noise: Some(0.0) }
        })
        .collect();
    face
}

/// frames × H handle positions.
fn frames(rig: &Rig<f64>, count: usize) -> Vec<[f64; 3]> {
    let rest = rig.handles().rest.iter().copied();
    let frame = |i: usize| {
        rest.clone()
            .enumerate()
            .map(move |(h, x)| [0, 1, 2].map(|c| x[c] + 2.0 * number(7000 + 31 * i + 3 * h + c)))
    };
    (0..count).flat_map(frame).collect()
}

/// ω and D of a pose at a vertex, by their definitions; ω of all F + H features.
fn omega(rig: &Rig<f64>, v: usize) -> Vec<f64> {
    let learned = rig.learned().unwrap();
    let edges = rig.handles().strain_edges.len();
    let mut omega = vec![0.0; rig.handles().features()];
    for (edge, alpha) in rig.influences().at(v) {
        omega[edge.index()] += EDGES_SHARE * alpha;
    }
    for (handle, nu) in learned.anchors_of(v) {
        omega[edges + handle.index()] += nu;
    }
    omega
}

fn vector_strains(rig: &Rig<f64>, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let u: Vec<[f64; 3]> = (positions.iter().zip(&rig.handles().rest))
        .map(|(x, rest)| [0, 1, 2].map(|c| x[c] - rest[c]))
        .collect();
    let lengths = rig.handles().feature_lengths();
    let of_edges = rig
        .handles()
        .strain_edges
        .iter()
        .zip(&lengths)
        .map(|(&[a, b], l)| [0, 1, 2].map(|c| (u[b.index()][c] - u[a.index()][c]) / l));
    of_edges.chain(u.iter().map(|u| u.map(|x| x / lengths[lengths.len() - 1]))).collect()
}

fn examples(rig: &Rig<f64>) -> Vec<Vec<[f64; 3]>> {
    rig.examples().handles.rows().map(|at| vector_strains(rig, at)).collect()
}

fn noise(rig: &Rig<f64>, omega: &[f64]) -> f64 {
    let sigma = rig.learned().unwrap().marker_noise;
    let lengths = rig.handles().feature_lengths();
    let of_feature = |(e, w): (usize, &f64)| {
        w * if e < rig.handles().strain_edges.len() { 2.0 } else { 1.0 } * (sigma / lengths[e]).powi(2)
    };
    omega.iter().enumerate().map(of_feature).sum()
}

/// `(1 − s) K1 + s K3` of two poses, 3×3.
fn kernel(omega: &[f64], share: f64, a: &[[f64; 3]], b: &[[f64; 3]]) -> Mat<f64> {
    let sum = |i: usize, j: usize| -> f64 { (0..omega.len()).map(|e| omega[e] * a[e][i] * b[e][j]).sum() };
    let kappa: f64 = (0..3).map(|c| sum(c, c)).sum();
    Mat::from_fn(3, 3, |i, j| (1.0 - share) * sum(i, j) + if i == j { share * kappa } else { 0.0 })
}

#[test]
fn variances_are_what_a_gaussian_process_has_left() {
    for share in [0.0, 0.2, 1.0] {
        let rig = solve(&face(4, share), &NoProgress).unwrap();
        let vertices: Vec<VertexId> = (0..25).map(VertexId).collect();
        let confidence = Confidence::new(&rig, &vertices).unwrap();
        let count = 3;
        let positions = frames(&rig, count);
        let found = confidence.variances(&positions);
        let (examples, learned) = (examples(&rig), rig.learned().unwrap());
        let left_out: Vec<f64> = confidence.left_out().collect();
        let mut compared = 0;
        for v in 0..25 {
            let omega = omega(&rig, v);
            let block = |p: usize, q: usize| kernel(&omega, share, &examples[p], &examples[q]);
            let tau = (0..4)
                .flat_map(|p| (0..3).map(move |c| (p, c)))
                .map(|(p, c)| block(p, p)[(c, c)])
                .sum::<f64>()
                / (12.0 * (1.0 + 2.0 * share));
            let diagonal = learned.ridge + noise(&rig, &omega) / tau;
            let system = Mat::from_fn(12, 12, |i, j| {
                block(i / 3, j / 3)[(i % 3, j % 3)] / tau + if i == j { diagonal } else { 0.0 }
            });
            let own = learned.variances[v];
            for (f, at) in positions.chunks(rig.handles().len()).enumerate() {
                let frame = vector_strains(&rig, at);
                let k = Mat::from_fn(12, 3, |i, d| {
                    kernel(&omega, share, &examples[i / 3], &frame)[(i % 3, d)] / tau
                });
                let told = k.transpose() * system.partial_piv_lu().solve(&k);
                let all = kernel(&omega, share, &frame, &frame);
                let left: f64 = (0..3).map(|c| all[(c, c)] / tau - told[(c, c)]).sum();
                let found = found[f * 25 + v];
                assert!(
                    (found - own * left).abs() < 1e-9 * (1.0 + own),
                    "{share}, {v}: {found}, not {}",
                    own * left
                );
                compared += usize::from(found > 1e-6);
            }
            // A left-out example is a frame like others, except for the addition to the diagonal.
            let of_example = |p: usize| -> f64 {
                let others: Vec<usize> = (0..12).filter(|i| i / 3 != p).collect();
                let rest = Mat::from_fn(9, 9, |i, j| system[(others[i], others[j])]);
                let k = Mat::from_fn(9, 3, |i, d| system[(others[i], 3 * p + d)]);
                let told = k.transpose() * rest.partial_piv_lu().solve(&k);
                (0..3).map(|c| system[(3 * p + c, 3 * p + c)] - told[(c, c)]).sum()
            };
            let expected = own * (0..4).map(of_example).sum::<f64>() / 4.0;
            assert!(
                (left_out[v] - expected).abs() < 1e-9 * (1.0 + own),
                "{share}, {v}: {} {expected}",
                left_out[v]
            );
        }
        assert!(compared > 30, "{compared}");
        // At rest the variance is 0, and also at a handle, which is where its marker is.
        let rest: Vec<[f64; 3]> = rig.handles().rest.clone();
        assert!(confidence.variances(&rest).iter().all(|variance| *variance == 0.0));
        assert!(rig.handles().held().all(|v| found[v.index()] == 0.0));
    }
}

#[test]
fn a_rig_that_has_learned_nothing_has_no_confidence() {
    let rig = solve(&face(0, 0.2), &NoProgress).unwrap();
    assert!(Confidence::new(&rig, &[VertexId(1)]).err().unwrap().to_string().contains("an example"));
    let mut face = face(2, 0.2);
    face.settings.method = Method::Chapter;
    let rig = solve(&face, &NoProgress).unwrap();
    assert!(Confidence::sampled(&rig, 10).err().unwrap().to_string().contains("method = \"learned\""));
    assert!(
        plan_scans(&rig, &[], &[], 1, &|_, _| false, &NoProgress)
            .unwrap_err()
            .to_string()
            .contains("method = \"learned\"")
    );
}

/// The plan by the covariances of all pairs of frames, given the examples and the scans so far.
fn plan_by_definition(
    rig: &Rig<f64>,
    positions: &[[f64; 3]],
    candidates: &[usize],
    count: usize,
    ridge: f64,
) -> (Vec<usize>, Vec<f64>) {
    let poses: Vec<Vec<[f64; 3]>> = examples(rig)
        .into_iter()
        .chain(positions.chunks(rig.handles().len()).map(|at| vector_strains(rig, at)))
        .collect();
    let (known, all) = (rig.examples().names.len(), poses.len());
    let vertices = plan_scans(rig, positions, candidates, 0, &|_, _| false, &NoProgress).unwrap().vertices;
    let mut covariances: Vec<(Mat<f64>, f64)> = vertices
        .iter()
        .map(|&v| {
            let omega = omega(rig, v.index());
            let kappa = |i: usize, j: usize| -> f64 {
                (0..omega.len())
                    .map(|e| omega[e] * (0..3).map(|c| poses[i][e][c] * poses[j][e][c]).sum::<f64>())
                    .sum()
            };
            let tau = (known..all).map(|i| kappa(i, i)).sum::<f64>() / (all - known) as f64;
            let mut covariance = Mat::from_fn(all, all, |i, j| kappa(i, j) / tau);
            let noise = ridge + noise(rig, &omega) / tau;
            (0..known).for_each(|p| observe(&mut covariance, p, noise));
            (covariance, noise)
        })
        .collect();
    let left = |covariances: &[(Mat<f64>, f64)]| {
        let of_vertex = |(c, _): &(Mat<f64>, f64)| (known..all).map(|i| c[(i, i)]).sum::<f64>();
        (covariances.iter().map(of_vertex).sum::<f64>() / (covariances.len() * (all - known)) as f64).sqrt()
    };
    let (mut chosen, mut lefts) = (Vec::new(), vec![left(&covariances)]);
    while chosen.len() < count {
        let gain = |j: usize| -> f64 {
            let of_vertex = |(c, noise): &(Mat<f64>, f64)| {
                (known..all).map(|i| c[(i, known + j)].powi(2)).sum::<f64>()
                    / (c[(known + j, known + j)] + noise)
            };
            covariances.iter().map(of_vertex).sum()
        };
        let open = candidates.iter().filter(|j| !chosen.contains(*j));
        let best = open.copied().max_by(|a, b| gain(*a).total_cmp(&gain(*b))).unwrap();
        chosen.push(best);
        covariances.iter_mut().for_each(|(c, noise)| observe(c, known + best, *noise));
        lefts.push(left(&covariances));
    }
    (chosen, lefts)
}

fn observe(covariance: &mut Mat<f64>, j: usize, noise: f64) {
    let n = covariance.nrows();
    let column: Vec<f64> = (0..n).map(|i| covariance[(i, j)]).collect();
    let variance = column[j] + noise;
    for i in 0..n {
        for k in 0..n {
            covariance[(i, k)] -= column[i] * column[k] / variance;
        }
    }
}

#[test]
fn planned_scans_take_the_most_variance() {
    for (known, ridge) in [(0, 1e-2), (2, 1e-2)] {
        let rig = solve(&face(known, 0.2), &NoProgress).unwrap();
        let positions = frames(&rig, 12);
        let candidates = [11, 1, 2, 3, 5, 7, 8];
        let plan = plan_scans(&rig, &positions, &candidates, 4, &|_, _| false, &NoProgress).unwrap();
        let (chosen, lefts) = plan_by_definition(&rig, &positions, &candidates, 4, ridge);
        assert_eq!(plan.scans.iter().map(|scan| scan.frame).collect::<Vec<_>>(), chosen);
        let found: Vec<f64> =
            std::iter::once(plan.left).chain(plan.scans.iter().map(|scan| scan.left)).collect();
        assert!(found.iter().zip(&lefts).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}, not {lefts:?}");
        assert_eq!(known == 0, (plan.left - 1.0).abs() < 1e-9, "{}", plan.left);
        for (scan, pair) in plan.scans.iter().zip(found.windows(2)) {
            let gain = scan.gains.iter().sum::<f64>() / scan.gains.len() as f64;
            assert!((pair[0].powi(2) - gain - pair[1].powi(2)).abs() < 1e-9);
        }
        // Frames that are like one before are left out.
        let next = |a: usize, b: usize| a.abs_diff(b) == 1;
        let apart = plan_scans(&rig, &positions, &candidates, 100, &next, &NoProgress).unwrap();
        let apart: Vec<usize> = apart.scans.iter().map(|scan| scan.frame).collect();
        assert_eq!((apart[0], apart.iter().any(|a| apart.iter().any(|b| next(*a, *b)))), (chosen[0], false));
        let left_out = candidates.iter().filter(|j| !apart.contains(j));
        assert!(
            apart.len() >= 4 && left_out.copied().all(|j| apart.iter().any(|a| next(*a, j))),
            "{apart:?}"
        );
        let mean = plan.variances.iter().sum::<f64>() / plan.variances.len() as f64;
        assert!((mean - plan.left.powi(2)).abs() < 1e-12, "{mean}");
        // More scans than there are candidates.
        assert_eq!(
            plan_scans(&rig, &positions, &candidates, 100, &|_, _| false, &NoProgress).unwrap().scans.len(),
            7
        );
    }
}
