//! The golden cases: float64 values of every intermediate, by an independent implementation.

use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{evaluate, worst_difference};
use rhytid_core::{
    Animator, Backend, Example, Face, Faces, Handles, Mesh, Method, NoProgress, Rig, Settings, Stage,
    StrainEdges, UpAxis, UploadOptions,
};
use rhytid_core::{HandleId, StrainEdgeId, VertexId};
use rhytid_solve::solve;
use rhytid_test_support::shared;
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    rest: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    handles: Vec<u32>,
    strain_edges: Vec<[u32; 2]>,
    stretch_stiffness: f64,
    bending_stiffness: f64,
    max_influences: usize,
    poses: Vec<Vec<[f64; 3]>>,
    expected: Expected,
}

#[derive(Deserialize)]
struct Expected {
    rest_normals: Vec<[f64; 3]>,
    beta: f64,
    basis: Vec<Vec<f64>>,
    influence_weights: Vec<Vec<f64>>,
    influence_edges: Vec<Vec<u32>>,
    /// The vectors' own name of this key.
    #[serde(rename = "frame_neighbors")]
    tangent_neighbors: Vec<u32>,
    pose_features: Vec<Vec<f64>>,
    rbf_weights: Vec<Vec<[f64; 3]>>,
    frames: Vec<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    handle_positions: Vec<[f64; 3]>,
    strain: Vec<f64>,
    large_scale: Vec<[f64; 3]>,
    large_scale_normals: Vec<[f64; 3]>,
    positions: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
}

impl Expected {
    /// Sorts from the vectors' order, the nearest edge first, to the rigs' order, ascending indices.
    fn sort_influences(&mut self) {
        for (edges, weights) in self.influence_edges.iter_mut().zip(&mut self.influence_weights) {
            let mut both: Vec<_> = edges.iter().copied().zip(weights.iter().copied()).collect();
            both.sort_unstable_by_key(|&(edge, _)| edge);
            (*edges, *weights) = both.into_iter().unzip();
        }
    }
}

/// Every golden case. Their number is fixed.
fn cases() -> Vec<(String, Case)> {
    let Some(shared) = shared("") else { return Vec::new() };
    let mut paths: Vec<_> =
        std::fs::read_dir(shared.join("golden")).unwrap().map(|entry| entry.unwrap().path()).collect();
    // The other files belong to other methods.
    paths.retain(|path| path.file_name().unwrap().to_string_lossy().starts_with("case-"));
    paths.sort();
    assert_eq!(paths.len(), 3, "golden cases found: {paths:?}");
    paths
        .into_iter()
        .map(|path| {
            let text = std::fs::read_to_string(&path).unwrap();
            let mut case: Case = serde_json::from_str(&text).unwrap();
            case.expected.sort_influences();
            (path.file_stem().unwrap().to_string_lossy().into_owned(), case)
        })
        .collect()
}

fn solve_case(case: &Case) -> Rig<f64> {
    let faces =
        Faces { counts: vec![3; case.triangles.len()], indices: case.triangles.as_flattened().to_vec() };
    let face = Face {
        name: "golden".into(),
        neutral: Mesh { positions: case.rest.clone(), faces, ..Mesh::default() },
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles {
            labels: (0..case.handles.len()).map(|h| format!("m{h}")).collect(),
            points: case.handles.iter().copied().map(|v| VertexId(v).into()).collect(),
        },
        examples: (0..)
            .zip(&case.poses)
            .map(|(j, positions)| Example {
                name: format!("pose {j}"),
                positions: positions.clone(),
                mirror: false,
                noise: None,
            })
            .collect(),
        prior: None,
        settings: Settings {
            bending_length: Some((case.bending_stiffness / case.stretch_stiffness).sqrt()),
            strain_edges: StrainEdges::Given(
                case.strain_edges.iter().map(|pair| pair.map(HandleId)).collect(),
            ),
            max_influences: case.max_influences,
            method: Method::Chapter,
            ..Settings::default()
        },
    };
    solve(&face, &NoProgress).unwrap()
}

/// The worst difference over the reference's largest value.
fn relative(found: &[f64], expected: &[f64]) -> f64 {
    let largest = expected.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    worst_difference(found, expected).size / largest
}

