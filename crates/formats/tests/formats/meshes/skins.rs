//! Skinned meshes: the files of other programs against what Blender makes of the same mesh, and small ones
//! against what a hand works out.

use super::support::{Document, message, polygons};
use rhytid_core::Mesh;
use rhytid_formats::mesh::{Format, Shapes, decode, read_shapes};
use rhytid_test_support::Logged;
use serde_json::json;
use std::path::Path;

/// A vertex as Blender shows it.
struct Expected {
    position: [f64; 3],
    uv: [f64; 2],
    smile: [f64; 3],
    frown: [f64; 3],
}

fn expected() -> Vec<Expected> {
    let numbers = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>();
    let lines = include_str!("data/skin/skin.csv").lines().skip(1).map(numbers);
    let part = |line: &[f64], start: usize| [line[start], line[start + 1], line[start + 2]];
    lines
        .map(|line| Expected {
            position: part(&line, 0),
            uv: [line[3], line[4]],
            smile: part(&line, 5),
            frown: part(&line, 8),
        })
        .collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The file of the folder of skins, without a warning.
fn load(file: &str) -> Shapes {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/meshes/data/skin").join(file);
    let logged = Logged::start();
    let found = read_shapes(&path).unwrap();
    let warnings: Vec<String> = logged.lines().into_iter().filter(|line| line.starts_with("WARN")).collect();
    assert!(warnings.is_empty(), "{file}: {warnings:?}");
    found
}

#[test]
fn what_other_programs_made_of_a_skinned_mesh_stands_where_blender_shows_it() {
    let expected = expected();
    // Coordinates are up to 2.3. The bounds are what each program says of its precision.
    for (file, within, shapes) in [
        ("blender.glb", 1e-6, true),
        ("gltfpack.glb", 2e-4, true),
        ("gltfpack-c.glb", 2e-4, true),
        ("gltfpack-khr.glb", 2e-4, true),
        ("gltfpack-vpf.glb", 2e-4, true),
        ("quantize.glb", 2e-4, true),
        ("draco.glb", 2e-4, true),
        ("draco-edgebreaker.glb", 2e-4, false),
    ] {
        let found = load(file);
        let mesh = &found.neutral;
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (25, 32), "{file}");
        let names: Vec<&str> = found.shapes.iter().map(|shape| shape.name.as_str()).collect();
        assert_eq!(names, if shapes { vec!["smile", "frown"] } else { vec![] }, "{file}");
        let shapes: Vec<Vec<[f64; 3]>> = found.shapes.iter().map(|shape| shape.on(&mesh.positions)).collect();
        let uvs = mesh.uvs.as_ref().unwrap();
        assert_eq!(uvs.corners, None, "{file}");
        // The programs have their own order of the vertices.
        let mut is_found = vec![false; expected.len()];
        for (v, position) in mesh.positions.iter().enumerate() {
            let nearest = expected
                .iter()
                .map(|vertex| apart(&vertex.position, position))
                .enumerate()
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap();
            let vertex = &expected[nearest.0];
            assert!(
                !std::mem::replace(&mut is_found[nearest.0], true),
                "{file}: {position:?} is there twice"
            );
            assert!(nearest.1 < within, "{file}: {position:?} {:?}", vertex.position);
            assert!(apart(&uvs.values[v].map(f64::from), &vertex.uv) < 1e-3, "{file}: {:?}", uvs.values[v]);
            for (shape, truth) in shapes.iter().zip([vertex.smile, vertex.frown]) {
                assert!(apart(&shape[v], &truth) < 2.0 * within, "{file}: {:?} {truth:?}", shape[v]);
            }
        }
        // The areas of Blender's triangles as vectors along their normals, all together.
        let area = area(mesh);
        assert!(apart(&area, &[0.957_642, -1.657_086, 2.648_850]) < 2e-3, "{file}: {area:?}");
    }
}

