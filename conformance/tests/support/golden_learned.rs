//! The golden cases of the learned method: float64 values by an independent implementation.
use rhytid_conformance::worst_difference;
use rhytid_core::{
    Device, Example, Face, Faces, Handles, LearnedSettings, Mesh, Method, NoProgress, Rig, Settings, Stage,
    StrainEdges, UpAxis, UploadOptions, WrinkleStrains,
};
use rhytid_core::{HandleId, VertexId};
use rhytid_solve::solve;
use serde_json::Value;

/// The number of cases.
const CASES: usize = 3;

/// The largest error of a device, from the values and from the rest pose, over the bounding box's diagonal.
const TOLERANCE: f64 = 2e-5;
const AT_REST: f64 = 1e-6;

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().unwrap()],
    }
}

pub(crate) fn vectors(value: &Value) -> Vec<[f64; 3]> {
    numbers(value).as_chunks::<3>().0.to_vec()
}

fn indices(value: &Value) -> Vec<u32> {
    numbers(value).into_iter().map(|x| x as u32).collect()
}

/// The face of a case.
pub(crate) fn face(case: &Value) -> Face {
    let mut faces = Faces::default();
    indices(&case["triangles"]).as_chunks::<3>().0.iter().for_each(|triangle| faces.push(triangle));
    let handles = indices(&case["handles"]);
    let poses = case["poses"].as_array().unwrap().iter().enumerate();
    let method = Method::Learned(LearnedSettings {
        share: case["share"].as_f64(),
        ridge: case["ridge"].as_f64(),
        // The vectors have mesh units, which are centimetres here.
        marker_noise: 10.0 * case["marker_noise"].as_f64().unwrap(),
        wrinkle_ridge: case["fold_ridge"].as_f64().unwrap(),
        // The cases continue linearly for any distance of a frame from their poses, and turn their wrinkles.
        reach: Some(f64::INFINITY),
        fade: false,
        wrinkle_strains: WrinkleStrains::Lengths,
    });
    Face {
        name: "golden".into(),
        neutral: Mesh { positions: vectors(&case["rest"]), faces, ..Mesh::default() },
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles {
            labels: (0..handles.len()).map(|h| format!("h{h}")).collect(),
            points: handles.into_iter().map(|v| VertexId(v).into()).collect(),
        },
        examples: poses
            .map(|(p, pose)| Example {
                name: format!("p{p}"),
                positions: vectors(pose),
                mirror: false,
                noise: Some(0.0),
            })
            .collect(),
        prior: None,
        settings: Settings {
            bending_length: case["bending_length"].as_f64(),
            method,
            strain_edges: StrainEdges::Given(
                indices(&case["strain_edges"])
                    .as_chunks::<2>()
                    .0
                    .iter()
                    .map(|pair| pair.map(HandleId))
                    .collect(),
            ),
            max_influences: case["max_influences"].as_u64().unwrap() as usize,
            ..Settings::default()
        },
    }
}

/// Every case; empty, with a message, if the shared data is missing.
pub(crate) fn cases() -> Vec<Value> {
    let Some(folder) = rhytid_test_support::shared("golden") else { return Vec::new() };
    let read = |i: usize| {
        let text = std::fs::read_to_string(folder.join(format!("learned-{i}.json"))).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    (1..=CASES).map(read).collect()
}

/// The length of the bounding box's diagonal.
pub(crate) fn diagonal(face: &Face) -> f64 {
    let [low, high] = face.neutral.bounds().unwrap();
    low.iter().zip(high).map(|(low, high)| (high - low).powi(2)).sum::<f64>().sqrt()
}

/// Evaluates all frames of all cases, and the rest pose, on `device`. The error says what is wrong.
pub(crate) fn check(device: &Device, cases: &[Value]) -> Result<(), String> {
    let of_device = |e: rhytid_core::Error| e.to_string();
    for (case, i) in cases.iter().zip(1..) {
        let face = face(case);
        let rig: Rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let mut animator = device.upload(&rig, UploadOptions::frames(1)).map_err(of_device)?;
        let mut read = |handles: &[[f64; 3]], stage| {
            let handles: Vec<f32> = handles.as_flattened().iter().map(|&x| x as f32).collect();
            let mut found = Vec::new();
            animator.evaluate(&handles).and_then(|()| animator.read(stage, &mut found)).map_err(of_device)?;
            Ok::<_, String>(found)
        };
        let part = |found: &[f32], expected: &[f64]| worst_difference(found, expected).size / diagonal(&face);
        for frame in case["expected"]["frames"].as_array().unwrap() {
            let handles = vectors(&frame["handle_positions"]);
            for (what, stage) in [("large_scale", Stage::LargeScale), ("positions", Stage::Positions)] {
                let off = part(&read(&handles, stage)?, &numbers(&frame[what]));
                if off.is_nan() || off > TOLERANCE {
                    return Err(format!("learned-{i}: {what} is off by {off:.1e} of the diagonal"));
                }
            }
        }
        let rest: Vec<[f64; 3]> =
            face.handles.points.iter().map(|point| point.at(&face.neutral.positions)).collect();
        let off = part(&read(&rest, Stage::Positions)?, face.neutral.positions.as_flattened());
        if off.is_nan() || off > AT_REST {
            return Err(format!("learned-{i}: the rest pose is off by {off:.1e} of the diagonal"));
        }
    }
    Ok(())
}
