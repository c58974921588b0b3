//! Comparison of the learned method's solve with float64 values of every step by an independent
//! implementation.
use super::learn;
use crate::shell;
use rhytid_core::{
    Example, Face, Faces, Handles, LearnedSettings, Mesh, NoProgress, Settings, StrainEdges, UpAxis,
    WrinkleStrains,
};
use rhytid_core::{HandleId, StrainEdgeId, Table, VertexId};
use rhytid_test_support::shared;
use serde::Deserialize;

/// The error that is allowed to every step, in mesh units or as a plain number.
const TOLERANCE: f64 = 1e-9;

#[derive(Deserialize)]
struct Case {
    rest: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    handles: Vec<u32>,
    strain_edges: Vec<[u32; 2]>,
    bending_length: f64,
    max_influences: usize,
    poses: Vec<Vec<[f64; 3]>>,
    share: f64,
    ridge: f64,
    #[serde(rename = "fold_ridge")]
    wrinkle_ridge: f64,
    marker_noise: f64,
    expected: Expected,
}

#[derive(Deserialize)]
struct Expected {
    shell_basis: Vec<Vec<f64>>,
    smooth_residual: Vec<Vec<[f64; 3]>>,
    basis_correction: Vec<Vec<f64>>,
    basis: Vec<Vec<f64>>,
    example_vectors: Vec<Vec<[f64; 3]>>,
    linear_weights: Vec<Vec<f64>>,
    linear_features: Vec<Vec<u32>>,
    example_weights: Vec<Vec<[f64; 3]>>,
    leave_one_out: Vec<Vec<[f64; 3]>>,
    influence_weights: Vec<Vec<f64>>,
    influence_edges: Vec<Vec<u32>>,
    pose_features: Vec<Vec<f64>>,
    detail: Vec<Vec<[f64; 3]>>,
    rbf_weights: Vec<Vec<[f64; 3]>>,
    rbf_constant: Vec<[f64; 3]>,
}

fn cases() -> Vec<(String, Case)> {
    let Some(folder) = shared("golden") else { return Vec::new() };
    let names = (1..=3).map(|i| format!("learned-{i}.json"));
    names
        .map(|name| {
            let text = std::fs::read_to_string(folder.join(&name)).unwrap();
            (name, serde_json::from_str(&text).unwrap())
        })
        .collect()
}

fn face(case: &Case) -> Face {
    let mut faces = Faces::default();
    case.triangles.iter().for_each(|triangle| faces.push(triangle));
    let labels = (0..case.handles.len()).map(|h| format!("h{h}")).collect();
    let poses = case.poses.iter().enumerate();
    Face {
        name: "golden".into(),
        neutral: Mesh { positions: case.rest.clone(), faces, ..Mesh::default() },
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles { labels, points: case.handles.iter().map(|v| VertexId(*v).into()).collect() },
        examples: poses
            .map(|(p, positions)| Example {
                name: format!("p{p}"),
                positions: positions.clone(),
                mirror: false,
                noise: Some(0.0),
            })
            .collect(),
        prior: None,
        settings: Settings {
            bending_length: Some(case.bending_length),
            strain_edges: StrainEdges::Given(
                case.strain_edges.iter().map(|pair| pair.map(HandleId)).collect(),
            ),
            max_influences: case.max_influences,
            ..Settings::default()
        },
    }
}

#[track_caller]
fn near<'a>(what: &str, got: impl IntoIterator<Item = &'a f64>, expected: impl IntoIterator<Item = &'a f64>) {
    let (mut worst, mut count) = (0.0_f64, 0);
    let mut got = got.into_iter();
    for (i, expected) in expected.into_iter().enumerate() {
        let got = got.next().unwrap_or_else(|| panic!("{what}: ends at {i}"));
        let off = (got - expected).abs();
        assert!(off <= TOLERANCE, "{what}: {i}: {got} instead of {expected}");
        worst = worst.max(off);
        count += 1;
    }
    assert!(got.next().is_none(), "{what}: more than {count}");
    eprintln!("{what}: {count} within {worst:.1e}");
}

/// Weights by their index, without weights of 0. In the test vectors, the nearest come first.
fn by_index(indices: &[u32], weights: &[f64]) -> Vec<(u32, f64)> {
    let both = indices.iter().copied().zip(weights.iter().copied());
    let mut both: Vec<_> = both.filter(|(_, w)| *w > TOLERANCE).collect();
    both.sort_unstable_by_key(|&(index, _)| index);
    both
}

