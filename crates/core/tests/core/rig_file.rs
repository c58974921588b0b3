//! The rig file: a rig that is written is read back, and a damaged file is refused.

use proptest::prelude::*;
use rhytid_core::{
    Error, InputErrorKind, Materials, NoProgress, Prior, Rig, StatedLook, StrainEdgeId, SurfacePoint, Table,
    Texture, Tissue, Transparency, Uvs, VertexId, WrinkleStrains, rig_file,
};
use rhytid_kernels::vec3;
use rhytid_solve::solve;
use rhytid_test_support::{changed, triangle};
use serde_json::{Value, json};
use std::sync::LazyLock;

/// A rig of 25 vertices. It has texture coordinates at the corners and materials, and so every array.
static RIG: LazyLock<Rig> = LazyLock::new(|| {
    let rig = solve(&rhytid_test_support::sheet::face(), &NoProgress).unwrap().rounded().unwrap();
    let values = (0..9u8).map(|i| [f32::from(i) / 8.0, 0.1]).collect();
    let of_face = (0..16).map(|f| if f == 5 { Materials::NONE } else { f % 2 }).collect();
    changed(&rig, |r| {
        r.surface.uvs = Some(Uvs { values, corners: Some((0..64).map(|c| c % 9).collect()) });
        r.surface.materials = Some(Materials::named(["skin", "lips"], of_face));
    })
    .unwrap()
});

static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| rig_file::encode(&RIG).unwrap());

/// Reads a safetensors file by its specification: eight bytes with the length of the header, the header as
/// JSON, and the arrays.
fn parse(bytes: &[u8]) -> (Value, &[u8]) {
    let (length, rest) = bytes.split_first_chunk::<8>().unwrap();
    let (header, arrays) = rest.split_at(u64::from_le_bytes(*length) as usize);
    (serde_json::from_slice(header).unwrap(), arrays)
}

/// The opposite of [`parse`].
fn assemble(header: &Value, arrays: &[u8]) -> Vec<u8> {
    let header = header.to_string();
    [&(header.len() as u64).to_le_bytes(), header.as_bytes(), arrays].concat()
}

/// The file with its header changed.
fn with_header(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut header, arrays) = parse(&BYTES);
    change(&mut header);
    assemble(&header, arrays)
}

/// The file with its own metadata changed.
fn with_metadata(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    with_header(|header| {
        let text = &mut header["__metadata__"]["rhytid"];
        let mut metadata: Value = serde_json::from_str(text.as_str().unwrap()).unwrap();
        change(&mut metadata);
        *text = metadata.to_string().into();
    })
}

/// The file with four bytes of `array` replaced, at `element`.
fn with_element(array: &str, element: usize, bytes: [u8; 4]) -> Vec<u8> {
    with_element_of(&BYTES, array, element, bytes)
}

fn with_element_of(file: &[u8], array: &str, element: usize, bytes: [u8; 4]) -> Vec<u8> {
    let (header, arrays) = parse(file);
    let start = header[array]["data_offsets"][0].as_u64().unwrap() as usize;
    let mut arrays = arrays.to_vec();
    arrays[start + 4 * element..][..4].copy_from_slice(&bytes);
    assemble(&header, &arrays)
}

/// Asserts that the file is refused in one sentence which begins with its name and has `words`.
#[track_caller]
fn refused(bytes: &[u8], words: &[&str]) -> InputErrorKind {
    match rig_file::decode(bytes, "face.safetensors") {
        Err(Error::Input(message)) => {
            assert!(message.sentence().starts_with("face.safetensors: "), "{message}");
            assert!(!message.sentence().contains('\n'), "{message}");
            for word in words {
                assert!(message.sentence().contains(word), "{word}: {message}");
            }
            message.kind().clone()
        }
        other => panic!("{words:?}: {:?}", other.map(|rig| rig.vertices())),
    }
}

/// A rig with a handle inside a triangle.
fn inside_a_triangle() -> Rig {
    let mut face = rhytid_test_support::sheet::face();
    face.handles.points[2] = SurfacePoint::new([6, 7, 12].map(VertexId), [0.3, 0.3, 0.4]).unwrap();
    solve(&face, &NoProgress).unwrap().rounded().unwrap()
}