fn bounding_box_diagonal(points: &[[f64; 3]]) -> f64 {
    let extent = |c: usize| {
        let values = points.iter().map(|p| p[c]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    (0..3).map(|c| extent(c).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn every_intermediate_of_the_solve_is_within_1e_9() {
    for (name, case) in cases() {
        let rig = solve_case(&case);
        let expected = &case.expected;
        let flat = |rows: &[Vec<f64>]| rows.concat();
        let (edges, neighbors) = (rig.influences().edges.as_slice(), &rig.surface().tangent_neighbors);
        assert_eq!(
            StrainEdgeId::numbers(edges),
            expected.influence_edges.concat(),
            "{name}: influence edges"
        );
        assert_eq!(VertexId::numbers(neighbors), expected.tangent_neighbors, "{name}: tangent neighbours");
        let rest = evaluate(&rig, &case.handles.iter().map(|&v| case.rest[v as usize]).collect::<Vec<_>>());
        let errors = [
            (
                "rest_normals",
                relative(rest.stage(Stage::LargeScaleNormals), expected.rest_normals.as_flattened()),
            ),
            ("beta", relative(&[rig.influences().beta], &[expected.beta])),
            ("basis", relative(rig.basis().as_slice(), &flat(&expected.basis))),
            (
                "influence_weights",
                relative(rig.influences().weights.as_slice(), &flat(&expected.influence_weights)),
            ),
            (
                "pose_features",
                relative(rig.fine_scale().pose_features.as_slice(), &flat(&expected.pose_features)),
            ),
            (
                "rbf_weights",
                relative(
                    rig.fine_scale().rbf_weights.as_slice().as_flattened(),
                    expected.rbf_weights.concat().as_flattened(),
                ),
            ),
        ];
        for (array, error) in errors {
            println!("{name}: {array}: {error:.1e}");
            assert!(error <= 1e-9, "{name}: {array} is off by {error:e} of its largest value");
        }
    }
}

/// The stages that the golden cases have, of all frames, one after the other.
fn expected_stages(case: &Case) -> [(Stage, Vec<f64>); 5] {
    let vectors = |of: fn(&Frame) -> &Vec<[f64; 3]>| -> Vec<f64> {
        case.expected.frames.iter().flat_map(|f| of(f).as_flattened().to_vec()).collect()
    };
    [
        (Stage::Strain, case.expected.frames.iter().flat_map(|f| f.strain.clone()).collect()),
        (Stage::LargeScale, vectors(|f| &f.large_scale)),
        (Stage::LargeScaleNormals, vectors(|f| &f.large_scale_normals)),
        (Stage::Positions, vectors(|f| &f.positions)),
        (Stage::Normals, vectors(|f| &f.normals)),
    ]
}

fn handle_frames(case: &Case) -> Vec<[f64; 3]> {
    case.expected.frames.iter().flat_map(|f| f.handle_positions.clone()).collect()
}

#[test]
fn every_stage_of_the_f64_reference_is_within_1e_9() {
    for (name, case) in cases() {
        let results = evaluate(&solve_case(&case), &handle_frames(&case));
        for (stage, expected) in expected_stages(&case) {
            let error = relative(results.stage(stage), &expected);
            println!("{name}: {stage:?}: {error:.1e}");
            assert!(error <= 1e-9, "{name}: {stage:?} is off by {error:e} of its largest value");
        }
    }
}

#[test]
fn every_stage_of_the_cpu_backend_is_within_2e_5() {
    for (name, case) in cases() {
        let rig = solve_case(&case).rounded().unwrap();
        let frames = handle_frames(&case);
        let positions: Vec<f32> = frames.as_flattened().iter().map(|&x| x as f32).collect();
        let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
        let mut animator =
            Animator::new(&cpu, &rig, UploadOptions::frames(case.expected.frames.len())).unwrap();
        animator.evaluate(&positions).unwrap();
        for (stage, expected) in expected_stages(&case) {
            let mut found = Vec::new();
            animator.read(stage, &mut found).unwrap();
            let (scale, tolerance) = match stage {
                Stage::LargeScale | Stage::Positions | Stage::Detail => {
                    (bounding_box_diagonal(&case.rest), 2e-5)
                }
                Stage::LargeScaleNormals | Stage::Normals => (1.0, 1e-4),
                // A strain is a ratio of lengths. The error comes from f32 coordinates of the size of the
                // mesh.
                Stage::Strain => (1.0, 2e-5),
            };
            let error = worst_difference(&found, &expected).size / scale;
            println!("{name}: {stage:?}: {error:.1e}");
            assert!(error <= tolerance, "{name}: {stage:?} is off by {error:e}, allowed is {tolerance:e}");
        }
    }
}
