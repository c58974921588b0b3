//! A file that is damaged in one place is refused, in a sentence that names the place.

use super::{BYTES, RIG, assemble, parse, refused, with_element, with_header, with_metadata};
use rhytid_core::{InputErrorKind, VertexId, rig_file};
use rhytid_test_support::{changed, triangle};
use serde_json::{Value, json};

#[test]
fn joined_vertices_that_are_no_points_are_refused() {
    let joined = |joined: [u32; 3]| {
        changed(&triangle(), |parts| {
            parts.surface.rest[2] = parts.surface.rest[1];
            parts.surface.joined = Some(joined.map(VertexId).to_vec());
        })
    };
    let rig = joined([0, 1, 1]).unwrap();
    let bytes = rig_file::encode(&rig).unwrap();
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    for (wrong, words) in [
        ([0, 1, 3], "joined_vertices[2] is 3, expected an index below 3"),
        ([0, 2, 2], "joined_vertices[1] is 2, which is not the first of its point"),
        ([0, 0, 1], "joined_vertices[2] is 1, which is not the first of its point"),
        ([0, 1, 0], "joined_vertices[2] is 0, which is elsewhere at rest"),
    ] {
        let error = joined(wrong).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn files_cut_short_anywhere() {
    for length in 0..BYTES.len() {
        assert_eq!(refused(&BYTES[..length], &["cut short"]), InputErrorKind::CutShort);
    }
    refused(&[&BYTES[..], &[0]].concat(), &["no whole safetensors file"]);
}

#[test]
fn other_versions_and_other_files() {
    // Earlier versions that are no longer written, and later ones.
    for version in [0, 1, 3, 4, 13, u32::MAX] {
        let bytes = with_metadata(|m| m["version"] = version.into());
        let kind = refused(
            &bytes,
            &[&format!("version {version}, expected 2, 5, 6, 7, 8, 9, 10, 11 or 12"), "solve the face again"],
        );
        assert_eq!(kind, InputErrorKind::UnsupportedVersion);
    }
    // Such a file may have entirely different metadata, and arrays that are unknown here.
    let newer = with_metadata(|m| *m = json!({"version": 13}));
    refused(&newer, &["version 13, expected 2, 5, 6, 7, 8, 9, 10, 11 or 12"]);
    refused(
        &with_header(|h| drop(h.as_object_mut().unwrap().remove("__metadata__"))),
        &["no rig", "`rhytid`"],
    );
    refused(&with_header(|h| h["__metadata__"] = json!({"format": "pt"})), &["no rig", "`rhytid`"]);
    refused(&with_header(|h| h["__metadata__"]["rhytid"] = "{".into()), &["metadata cannot be read"]);
    refused(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["no whole safetensors file"]);
}

#[test]
fn metadata_out_of_range() {
    let damaged = |change: &dyn Fn(&mut Value), words: &[&str]| refused(&with_metadata(change), words);
    for key in ["name", "metres_per_unit", "up_axis", "bending_length", "labels", "examples", "learned"] {
        damaged(&|m| drop(m.as_object_mut().unwrap().remove(key)), &["metadata", key]);
    }
    damaged(&|m| m["up_axis"] = "x".into(), &["metadata", "`x`"]);
    damaged(&|m| m["bending_length"] = Value::Null, &["metadata", "null"]);
    damaged(&|m| m["bending_length"] = (-1.0).into(), &["bending_length is -1, expected"]);
    damaged(&|m| m["metres_per_unit"] = 0.0.into(), &["metres_per_unit is 0, expected"]);
    damaged(&|m| m["beta"] = (-0.5).into(), &["beta is -0.5, expected"]);
    damaged(&|m| m["labels"] = json!(["a", "b", "c", "d"]), &["labels has 4 elements, expected 5"]);
    damaged(&|m| m["labels"] = json!(["a", "b", "c", "b", "e"]), &["labels has b twice"]);
    damaged(&|m| m["materials"] = json!(["skin"]), &["face 2 refers to material 1, expected one of its 1"]);
    damaged(&|m| m["materials"] = json!(["skin", "skin"]), &["two materials called “skin”"]);
    damaged(&|m| m["examples"] = json!(["smile", "frown"]), &["`example_weights`", "expected F32 [25, 2, "]);
    damaged(&|m| m["learned"]["share"] = 1.5.into(), &["share is 1.5, which is out of its range"]);
    damaged(&|m| m["learned"]["ridge"] = 0.0.into(), &["ridge is 0, which"]);
    damaged(&|m| m["learned"]["marker_noise"] = (-1.0).into(), &["marker_noise is -1, which"]);
    damaged(&|m| m["learned"]["reach"] = 0.5.into(), &["reach is 0.5, which"]);
    damaged(&|m| m["learned"]["wrinkle_strains"] = "world".into(), &["metadata", "`world`"]);
    damaged(
        &|m| drop(m["learned"].as_object_mut().unwrap().remove("wrinkle_ridge")),
        &["metadata", "wrinkle_ridge"],
    );
    // A number that no float64 holds.
    let bytes = with_header(|h| {
        let text = &mut h["__metadata__"]["rhytid"];
        let changed = text.as_str().unwrap().replace("\"metres_per_unit\":0.01", "\"metres_per_unit\":1e999");
        assert!(changed.contains("1e999"));
        *text = changed.into();
    });
    refused(&bytes, &["metadata", "out of range"]);
}

#[test]
fn arrays_that_are_missing_or_of_another_kind() {
    let (header, _) = parse(&BYTES);
    let arrays: Vec<&String> = header.as_object().unwrap().keys().filter(|k| *k != "__metadata__").collect();
    assert_eq!(arrays.len(), 21);
    for name in arrays {
        // Texture coordinates may be missing, but not apart from their indices.
        if name != "uv_indices" {
            let bytes = with_header(|h| {
                let array = h.as_object_mut().unwrap().remove(name).unwrap();
                h["something_else"] = array;
            });
            refused(&bytes, &[&format!("`{name}`")]);
        }
        for dtype in ["I32", "F32", "U32"] {
            if header[name]["dtype"] != dtype {
                let bytes = with_header(|h| h[name]["dtype"] = dtype.into());
                refused(&bytes, &[&format!("array `{name}` is {dtype}"), "expected"]);
            }
        }
        let bytes = with_header(|h| h[name]["shape"].as_array_mut().unwrap().insert(0, 1.into()));
        refused(&bytes, &[&format!("array `{name}` is"), "[1, ", "expected"]);
    }
    let bytes = with_header(|h| h["basis"]["shape"].as_array_mut().unwrap().reverse());
    refused(&bytes, &["array `basis` is F32 [5, 25], expected F32 [25, 5]"]);
    let bytes = with_header(|h| h["rbf_weights"]["shape"] = json!([25, 3, 2]));
    refused(&bytes, &["array `rbf_weights` is F32 [25, 3, 2], expected F32 [25, 2, 3]"]);
    let bytes = with_header(|h| h["triangles"]["shape"] = json!([48, 2]));
    refused(&bytes, &["array `triangles` is U32 [48, 2], expected U32 [any, 3]"]);
}

#[test]
fn indices_past_the_end() {
    let f = RIG.handles().strain_edges.len() as u32;
    for (array, end) in [
        ("handles", 25),
        ("triangles", 25),
        ("face_indices", 25),
        ("frame_neighbors", 25),
        ("strain_edges", 5),
        ("influence_edges", f),
        ("anchors", 5),
        ("uv_indices", 9),
    ] {
        for index in [end, u32::MAX] {
            let words = [format!("{array}[2] is {index}, expected an index below {end}"), "damaged".into()];
            refused(&with_element(array, 2, index.to_le_bytes()), &words.each_ref().map(String::as_str));
        }
    }
    refused(&with_element("handles", 2, 4u32.to_le_bytes()), &["handles has vertex 4 twice"]);
    let first = RIG.influences().edges.row(0)[0].0;
    let words = format!("influence_edges of vertex 0 has {first} after {first}, expected ascending indices");
    refused(&with_element("influence_edges", 1, first.to_le_bytes()), &[&words]);
    let [a, b] = RIG.handles().strain_edges[3].map(|h| h.0);
    refused(&with_element("strain_edges", 7, a.to_le_bytes()), &["strain_edges[3] has no length"]);
    assert_ne!(a, b);
    refused(&with_element("triangles", 0, 24u32.to_le_bytes()), &["triangles is not made from the faces"]);
    for corners in [0, 2] {
        let words = [format!("face_counts[4] is {corners}, expected at least 3")];
        refused(&with_element("face_counts", 4, u32::to_le_bytes(corners)), &[&words[0]]);
    }
    for corners in [3, 5, u32::MAX] {
        refused(&with_element("face_counts", 4, corners.to_le_bytes()), &["face_indices has 64 elements"]);
    }
}

#[test]
fn numbers_that_are_none() {
    for array in [
        "rest",
        "basis",
        "influence_weights",
        "pose_features",
        "rbf_weights",
        "uvs",
        "example_handles",
        "anchor_weights",
        "feature_gains",
        "example_weights",
        "variances",
    ] {
        for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let words = [format!("{array}[3] is {number}, expected a finite number")];
            refused(&with_element(array, 3, number.to_le_bytes()), &[&words[0]]);
        }
    }
    for weight in [-0.25f32, 1.5] {
        let words = [format!("influence_weights[3] is {weight}, expected 0 to 1")];
        refused(&with_element("influence_weights", 3, weight.to_le_bytes()), &[&words[0]]);
        let words = [format!("anchor_weights[3] is {weight}, expected 0 to 1")];
        refused(&with_element("anchor_weights", 3, weight.to_le_bytes()), &[&words[0]]);
    }
}

/// Sizes that would overflow, or that do not fit into memory.
#[test]
fn sizes_that_lie() {
    for length in [u64::MAX, u64::MAX - 7, 1 << 62, 100_000_000, 100_000_001, BYTES.len() as u64 - 7] {
        refused(&[&length.to_le_bytes(), &BYTES[8..]].concat(), &["no whole safetensors file"]);
    }
    let (header, _) = parse(&BYTES);
    let arrays: Vec<&String> = header.as_object().unwrap().keys().filter(|k| *k != "__metadata__").collect();
    for name in &arrays {
        let last = header[name]["shape"].as_array().unwrap().len() - 1;
        for extent in [u64::MAX, 1 << 62, (1 << 62) + 1, 1 << 40, 1 << 32] {
            refused(&with_header(|h| h[name]["shape"][0] = extent.into()), &["no whole safetensors file"]);
            refused(&with_header(|h| h[name]["shape"][last] = extent.into()), &["no whole safetensors file"]);
        }
        for offsets in
            [json!([0, u64::MAX]), json!([u64::MAX, 0]), json!([8, 4]), json!([1u64 << 40, 1u64 << 41])]
        {
            refused(&with_header(|h| h[name]["data_offsets"] = offsets), &["no whole safetensors file"]);
        }
    }
    // Every array is empty. The product of its other extents would overflow.
    for extent in [0u64, 1 << 20, 1 << 40, u64::MAX] {
        let bytes = {
            let (mut header, _) = parse(&BYTES);
            for name in &arrays {
                let shape = header[*name]["shape"].as_array_mut().unwrap();
                shape.fill(extent.into());
                shape[0] = 0.into();
                header[*name]["data_offsets"] = json!([0, 0]);
            }
            assemble(&header, &[])
        };
        refused(&bytes, &[]);
    }
    // The shape's first extent has no vertices, but the second has the largest number of handles.
    let mut header = json!({"__metadata__": header["__metadata__"]});
    header["rest"] = json!({"dtype": "F32", "shape": [1u64 << 62, 0], "data_offsets": [0, 0]});
    refused(&assemble(&header, &[]), &["`rest`", "expected F32 [any, 3]"]);
}