/// Half the cross products of the triangles' edges, all together.
fn area(mesh: &Mesh) -> [f64; 3] {
    let mut area = [0.0; 3];
    for face in mesh.faces.iter() {
        let [a, b, c] = std::array::from_fn(|i| mesh.positions[face[i] as usize]);
        let u: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let w: [f64; 3] = std::array::from_fn(|i| c[i] - a[i]);
        for (i, area) in area.iter_mut().enumerate() {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            *area += (u[j] * w[k] - u[k] * w[j]) / 2.0;
        }
    }
    area
}

/// A triangle that follows two joints. Its vertices follow the first, both by half, and the second. One
/// target moves all of them by (0, 0, 1).
fn triangle() -> Document {
    let mut document = Document::default();
    let position = document.floats("VEC3", &[1., 0., 0., 2., 0., 0., 0., 4., 0.]);
    let joints = document.accessor("VEC4", 5121, 3, vec![0, 0, 0, 0, 0, 1, 9, 9, 1, 9, 9, 9]);
    let weights = document.floats("VEC4", &[1., 0., 0., 0., 0.5, 0.5, 0., 0., 1., 0., 0., 0.]);
    let by = document.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    // Columns: the first joint's is a scale of 2, the second moves by (0, -10, 0).
    let binds = document.floats(
        "MAT4",
        &[
            2., 0., 0., 0., 0., 2., 0., 0., 0., 0., 2., 0., 0., 0., 0., 1., 1., 0., 0., 0., 0., 1., 0., 0.,
            0., 0., 1., 0., 0., -10., 0., 1.,
        ],
    );
    document.json = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"mesh": 0, "skin": 0, "translation": [700, 0, 0], "scale": [9, 9, 9]},
            {"translation": [0, 0, 3], "children": [2]},
            {"scale": [1, 1, 5], "translation": [0, 8, 0]},
        ],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": position, "JOINTS_0": joints, "WEIGHTS_0": weights},
            "targets": [{"POSITION": by}],
        }]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": binds}],
    });
    document
}

fn decoded(document: &Document) -> Mesh {
    decode(document.text().as_bytes(), Format::Gltf, "face").unwrap()
}

fn refused(document: &Document) -> String {
    message(decode(document.text().as_bytes(), Format::Gltf, "face").map(|_| ()))
}

#[test]
fn joints_place_vertices_and_turn_displacements() {
    // The first joint: p -> 2 p + (0, 0, 3). The second: x, y - 10 + 8, 5 z + 3.
    let expected = [[2.0, 0.0, 3.0], [3.0, -1.0, 3.0], [0.0, 2.0, 3.0]];
    let mut document = triangle();
    let mesh = decoded(&document);
    assert_eq!(mesh.positions, expected);
    assert_eq!(polygons(&mesh), [vec![0, 1, 2]]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.vrm");
    std::fs::write(&path, document.text()).unwrap();
    let shape = &read_shapes(&path).unwrap().shapes[0];
    assert_eq!(shape.moved, [(0, [0.0, 0.0, 2.0]), (1, [0.0, 0.0, 3.5]), (2, [0.0, 0.0, 5.0])]);

    // Joints outside of the scene.
    document.json["scenes"][0]["nodes"] = json!([0]);
    assert_eq!(decoded(&document).positions, expected);
    // Weights that do not add up to 1, as integers do not quite.
    let mut third = triangle();
    let weights = vec![200, 0, 0, 0, 100, 100, 0, 0, 7, 0, 0, 0];
    let weights = third.accessor("VEC4", 5121, 3, weights);
    third.accessors[weights]["normalized"] = true.into();
    third.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights.into();
    for (found, expected) in decoded(&third).positions.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-12);
    }
    // Without inverse binds, the joints alone: p + (0, 0, 3), and (x, y + 8, 5 z + 3).
    document.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    assert_eq!(decoded(&document).positions, [[1.0, 0.0, 3.0], [2.0, 4.0, 3.0], [0.0, 12.0, 3.0]]);
    // A joint that mirrors turns its triangles round.
    document.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let mesh = decoded(&document);
    assert_eq!(mesh.positions[0], [-1.0, 0.0, 3.0]);
    assert_eq!(polygons(&mesh), [vec![0, 2, 1]]);
}

