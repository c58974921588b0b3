//! Meshes with shapes, from morph targets.

use super::support::message;
use base64::Engine;
use rhytid_core::UpAxis;
use rhytid_formats::mesh::{Shapes, has_shapes, read, read_shapes};
use rhytid_test_support::shared;
use serde_json::{Value, json};
use std::path::Path;

/// A head of three vertices that is turned by a quarter about z, and teeth beside it. Both have a target
/// called smile.
fn document() -> Value {
    let mut data = Vec::new();
    let mut views = Vec::new();
    let mut push = |bytes: Vec<u8>| {
        views.push(json!({"buffer": 0, "byteOffset": data.len(), "byteLength": bytes.len()}));
        data.extend(bytes);
    };
    let floats = |points: &[[f32; 3]]| points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    push(floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]));
    push(floats(&[[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.25]]));
    // One displacement, of the vertex 2.
    push(vec![2, 0, 0, 0]);
    push(floats(&[[3.0, 0.0, 0.0]]));
    let vectors =
        |view: usize| json!({"bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3"});
    let sparse = json!({
        "componentType": 5126, "count": 3, "type": "VEC3",
        "sparse": {
            "count": 1,
            "indices": {"bufferView": 2, "componentType": 5123},
            "values": {"bufferView": 3},
        },
    });
    let uri = format!("data:;base64,{}", base64::prelude::BASE64_STANDARD.encode(&data));
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "rotation": [0, 0, quarter, quarter]}, {"mesh": 1, "translation": [0, 0, 9]}],
        "meshes": [
            {
                "primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 1}, {"POSITION": 2}, {}]}],
                "extras": {"targetNames": ["smile", "lick", "smile"]},
            },
            {
                "primitives": [{"attributes": {"POSITION": 0}, "targets": [{"POSITION": 2}, {"POSITION": 1}]}],
                "extras": {"targetNames": ["smile"]},
            },
        ],
        "accessors": [vectors(0), vectors(1), sparse],
        "bufferViews": views,
        "buffers": [{"byteLength": data.len(), "uri": uri}],
    })
}

fn load(document: &Value) -> rhytid_core::Result<Shapes> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    let found = read_shapes(&path);
    if let Ok(found) = &found {
        assert_eq!(found.neutral, read(&path).unwrap());
    }
    found
}

#[test]
fn shapes_have_names_and_the_place_of_their_node() {
    let Shapes { neutral, shapes, space, .. } = load(&document()).unwrap();
    assert_eq!((space.metres_per_unit, space.up), (Some(1.0), Some(UpAxis::Y)));
    let names: Vec<&str> = shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["smile", "lick", "smile 2", "shape 2"]);
    let expected: [&[(u32, [f64; 3])]; 4] = [
        &[(1, [-0.5, 0.0, 0.0]), (2, [0.0, 0.0, 0.25]), (5, [3.0, 0.0, 0.0])],
        &[(2, [0.0, 3.0, 0.0])],
        &[],
        &[(4, [0.0, 0.5, 0.0]), (5, [0.0, 0.0, 0.25])],
    ];
    for (shape, expected) in shapes.iter().zip(expected) {
        let moved = shape.on(&neutral.positions);
        let mut positions = neutral.positions.clone();
        for (v, by) in expected {
            positions[*v as usize].iter_mut().zip(by).for_each(|(x, by)| *x += by);
        }
        for (found, expected) in moved.iter().flatten().zip(positions.iter().flatten()) {
            assert!((found - expected).abs() < 1e-7, "{shape:?}");
        }
    }
}

#[test]
fn wrong_shapes_are_one_sentence() {
    let refused = |change: fn(&mut Value)| {
        let mut document = document();
        change(&mut document);
        message(load(&document).map(|_| ()))
    };
    let said = refused(|d| d["accessors"][1]["count"] = 2.into());
    assert!(said.contains("the shape \"smile\" moves 2 vertices, expected the 3 of its mesh"), "{said}");
    let said = refused(|d| d["accessors"][1]["type"] = "VEC2".into());
    assert!(said.contains("accessor 1 does not have 3 components"), "{said}");
    let said = refused(|d| {
        let many = vec![json!({"POSITION": 1}); 70_000];
        d["meshes"][0]["primitives"][0]["targets"] = many.into();
    });
    assert!(said.contains("its shapes repeat the same data"), "{said}");
    // The same with displacements that are not stored, so all are 0.
    let said = refused(|d| {
        let count = 30_000;
        let uri = format!("data:;base64,{}", base64::prelude::BASE64_STANDARD.encode(vec![0; 12 * count]));
        d["buffers"][0] = json!({"byteLength": 12 * count, "uri": uri});
        d["bufferViews"][0]["byteLength"] = (12 * count).into();
        d["accessors"][0]["count"] = count.into();
        d["accessors"][1] = json!({"componentType": 5126, "count": count, "type": "VEC3"});
        d["meshes"][0]["primitives"][0]["targets"] = vec![json!({"POSITION": 1}); 1000].into();
    });
    assert!(said.contains("its shapes repeat the same data"), "{said}");
    for path in ["face.obj", "face.stl"] {
        let said = message(read_shapes(Path::new(path)).map(|_| ()));
        assert!(said.contains("glb") && !has_shapes(Path::new(path)), "{said}");
    }
    assert!(has_shapes(Path::new("Face.GLB")) && has_shapes(Path::new("avatar.vrm")));
}

#[test]
fn shape_keys_of_blender_are_the_poses_they_were_made_from() {
    let Some(data) = shared("data") else { return };
    let Shapes { neutral, shapes, .. } =
        read_shapes(&data.join("other-people/meshes/blender_shapekeys.glb")).unwrap();
    let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        assert_eq!(a.len(), b.len());
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let face = read(&data.join("face/neutral.obj")).unwrap();
    assert!(apart(&neutral.positions, &face.positions) < 1e-5);
    let names: Vec<&str> = shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["rom3_1460", "rom3_2020"]);
    for shape in &shapes {
        let pose = read(&data.join(format!("face/poses/{}.obj", shape.name))).unwrap();
        assert!(apart(&shape.on(&neutral.positions), &pose.positions) < 1e-5, "{}", shape.name);
        assert!(apart(&neutral.positions, &pose.positions) > 0.1);
    }
}
