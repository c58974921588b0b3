//! Triangles, texture coordinates, units and names.

use super::cases::{Case, animation, cases};
use super::tools::unfold;
use super::viewer::Viewer;
use crate::animation::{Animation, UvKind};
use rhytid_core::{Materials, UpAxis};
use rhytid_formats::export::Options;
use serde_json::json;
use std::collections::HashSet;
use std::path::PathBuf;

#[test]
fn triangles_keep_their_vertices_and_texture_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases();
    let files: Vec<PathBuf> = cases.iter().map(|case| case.export(folder.path()).0).collect();
    for (case, file) in cases.iter().zip(unfold(&files)) {
        let Case { animation, options, label, .. } = case;
        let viewer = Viewer::open(&file);
        let triangles = case.corners();
        let corners = triangles.as_flattened();
        let vertices = animation.rest.len();
        assert_eq!(viewer.indices.len(), corners.len(), "{label}");
        assert_eq!(viewer.uvs.is_some(), animation.uvs.is_some(), "{label}");
        // The originals first, each under its own number.
        assert!(viewer.ids.iter().take(vertices).enumerate().all(|(v, &id)| id == v as f64), "{label}");

        let mut distinct = HashSet::new();
        for (&index, &corner) in viewer.indices.iter().zip(corners) {
            let corner = corner as usize;
            let vertex = animation.faces.indices[corner] as usize;
            assert_eq!(viewer.ids[index], vertex as f64, "{label}");
            // A copy moves with its vertex.
            assert_eq!(viewer.positions[index], viewer.positions[vertex], "{label}");
            for (positions, normals) in &viewer.targets {
                assert_eq!(positions[index], positions[vertex], "{label}");
                assert!(normals.as_ref().is_none_or(|normals| normals[index] == normals[vertex]), "{label}");
            }
            let Some(uvs) = &animation.uvs else {
                assert_eq!(index, vertex, "{label}");
                continue;
            };
            let number = uvs.corners.as_ref().map_or(vertex, |corners| corners[corner] as usize);
            let [u, v] = uvs.values[number];
            let shown = viewer.uvs.as_ref().unwrap()[index];
            let integers = options.quantize && !label.contains("Tiled");
            let bound = if integers { 0.5 / 65535.0 + 1e-7 } else { 0.0 };
            for (shown, given) in shown.iter().zip([u, 1.0 - v]) {
                assert!((shown - f64::from(given)).abs() <= bound, "{label}: {shown}, expected {given}");
            }
            distinct.insert((vertex, u.to_bits(), v.to_bits()));
        }
        // No copy more than the texture coordinates ask for; 33 vertices have faces and one has none.
        let expected = if animation.uvs.is_some() { distinct.len() + 1 } else { 34 };
        assert_eq!(viewer.positions.len(), expected, "{label}");
        let copies = label.contains("PerCorner") && !label.contains("1 frames");
        assert!(!copies || viewer.positions.len() > 60, "{label}: too few copies to show much");
    }
}

#[test]
fn each_material_has_its_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases();
    let files: Vec<PathBuf> = cases.iter().map(|case| case.export(folder.path()).0).collect();
    let mut apart = 0;
    for (case, file) in cases.iter().zip(unfold(&files)) {
        let Case { animation, options, label, .. } = case;
        let viewer = Viewer::open(&file);
        let document = &viewer.document;
        let primitives = document.meshes().next().unwrap().primitives().len();
        assert_eq!(document.materials().len(), primitives, "{label}");
        let Some(materials) = animation.materials.as_ref().filter(|_| !options.one_material) else {
            assert_eq!((primitives, viewer.materials[0].as_str()), (1, "skin"), "{label}");
            continue;
        };
        assert_eq!(primitives, 4, "{label}");
        for (found, corners) in viewer.materials.iter().zip(case.corners()) {
            let material = materials.of_face[case.face_of(corners[0])];
            let expected = materials.names().nth(material as usize).unwrap_or("skin");
            assert_eq!(found, expected, "{label}");
        }
        apart += 1;
    }
    assert!(apart > 40, "{apart}");
}

#[test]
fn numbers_of_vertices_are_an_attribute_if_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    for case in cases() {
        let (path, _) = case.export(folder.path());
        let has = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).contains("\"_VERTEX_ID\"");
        assert_eq!(has, case.options.vertex_ids, "{}", case.label);
    }
}

#[test]
fn it_opens_upright_and_at_true_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let base = animation(UvKind::None, 2, 26);
    let name = "1st scan \"Zoë\"\n\\ 100 %";
    let z_up = Animation { up_axis: UpAxis::Z, name: name.into(), ..base.clone() };
    z_up.export_with(&path, &Options::default()).unwrap();
    let viewer = Viewer::open(&path);
    let node = viewer.document.default_scene().unwrap().nodes().next().unwrap();
    assert_eq!(node.name(), Some(name));
    assert_eq!(node.mesh().unwrap().name(), Some(name));
    // The mesh's up (z) becomes glTF's (y), in metres, and its x stays.
    for (axis, expected) in [(0, [0.01, 0.0, 0.0]), (2, [0.0, 0.01, 0.0])] {
        for (found, expected) in viewer.node[axis].iter().zip(expected) {
            assert!((found - expected).abs() < 2e-9, "{:?}", viewer.node);
        }
    }

    Animation { metres_per_unit: 1.0, ..base }.export_with(&path, &Options::default()).unwrap();
    let identity = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    assert_eq!(Viewer::open(&path).node, identity);
}

#[test]
fn names_and_extras_say_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let mut animation = animation(UvKind::None, 2, 27);
    animation.first_time_code = 9.0;
    animation.metres_per_unit = 0.001;
    let faces = animation.faces.len();
    animation.materials = Some(Materials::named(["epidermis"], vec![0; faces]));
    animation.export_with(&path, &Options::default()).unwrap();
    let viewer = Viewer::open(&path);
    let mesh = viewer.document.meshes().next().unwrap();
    let names: serde_json::Value = serde_json::from_str(mesh.extras().as_ref().unwrap().get()).unwrap();
    assert_eq!(names, json!({ "targetNames": ["frame 0009", "frame 0010"] }));
    assert_eq!(viewer.document.materials().next().unwrap().name(), Some("epidermis"));
    let mut extras = viewer.scene_extras();
    assert!(extras["error"]["worstMillimetres"].as_f64().unwrap() < 1e-5);
    extras.as_object_mut().unwrap().remove("error");
    assert_eq!(viewer.document.animations().next().unwrap().name(), Some("face"));
    let expected = json!({
        "vertices": 34, "frames": 2, "framesPerSecond": 30.0, "firstTimeCode": 9.0, "metresPerUnit": 0.001, "upAxis": "Y",
        "rhytid": serde_json::to_value(&animation.recipe).unwrap(),
    });
    assert_eq!(extras, expected);

    let options = Options { clips: vec!["take 7 – \"Wut\"".into()], ..Options::default() };
    animation.export_with(&path, &options).unwrap();
    let document = Viewer::open(&path).document;
    assert_eq!(document.animations().next().unwrap().name(), Some("take 7 – \"Wut\""));
    assert_eq!(document.meshes().next().unwrap().name(), Some("face"));
}
