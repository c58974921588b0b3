//! The names of morph targets, and shapes that a glTF file shows at rest.

use super::support::{Document, decode_with_warnings};
use rhytid_formats::mesh::{Format, Shapes, read, read_shapes};
use rhytid_test_support::{Logged, shared};
use serde_json::json;

/// Two primitives, the second with one target fewer. The second target of the first has normals alone.
fn document() -> Document {
    let mut document = Document::default();
    let position = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let lower = document.floats("VEC3", &[0., -5., 0., 1., -5., 0., 0., -4., 0.]);
    let by = document.floats("VEC3", &[0., 0., 0., 0., 0., 0.5, 0., 0., 0.]);
    // Normalised 8-bit integers, each element in four bytes.
    let small = document.accessor("VEC3", 5120, 3, vec![127, 0, 0, 9, 0, 0x81, 0, 9, 0, 0, 0, 9]);
    document.accessors[small]["normalized"] = true.into();
    let view = document.accessors[small]["bufferView"].as_u64().unwrap() as usize;
    document.views[view]["byteStride"] = 4.into();
    document.json = json!({
        "asset": {"version": "2.0"},
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2]}],
        "meshes": [
            {"primitives": [
                {"attributes": {"POSITION": position}, "targets": [{"POSITION": by}, {"NORMAL": by}, {"POSITION": small}]},
                {"attributes": {"POSITION": lower}, "targets": [{"POSITION": small}, {"POSITION": by}]},
            ]},
            {"primitives": [{"attributes": {"POSITION": position}}], "weights": [1]},
        ],
    });
    document
}

fn shapes(document: &Document) -> Shapes {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.vrm");
    std::fs::write(&path, document.text()).unwrap();
    read_shapes(&path).unwrap()
}

#[test]
fn each_primitive_moves_by_the_targets_that_it_has() {
    let mut document = document();
    document.json["meshes"][0]["extras"] = json!({"targetNames": ["smile", "blink"]});
    let found = shapes(&document).shapes;
    let names: Vec<&str> = found.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["smile", "blink", "shape 3"]);
    assert_eq!(found[0].moved, [(1, [0.0, 0.0, 1.0]), (3, [2.0, 0.0, 0.0]), (4, [0.0, -2.0, 0.0])]);
    assert_eq!(found[1].moved, [(4, [0.0, 0.0, 1.0])]);
    assert_eq!(found[2].moved, [(0, [2.0, 0.0, 0.0]), (1, [0.0, -2.0, 0.0])]);

    // UniVRM has the names at the primitives.
    document.json["meshes"][0].as_object_mut().unwrap().remove("extras");
    document.json["meshes"][0]["primitives"][0]["extras"] = json!({"targetNames": ["A", "I", "U"]});
    let names: Vec<String> = shapes(&document).shapes.into_iter().map(|shape| shape.name).collect();
    assert_eq!(names, ["A", "I", "U"]);
}

#[test]
fn primitives_that_share_positions_and_not_targets_have_their_own_vertices() {
    let mut document = document();
    document.json["meshes"][0]["primitives"][1]["attributes"]["POSITION"] = 0.into();
    let found = shapes(&document);
    assert_eq!(found.neutral.positions.len(), 6);
    assert_eq!(found.shapes[0].moved, [(1, [0.0, 0.0, 1.0]), (3, [2.0, 0.0, 0.0]), (4, [0.0, -2.0, 0.0])]);
}

#[test]
fn a_shape_that_is_shown_at_rest_is_a_warning() {
    let mut document = document();
    let warnings = |document: &Document| {
        let text = document.text();
        let (mesh, warnings) = decode_with_warnings(text.as_bytes(), Format::Gltf, "face.glb");
        assert_eq!(mesh.positions[1], [2.0, 0.0, 0.0]);
        warnings
    };
    // A mesh outside of the scene has weights too.
    assert!(warnings(&document).is_empty());
    document.json["meshes"][0]["weights"] = json!([0, 0.25, -1]);
    document.json["meshes"][0]["extras"] = json!({"targetNames": ["smile", "blink"]});
    let expected = "face.glb: shows its mesh with the shapes \"blink\" (weight 0.25), \"shape 3\" (weight -1), and the \
                    mesh is read without them; export it with all weights at 0, or apply the shapes to the mesh before \
                    the export if it is to have them";
    assert_eq!(warnings(&document), [expected]);
    let logged = Logged::start();
    assert_eq!(shapes(&document).neutral.positions[1], [2.0, 0.0, 0.0]);
    let lines = logged.lines();
    assert!(lines.iter().any(|line| line.contains("\"shape 3\" (weight -1)")), "{lines:?}");
    // The weights of the node win.
    document.json["nodes"][0]["weights"] = json!([0, 0, 0]);
    assert!(warnings(&document).is_empty());
    document.json["nodes"][0]["weights"] = json!([0.5]);
    assert!(warnings(&document)[0].contains("the shapes \"smile\" (weight 0.5), and"));
    // Only the first few are named.
    document.json["meshes"][0]["primitives"][0]["targets"] = vec![json!({"POSITION": 2}); 9].into();
    document.json["nodes"][0]["weights"] = json!(vec![1; 9]);
    let said = &warnings(&document)[0];
    assert!(said.contains("\"shape 4\" (weight 1) and 5 more, and"), "{said}");
}

#[test]
fn a_head_with_a_default_weight_is_read_without_its_shape() {
    let Some(data) = shared("data/other-people/meshes") else { return };
    for (file, expected) in [
        ("morph_default_weight_1.glb", "the shapes \"rom3_1460\" (weight 1), and"),
        ("blender_shapekeys.glb", "the shapes \"rom3_1460\" (weight 1), \"rom3_2020\" (weight 1), and"),
    ] {
        let logged = Logged::start();
        let mesh = read(&data.join(file)).unwrap();
        let lines = logged.lines();
        assert!(lines.iter().any(|line| line.contains(expected)), "{lines:?}");
        assert_eq!(mesh.positions.len(), 9409);
    }
}