#[test]
fn a_rig_with_a_prior_has_lengths_and_a_version() {
    let mut face = rhytid_test_support::sheet::face();
    let expressions = face.examples.clone();
    face.prior = Some(Prior { expressions, weight: Some(0.5) });
    let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    let features = rig.handles().features();
    assert_eq!(header["prior_lengths"]["shape"], json!([features]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":8,"));
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    // A vector strain is followed as far as the prior's expressions go.
    let lengths = &rig.learned().unwrap().prior_lengths;
    let longest = rig.example_vectors().row(0).iter().map(|d| vec3::dot(*d, *d).sqrt()).collect::<Vec<f32>>();
    assert!(lengths.iter().zip(&longest).all(|(a, b)| (a - b).abs() < 1e-6), "{lengths:?} {longest:?}");
    let damaged = |length: f32| with_element_of(&bytes, "prior_lengths", 1, length.to_le_bytes());
    refused(&damaged(f32::NAN), &["prior_lengths"]);
    assert!(rig_file::decode(&damaged(0.5), "rig").unwrap().feature_limits()[1] >= 0.5);
}

#[test]
fn a_rig_with_eyeballs_has_lids_and_a_version() {
    let rig = solve(&rhytid_test_support::eye::face(), &NoProgress).unwrap().rounded().unwrap();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    let lids = rig.learned().unwrap().contact.lids.len();
    assert!(lids > 20);
    assert_eq!(header["eyeball_corners"]["shape"], json!([1, 4]));
    assert_eq!(header["eyeball_weights"]["shape"], json!([1, 4]));
    assert_eq!(header["lid_vertices"]["shape"], json!([lids, 3]));
    assert_eq!(header["lid_distances"]["shape"], json!([lids, 2]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":9,"));
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    let damaged = |array: &str, element: usize, value: u32| {
        with_element_of(&bytes, array, element, value.to_le_bytes())
    };
    refused(&damaged("eyeball_corners", 2, u32::MAX), &["eyeball_corners[2]", "index below"]);
    refused(&damaged("eyeball_weights", 1, f32::NAN.to_bits()), &["eyeball_weights[1]"]);
    refused(&damaged("lid_vertices", 3, u32::MAX), &["lid_vertices[1]", "index below"]);
    refused(&damaged("lid_vertices", 4, 1), &["lid_vertices[1]", "eyeball"]);
    refused(&damaged("lid_vertices", 5, lids as u32), &["lid_vertices[1]"]);
    refused(&damaged("lid_distances", 4, 0.0_f32.to_bits()), &["lid_distances[2]", "above 0"]);
    refused(&damaged("lid_distances", 5, 1e-3_f32.to_bits()), &["lid_distances[2]", "smaller one first"]);
    // A part of the vertices has no whole eyeball.
    let part = rig.part(&[VertexId(3), VertexId(70)]);
    assert!(part.learned().unwrap().contact.eyeballs.is_empty());
}

#[test]
fn a_rig_with_lips_has_openings_and_a_version() {
    let rig = solve(&rhytid_test_support::lips::face(), &NoProgress).unwrap().rounded().unwrap();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    let openings = &rig.learned().unwrap().contact.openings;
    let (rims, followers) = (openings.rims.len(), openings.followers.len());
    assert!(rims > 50 && followers > rims);
    assert_eq!(header["rim_vertices"]["shape"], json!([rims]));
    assert_eq!(header["rim_across"]["shape"], json!([rims, 12]));
    assert_eq!(header["rim_gaps"]["shape"], json!([rims, 2]));
    assert_eq!(header["rim_followers"]["shape"], json!([followers]));
    assert_eq!(header["rim_leaders"]["shape"], json!([followers, 8]));
    assert_eq!(header["rim_leader_weights"]["shape"], json!([followers, 8]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":9,"));
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    let damaged = |array: &str, element: usize, value: u32| {
        with_element_of(&bytes, array, element, value.to_le_bytes())
    };
    refused(&damaged("rim_vertices", 1, u32::MAX), &["rim_vertices[1]", "index below"]);
    refused(&damaged("rim_across", 5, rims as u32), &["rim_across[5]", "index below"]);
    refused(&damaged("rim_gaps", 2, 0.0_f32.to_bits()), &["rim_gaps[1]", "length above 0"]);
    refused(&damaged("rim_gaps", 3, f32::NAN.to_bits()), &["rim_gaps[3]", "finite"]);
    refused(&damaged("rim_followers", 0, u32::MAX), &["rim_followers[0]", "index below"]);
    refused(&damaged("rim_leaders", 9, rims as u32), &["rim_leaders[9]", "index below"]);
    refused(&damaged("rim_leader_weights", 4, 1.5_f32.to_bits()), &["rim_leader_weights[4]", "-1 to 1"]);
    let part = rig.part(&[VertexId(3), VertexId(70)]);
    assert!(part.learned().unwrap().contact.is_empty());
}

