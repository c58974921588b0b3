//! A rig that is written is read back, here and by any reader of safetensors.

use super::{BYTES, RIG, inside_a_triangle, parse};
use rhytid_core::{Error, NoProgress, StrainEdgeId, Uvs, rig_file};
use rhytid_solve::solve;
use rhytid_test_support::changed;
use serde_json::{Value, json};

#[test]
fn what_is_written_is_read() {
    let mut face = rhytid_test_support::sheet::face();
    let corners = RIG.clone();
    let plain = changed(&RIG, |r| (r.surface.uvs, r.surface.materials) = (None, None)).unwrap();
    let uvs = Uvs { values: vec![[0.25, 1.0]; 25], corners: None };
    let per_vertex = changed(&RIG, |r| r.surface.uvs = Some(uvs)).unwrap();
    let infinite = changed(&RIG, |r| r.influences.beta = f64::INFINITY).unwrap();
    face.examples.clear();
    let large_scale_only = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    assert_eq!(large_scale_only.centers(), 1);
    face.handles.labels.truncate(1);
    face.handles.points.truncate(1);
    let one_handle = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    assert_eq!((one_handle.handles().strain_edges.len(), one_handle.influences().per_vertex()), (0, 0));
    let odd_names = changed(&RIG, |r| {
        r.surface.name = "Ü \"quoted\"\n\\".into();
        r.handles.labels = ["", "a b", "é", "{}", "\u{0}"].map(String::from).to_vec();
        r.surface.metres_per_unit = 0.1 + 0.2;
        r.influences.beta = f64::MIN_POSITIVE;
        r.surface.up_axis = rhytid_core::UpAxis::Z;
    })
    .unwrap();
    let inside = inside_a_triangle();
    for rig in [corners, plain, per_vertex, infinite, large_scale_only, one_handle, odd_names, inside] {
        let bytes = rig_file::encode(&rig).unwrap();
        assert_eq!(rig_file::decode(&bytes, "x").unwrap(), rig);
    }
}

#[test]
fn the_same_rig_gives_the_same_bytes() {
    for _ in 0..8 {
        assert_eq!(rig_file::encode(&RIG).unwrap(), *BYTES);
    }
    let again = rig_file::decode(&BYTES, "x").unwrap();
    assert_eq!(rig_file::encode(&again).unwrap(), *BYTES);
}

#[test]
fn files_are_written_whole_and_named_in_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.safetensors");
    rig_file::write(&path, &RIG).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), *BYTES);
    assert_eq!(rig_file::read(&path).unwrap(), *RIG);

    // A rig that could not be read back is refused.
    let broken = changed(&RIG, |r| r.surface.rest[3][1] = f32::INFINITY);
    assert!(matches!(broken, Err(Error::Input(m)) if m.sentence().contains("rest[10]")));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    std::fs::write(&path, &BYTES[..99]).unwrap();
    let name = path.display().to_string();
    assert!(matches!(rig_file::read(&path), Err(Error::Input(m)) if m.sentence().starts_with(&name)));
    let absent = folder.path().join("absent.safetensors");
    assert!(matches!(rig_file::read(&absent), Err(Error::Io { path, .. }) if path == absent));
}

#[test]
fn any_reader_of_safetensors_finds_the_arrays() {
    let (header, arrays) = parse(&BYTES);
    let (v, h, f, n, k) = (25, 5, RIG.handles().strain_edges.len(), 2, RIG.influences().per_vertex());
    assert!(f > 0 && k > 0);
    let expected = [
        ("face_counts", "U32", json!([16])),
        ("face_indices", "U32", json!([64])),
        ("uvs", "F32", json!([9, 2])),
        ("uv_indices", "U32", json!([64])),
        ("triangles", "U32", json!([32, 3])),
        ("rest", "F32", json!([v, 3])),
        ("handles", "U32", json!([h])),
        ("basis", "F32", json!([v, h])),
        ("strain_edges", "U32", json!([f, 2])),
        ("influence_edges", "U32", json!([v, k])),
        ("influence_weights", "F32", json!([v, k])),
        ("frame_neighbors", "U32", json!([v])),
        ("pose_features", "F32", json!([n, f])),
        ("rbf_weights", "F32", json!([v, n, 3])),
        ("example_handles", "F32", json!([1, h, 3])),
        ("face_materials", "U32", json!([16])),
        ("anchors", "U32", json!([v, 8])),
        ("anchor_weights", "F32", json!([v, 8])),
        ("feature_gains", "F32", json!([v, k + 8])),
        ("example_weights", "F32", json!([v, 1, 3])),
        ("variances", "F32", json!([v])),
    ];
    assert_eq!(header.as_object().unwrap().len(), expected.len() + 1, "{header}");
    for (name, dtype, shape) in &expected {
        assert_eq!((&header[name]["dtype"], &header[name]["shape"]), (&json!(dtype), shape), "{name}");
    }
    let array = |name: &str| {
        let offset = |i: usize| header[name]["data_offsets"][i].as_u64().unwrap() as usize;
        arrays[offset(0)..offset(1)].as_chunks::<4>().0
    };
    let floats = |name: &str| -> Vec<f32> { array(name).iter().map(|b| f32::from_le_bytes(*b)).collect() };
    let numbers = |name: &str| -> Vec<u32> { array(name).iter().map(|b| u32::from_le_bytes(*b)).collect() };
    assert_eq!(floats("basis"), RIG.basis().as_slice());
    assert_eq!(floats("rest"), RIG.surface().rest.as_flattened());
    assert_eq!(floats("rbf_weights"), RIG.fine_scale().rbf_weights.as_slice().as_flattened());
    assert_eq!(floats("uvs"), RIG.surface().uvs.as_ref().unwrap().values.as_flattened());
    assert_eq!(numbers("triangles"), RIG.surface().triangles.as_flattened());
    let edges = RIG.influences().edges.as_slice();
    assert_eq!(numbers("influence_edges"), StrainEdgeId::numbers(edges));
    assert_eq!(numbers("face_indices"), RIG.surface().faces.indices);
    assert_eq!(numbers("face_materials"), RIG.surface().materials.as_ref().unwrap().of_face);
    // The handles at the example's positions.
    let face = rhytid_test_support::sheet::face();
    let of_example = face.handles.at(&face.examples[0].positions).into_iter();
    let of_example: Vec<f32> = of_example.flatten().map(|x| x as f32).collect();
    assert_eq!(floats("example_handles"), of_example);

    let metadata: Value = serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
    let expected = json!({
        "version": 5, "name": "sheet", "metres_per_unit": 0.01, "up_axis": "y", "method": "learned",
        "bending_length": RIG.bending_length(), "beta": RIG.influences().beta,
        "labels": ["a", "b", "c", "d", "e"], "examples": ["smile"], "materials": ["skin", "lips"],
        "learned": {"share": 0.2, "ridge": 0.01, "wrinkle_ridge": 0.001, "marker_noise": 0.005, "reach": 1.0,
            "wrinkle_strains": "vectors"},
    });
    assert_eq!(metadata, expected);
}