#[test]
fn a_second_set_of_joints_counts_like_the_first() {
    let mut document = triangle();
    let joints = document.accessor("VEC4", 5123, 3, [0, 1, 0, 0, 0, 0, 0, 0].repeat(3));
    let weights = document.floats("VEC4", &[1., 0., 0., 0.].repeat(3));
    let attributes = &mut document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = joints.into();
    attributes["WEIGHTS_1"] = weights.into();
    // 256 is no joint.
    assert!(refused(&document).contains("has the joint 256 at vertex 0, expected 0 to 1"));
    let joints = document.accessor("VEC4", 5123, 3, [1, 0, 0, 0, 0, 0, 0, 0].repeat(3));
    document.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = joints.into();
    // Vertex 0: half of (2, 0, 3) and of (1, -2, 3). Vertex 1: a quarter of (4, 0, 3), the rest (2, -2, 3).
    let expected = [[1.5, -1.0, 3.0], [2.5, -1.5, 3.0], [0.0, 2.0, 3.0]];
    assert_eq!(decoded(&document).positions, expected);
}

#[test]
fn wrong_skins_are_one_sentence() {
    for (pointer, value, expected) in [
        ("/nodes/0/skin", json!(4), "skin 4 does not exist"),
        ("/skins/0/joints/1", json!(9), "skin 0 has the joint 9, expected a node in a tree"),
        ("/skins/0/joints", json!([1, 2, 1]), "has 2 inverse bind matrices for 3 joints"),
        ("/skins/0/joints", json!([1]), "has the joint 1 at vertex 1, expected 0 to 0"),
        ("/skins/0/inverseBindMatrices", json!(0), "accessor 0 does not have 16 components"),
        ("/nodes/1/children", json!([]), ""),
        (
            "/meshes/0/primitives/0/attributes",
            json!({"POSITION": 0}),
            "has a skin but neither JOINTS_0 nor WEIGHTS_0, expected both",
        ),
        (
            "/meshes/0/primitives/0/attributes",
            json!({"POSITION": 0, "JOINTS_0": 1}),
            "has only one of JOINTS_0 and WEIGHTS_0",
        ),
        ("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(0), "accessor 0 does not have 4 components"),
    ] {
        let mut document = triangle();
        *document.json.pointer_mut(pointer).unwrap() = value.clone();
        match expected {
            // A joint that hangs elsewhere is no mistake.
            "" => assert_eq!(decoded(&document).positions[2], [0.0, 2.0, 0.0]),
            _ => assert!(refused(&document).contains(expected), "{pointer}: {}", refused(&document)),
        }
    }
    let mut document = triangle();
    document.json["nodes"][2]["children"] = json!([2]);
    assert!(refused(&document).contains("node 2 is placed twice"));
    let mut document = triangle();
    for (weights, expected) in [
        ([0.0; 4], "has no joint with a weight at vertex 0"),
        ([-1.0, 1.0, 0.0, 0.0], "has the weight -1 at vertex 0, expected 0 or more"),
        ([f32::NAN, 1.0, 0.0, 0.0], "has the weight NaN at vertex 0"),
    ] {
        let weights = document.floats("VEC4", &weights.repeat(3));
        document.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights.into();
        assert!(refused(&document).contains(expected), "{}", refused(&document));
    }
    let mut document = triangle();
    let (joints, weights) = (json!(1), json!(2));
    let attributes = &mut document.json["meshes"][0]["primitives"][0]["attributes"];
    for number in 1..5 {
        attributes[format!("JOINTS_{number}")] = joints.clone();
        attributes[format!("WEIGHTS_{number}")] = weights.clone();
    }
    assert!(refused(&document).contains("has more than 16 joints for each vertex"), "{}", refused(&document));
}