#[test]
fn handles_inside_triangles_have_weights_and_a_version() {
    let rig = inside_a_triangle();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    assert_eq!(header["handles"]["shape"], json!([5, 3]));
    assert_eq!(header["handle_weights"]["shape"], json!([5, 3]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":7,"));
    // The weights of the third handle are those of the face, and the others are at vertices.
    let third = rig.handles().points[2];
    assert_eq!(third.triangle(), [6, 7, 12].map(VertexId));
    assert!((third.weights()[2] - 0.4).abs() < 1e-7);
    assert_eq!(rig.handles().points[1], VertexId(4).into());
    let damaged = |weight: f32| with_element_of(&bytes, "handle_weights", 6, weight.to_le_bytes());
    refused(&damaged(0.7), &["handle_weights[2]", "sum is 1"]);
    refused(&damaged(-0.3), &["handle_weights[2]"]);
    refused(&damaged(f32::NAN), &["handle_weights[2]"]);
    refused(&with_element_of(&bytes, "handles", 6, 25u32.to_le_bytes()), &["handles[2] is 25"]);
}

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

/// Files that older programs wrote, and new files that older programs read.
#[test]
fn materials_have_looks_and_textures_and_a_version() {
    let png: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x02\0\0\0\x03";
    let jpeg: &[u8] = b"\xff\xd8\xff\xe0\0\x04ab\xff\xc0\0\x0b\x08\0\x05\0\x07\x03";
    let rig = changed(&RIG, |r| {
        let materials = r.surface.materials.as_mut().unwrap();
        materials.textures = vec![
            Texture { name: "skin.png".into(), path: Some("maps/skin.png".into()), bytes: png.into() },
            Texture { name: "lips.jpg".into(), path: None, bytes: jpeg.into() },
        ];
        materials.list[0].stated = StatedLook {
            base_color: Some([0.1, 0.2, 1.0]),
            texture: Some(0),
            opacity: Some(0.3),
            transparency: Some(Transparency::Mask(0.7)),
            roughness: Some(0.6),
            metallic: Some(0.0),
        };
        materials.list[1].stated.texture = Some(1);
        materials.list[1].tissue = Tissue::Mouth;
    })
    .unwrap();
    assert_eq!(rig.surface().materials.as_ref().unwrap().textures[0].size(), Some([2, 3]));
    assert_eq!(rig.surface().materials.as_ref().unwrap().textures[1].size(), Some([7, 5]));
    let bytes = rig_file::encode(&rig).unwrap();
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    let (header, arrays) = parse(&bytes);
    let metadata: Value = serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
    assert_eq!(metadata["version"], 11);
    let stated = json!({"base_color": [0.1, 0.2, 1.0], "texture": 0, "opacity": 0.3, "transparency": {"mask": 0.7},
        "roughness": 0.6, "metallic": 0.0});
    assert_eq!(metadata["looks"][0], json!({"tissue": "skin", "stated": stated}));
    assert_eq!(metadata["looks"][1], json!({"tissue": "mouth", "stated": {"texture": 1}}));
    let textures = json!([{"name": "skin.png", "path": "maps/skin.png", "bytes": png.len()},
        {"name": "lips.jpg", "bytes": jpeg.len()}]);
    assert_eq!(metadata["textures"], textures);
    let [first, end] = [0, 1].map(|i| header["texture_bytes"]["data_offsets"][i].as_u64().unwrap() as usize);
    assert_eq!(arrays[first..end], [png, jpeg].concat());

    let damaged = |change: &dyn Fn(&mut Value), words: &str| {
        let mut header = header.clone();
        let mut metadata = metadata.clone();
        change(&mut metadata);
        header["__metadata__"]["rhytid"] = metadata.to_string().into();
        refused(&assemble(&header, arrays), &[words]);
    };
    damaged(&|m| m["looks"] = json!([{"tissue": "skin", "stated": {}}]), "1 looks for 2 materials");
    damaged(&|m| m["looks"][1]["tissue"] = "wood".into(), "metadata cannot be read");
    damaged(&|m| m["looks"][1]["stated"]["texture"] = 2.into(), "texture 2, expected one of its 2");
    damaged(&|m| m["looks"][1]["stated"]["opacity"] = 2.into(), "opacity 2, expected 0 to 1");
    damaged(&|m| m["textures"][1]["bytes"] = 1000.into(), "ends within the texture lips.jpg");
    damaged(&|m| m["textures"][1]["bytes"] = 4.into(), "bytes more than its textures");
    damaged(&|m| m["textures"][0]["name"] = "../skin.png".into(), "a file name without folders");
    damaged(&|m| m["textures"][0]["name"] = "skin.exe".into(), "that ends in .png");
    let shifted =
        json!([{"name": "skin.png", "bytes": png.len() - 4}, {"name": "lips.jpg", "bytes": jpeg.len() + 4}]);
    damaged(&|m| m["textures"] = shifted.clone(), "a texture “lips.jpg” that is neither PNG nor JPEG");
}