#[track_caller]
fn same_weights(what: &str, got: (&[u32], &[f64]), expected: (&[Vec<u32>], &[Vec<f64>])) {
    let per_vertex = got.0.len() / expected.0.len();
    for (v, (indices, weights)) in expected.0.iter().zip(expected.1).enumerate() {
        let of_vertex = v * per_vertex..(v + 1) * per_vertex;
        let got = by_index(&got.0[of_vertex.clone()], &got.1[of_vertex]);
        let expected = by_index(indices, weights);
        assert_eq!(got.len(), expected.len(), "{what} of vertex {v}: {got:?} instead of {expected:?}");
        for (got, expected) in got.iter().zip(&expected) {
            assert_eq!(got.0, expected.0, "{what} of vertex {v}");
            assert!(
                (got.1 - expected.1).abs() <= TOLERANCE,
                "{what} of vertex {v}: {got:?} instead of {expected:?}"
            );
        }
    }
}

#[test]
fn every_step_is_that_of_the_golden_vectors() {
    for (name, case) in cases() {
        let face = face(&case);
        let mut started = shell(&face, &NoProgress).unwrap();
        let shell = started.basis.clone().into_vec();
        let e = &case.expected;
        near(&format!("{name}: shell"), &shell, e.shell_basis.iter().flatten());

        let settings = LearnedSettings {
            share: Some(case.share),
            ridge: Some(case.ridge),
            // The test vectors have it in mesh units, which are centimetres here.
            marker_noise: 10.0 * case.marker_noise,
            wrinkle_ridge: case.wrinkle_ridge,
            // The cases are linear at any distance of their frames from their poses. Their wrinkles turn with
            // the surface.
            reach: Some(f64::INFINITY),
            fade: false,
            wrinkle_strains: WrinkleStrains::Lengths,
        };
        let got = learn(&mut started, &face, settings, &NoProgress).unwrap();
        let basis = started.basis.as_slice();
        let vectors = |v: &[Vec<[f64; 3]>]| v.iter().flatten().flatten().copied().collect::<Vec<f64>>();
        let by_vertex = |what: &str, got: &Table<[f64; 3]>, expected: &[Vec<[f64; 3]>]| {
            near(&format!("{name}: {what}"), got.as_slice().as_flattened(), &vectors(expected));
        };
        by_vertex("smooth residual", &got.smooth_residual, &e.smooth_residual);
        same_weights(
            "influences",
            (StrainEdgeId::numbers(got.influences.edges.as_slice()), got.influences.weights.as_slice()),
            (&e.influence_edges, &e.influence_weights),
        );
        let linear = &got.linear_influences;
        same_weights(
            "linear influences",
            (linear.features.as_slice(), linear.weights.as_slice()),
            (&e.linear_features, &e.linear_weights),
        );
        by_vertex("vector strains", &got.example_vectors, &e.example_vectors);
        let correction: Vec<f64> = basis.iter().zip(&shell).map(|(b, shell)| b - shell).collect();
        near(&format!("{name}: correction"), &correction, e.basis_correction.iter().flatten());
        near(&format!("{name}: basis"), basis, e.basis.iter().flatten());
        if case.share > 0.0 {
            by_vertex("example weights", &got.band.example_weights, &e.example_weights);
        } else {
            assert!(got.band.example_weights.is_empty());
        }
        let all: Vec<VertexId> = (0..case.rest.len()).map(VertexId::from_index).collect();
        by_vertex("leave one out", &got.leave_one_out(&all).unwrap(), &e.leave_one_out);
        near(&format!("{name}: features"), got.pose_features.as_slice(), e.pose_features.iter().flatten());
        let detail: Vec<f64> = (0..case.rest.len())
            .flat_map(|v| (0..case.poses.len()).map(move |p| (v, p)))
            .flat_map(|(v, p)| got.detail.row(p)[v])
            .collect();
        near(&format!("{name}: detail"), &detail, &vectors(&e.detail));
        by_vertex("wrinkles", &got.wrinkles.weights, &e.rbf_weights);
        near(
            &format!("{name}: constants"),
            got.wrinkles.constants.as_flattened(),
            e.rbf_constant.as_flattened(),
        );
    }
}