#[test]
fn a_rig_of_the_chapters_method_is_a_file_of_version_2() {
    let chapter = changed(&RIG, |r| r.learned = None).unwrap();
    let bytes = rig_file::encode(&chapter).unwrap();
    assert_eq!(rig_file::decode(&bytes, "x").unwrap(), chapter);
    let (header, _) = parse(&bytes);
    let metadata: Value = serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
    assert_eq!((&metadata["version"], &metadata["method"]), (&json!(2), &json!("chapter")));
    assert!(metadata.get("learned").is_none() && header.get("anchors").is_none());

    // Older programs would not turn the handles.
    for still in [&chapter, &*RIG] {
        let turning = changed(still, |r| r.handles.rotations = true).unwrap();
        let bytes = rig_file::encode(&turning).unwrap();
        assert_eq!(rig_file::decode(&bytes, "x").unwrap(), turning);
        let (header, _) = parse(&bytes);
        let metadata: Value =
            serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
        assert_eq!((&metadata["version"], &metadata["rotations"]), (&json!(6), &json!(true)));
    }

    // Without a share there are no weights of examples.
    let linear = changed(&RIG, |r| {
        let learned = r.learned.as_mut().unwrap();
        learned.share = 0.0;
        learned.example_weights = Table::without_columns(25);
    })
    .unwrap();
    let bytes = rig_file::encode(&linear).unwrap();
    assert!(parse(&bytes).0.get("example_weights").is_none());
    assert_eq!(rig_file::decode(&bytes, "x").unwrap(), linear);
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

/// A missing key has a meaning: JSON cannot hold infinity, and older files have strain lengths.
#[test]
fn what_is_not_said_of_the_learned_method() {
    let bytes = with_metadata(|m| {
        let learned = m["learned"].as_object_mut().unwrap();
        learned.remove("reach");
        learned.remove("wrinkle_strains");
    });
    let rig = rig_file::decode(&bytes, "x").unwrap();
    let learned = rig.learned().unwrap();
    assert_eq!((learned.reach, learned.wrinkle_strains), (f64::INFINITY, WrinkleStrains::Lengths));
    let written = rig_file::encode(&rig).unwrap();
    assert_eq!(rig_file::decode(&written, "x").unwrap(), rig);
}

/// Files from before the keys were renamed mean the same.
#[test]
fn the_former_names_of_keys_are_read() {
    let bytes = with_metadata(|m| {
        let learned = m["learned"].as_object_mut().unwrap();
        for (former, key) in [("fold_ridge", "wrinkle_ridge"), ("fold_strains", "wrinkle_strains")] {
            let value = learned.remove(key).unwrap();
            learned.insert(former.into(), value);
        }
    });
    assert_ne!(bytes, with_metadata(|_| ()));
    let now = rig_file::decode(&with_metadata(|_| ()), "x").unwrap();
    assert_eq!(now.learned().unwrap().wrinkle_strains, WrinkleStrains::Vectors);
    assert_eq!(rig_file::decode(&bytes, "x").unwrap(), now);
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

/// Reads damaged bytes. They must be refused as input, or give a rig that passes [`Rig::new`].
fn survives(bytes: &[u8]) -> Result<(), TestCaseError> {
    match rig_file::decode(bytes, "face.safetensors") {
        Ok(rig) => {
            let again = Rig::new(rig.clone().into_parts());
            again.map_err(|e| TestCaseError::fail(e.to_string()))?;
            let bytes = rig_file::encode(&rig).map_err(|e| TestCaseError::fail(e.to_string()))?;
            prop_assert_eq!(rig_file::decode(&bytes, "again").unwrap(), rig);
        }
        Err(Error::Input(message)) => {
            prop_assert!(message.sentence().starts_with("face.safetensors: "), "{message}");
        }
        Err(other) => prop_assert!(false, "{other:?}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn damaged_bytes(flips in prop::collection::vec((any::<prop::sample::Index>(), 1u8..), 1..9)) {
        let mut bytes = BYTES.clone();
        for (at, mask) in flips {
            bytes[at.index(BYTES.len())] ^= mask;
        }
        survives(&bytes)?;
    }

    /// Damage behind a header that is whole, where it is hardest to find.
    #[test]
    fn damaged_arrays(words in prop::collection::vec((any::<prop::sample::Index>(), 0u32..30), 1..4)) {
        let (header, arrays) = parse(&BYTES);
        let mut arrays = arrays.to_vec();
        for (at, word) in words {
            let start = 4 * at.index(arrays.len() / 4);
            arrays[start..][..4].copy_from_slice(&word.to_le_bytes());
        }
        survives(&assemble(&header, &arrays))?;
    }

    #[test]
    fn garbage(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        refused(&bytes, &[]);
    }
}
