use super::support::{corner_uvs, decode_with_warnings, glb, message, polygons, refused};
use base64::Engine;
use rhytid_core::{Materials, Mesh};
use rhytid_formats::mesh::{Format, decode, read};
use serde_json::{Value, json};
use std::f32::consts::FRAC_1_SQRT_2;

fn error(document: &Value) -> String {
    refused(document.to_string().as_bytes(), Format::Gltf)
}

fn load(document: &Value) -> Mesh {
    decode(document.to_string().as_bytes(), Format::Gltf, "face").unwrap()
}

/// Four vertices of a square, each 16 bytes; texture coordinates; a strip of 8-bit indices.
fn data() -> Vec<u8> {
    let mut data = Vec::new();
    for p in [[0.0_f32, 0.0, 0.0, 7.0], [1.0, 0.0, 0.0, 7.0], [0.0, 1.0, 0.0, 7.0], [1.0, 1.0, 0.5, 7.0]] {
        data.extend(p.iter().flat_map(|x| x.to_le_bytes()));
    }
    for uv in [[0.0_f32, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 0.25]] {
        data.extend(uv.iter().flat_map(|x| x.to_le_bytes()));
    }
    data.extend([0, 1, 2, 3]); // a strip
    data.extend([0, 0, 1, 0, 3, 0, 0, 0]); // a triangle of 16-bit indices, and two bytes more
    data
}

fn data_uri(data: &[u8]) -> String {
    format!("data:application/octet-stream;base64,{}", base64::prelude::BASE64_STANDARD.encode(data))
}

/// A square as a strip (accessor 2), and a triangle (accessor 3) on the same vertices.
fn square() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "mode": 5}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5121, "count": 4, "type": "SCALAR"},
            {"bufferView": 2, "byteOffset": 4, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 64, "byteStride": 16},
            {"buffer": 0, "byteOffset": 64, "byteLength": 32},
            {"buffer": 0, "byteOffset": 96, "byteLength": 12},
        ],
        "buffers": [{"byteLength": 108, "uri": data_uri(&data())}],
    })
}

const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5]];

#[test]
fn reads_strips_strides_and_flips_uvs() {
    let mesh = load(&square());
    assert_eq!(mesh.positions, CORNERS);
    assert_eq!(polygons(&mesh), [vec![0, 1, 2], vec![1, 3, 2]]);
    let uvs = mesh.uvs.unwrap();
    assert_eq!((uvs.values, uvs.corners), (vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.75]], None));
}

#[test]
fn reads_what_trimesh_wrote() {
    // Node b hangs mirrored under node a, and shares its texture coordinates.
    let mesh = decode(include_bytes!("data/trimesh.glb"), Format::Gltf, "face").unwrap();
    let positions = [
        [10.0, 20.0, 30.0],
        [10.0, 22.0, 30.5],
        [8.0, 22.0, 30.0],
        [8.0, 20.0, 29.0],
        [4.0, 14.0, 36.0],
        [4.0, 13.0, 36.25],
        [3.0, 13.0, 36.0],
        [3.0, 14.0, 35.5],
    ];
    for (found, expected) in mesh.positions.iter().flatten().zip(positions.iter().flatten()) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    assert_eq!(mesh.positions.len(), positions.len());
    // trimesh turns the mirrored triangle round to 6 5 4, which is the same as 4 6 5.
    assert_eq!(polygons(&mesh), [vec![0, 1, 2], vec![0, 2, 3], vec![4, 6, 5]]);
    let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.75], [0.0, 1.0]];
    assert_eq!(corner_uvs(&mesh), [0, 1, 2, 0, 2, 3, 0, 2, 1].map(|i| uv[i]));
}

#[test]
fn primitives_name_the_materials_of_their_faces() {
    let mut document = square();
    assert_eq!(load(&document).materials, None);
    document["materials"] = json!([{"name": "unused"}, {"name": "lips"}, {}, {"name": "skin"}]);
    let primitive = |material: Value| {
        let mut primitive = json!({"attributes": {"POSITION": 0}, "indices": 3});
        primitive["material"] = material;
        primitive
    };
    let mut unnamed = primitive(json!(0));
    unnamed.as_object_mut().unwrap().remove("material");
    document["meshes"][0]["primitives"] =
        json!([primitive(json!(3)), primitive(json!(1)), unnamed, primitive(json!(2)), primitive(json!(3))]);
    let materials = load(&document).materials.unwrap();
    assert_eq!(materials.names().collect::<Vec<_>>(), ["skin", "lips"]);
    assert_eq!(materials.of_face, [0, 1, Materials::NONE, Materials::NONE, 0]);
}

#[test]
fn primitives_share_vertices() {
    let mut document = square();
    let second = json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 3});
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
    let mesh = load(&document);
    assert_eq!(mesh.positions, CORNERS);
    assert_eq!(polygons(&mesh), [vec![0, 1, 2], vec![1, 3, 2], vec![0, 1, 3]]);
    assert_eq!(mesh.uvs.unwrap().corners, None);

    // Another node places the same mesh elsewhere: these are other vertices.
    document["scenes"][0]["nodes"] = json!([1, 0]);
    document["nodes"].as_array_mut().unwrap().push(json!({"mesh": 0, "translation": [0, 0, 5]}));
    let mesh = load(&document);
    assert_eq!(mesh.positions, [CORNERS.map(|[x, y, z]| [x, y, z + 5.0]), CORNERS].concat());
    assert_eq!(polygons(&mesh)[2..4], [vec![0, 1, 3], vec![4, 5, 6]]);
}

#[test]
fn nodes_transform_parents_first() {
    let mut document = square();
    // 90° about z, then scaled and moved by the parent.
    document["nodes"] = json!([
        {"children": [1, 2], "scale": [2, 2, 2], "translation": [1, 0, 0]},
        {"mesh": 0, "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]},
        {"mesh": 0, "scale": [3, 3, 3]},
    ]);
    let mesh = load(&document);
    let turned = CORNERS.map(|[x, y, z]| [1.0 - 2.0 * y, 2.0 * x, 2.0 * z]);
    let scaled = CORNERS.map(|[x, y, z]| [6.0 * x + 1.0, 6.0 * y, 6.0 * z]);
    assert_eq!(mesh.positions.len(), 8);
    for (found, expected) in mesh.positions.iter().flatten().zip(turned.iter().chain(&scaled).flatten()) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

#[test]
fn modes_and_missing_indices() {
    let mut document = square();
    let primitive = |document: &mut Value, mode: u32, indices: Option<u32>| {
        document["meshes"][0]["primitives"][0]["mode"] = mode.into();
        document["meshes"][0]["primitives"][0]["indices"] = indices.into();
    };
    primitive(&mut document, 6, None);
    assert_eq!(polygons(&load(&document)), [vec![0, 1, 2], vec![0, 2, 3]]);
    primitive(&mut document, 5, None);
    assert_eq!(polygons(&load(&document)), [vec![0, 1, 2], vec![1, 3, 2]]);
    primitive(&mut document, 4, Some(3));
    assert_eq!(polygons(&load(&document)), [vec![0, 1, 3]]);
    primitive(&mut document, 4, None);
    assert!(error(&document).contains("primitive 0 has 4 corners of triangles, expected a multiple of 3"));
    primitive(&mut document, 9, None);
    assert!(error(&document).contains("primitive 0 has an unknown mode"));

    primitive(&mut document, 5, None);
    let points = json!({"attributes": {"POSITION": 0}, "mode": 0});
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(points);
    let bytes = document.to_string();
    let (mesh, warnings) = decode_with_warnings(bytes.as_bytes(), Format::Gltf, "points.gltf");
    assert_eq!((mesh.faces.len(), mesh.uvs.is_some()), (2, true));
    assert_eq!(warnings, ["points.gltf: 1 primitives of points or lines were skipped"]);
}

#[test]
fn triangles_that_only_turn_a_strip_are_no_faces() {
    let mut document = square();
    let mut bytes = data();
    bytes[96..104].copy_from_slice(&[0, 1, 2, 2, 1, 1, 3, 2]);
    document["buffers"][0]["uri"] = data_uri(&bytes).into();
    document["accessors"][2]["count"] = 8.into();
    // 0 1 2 | 1 2 2 | 2 2 1 | 2 1 1 | 1 1 3 | 1 3 2 turned round, being the sixth
    assert_eq!(polygons(&load(&document)), [vec![0, 1, 2], vec![1, 2, 3]]);
}

#[test]
fn quantised_and_sparse_accessors() {
    let mut document = square();
    document["extensionsRequired"] =
        json!(["KHR_mesh_quantization", "KHR_materials_unlit", "KHR_technique_webgl"]);
    let mut bytes = data();
    bytes.extend([0_i16, 32_767, -32_768, -32_767, 16_384, 1, 0, 0, 0].iter().flat_map(|x| x.to_le_bytes()));
    bytes.push(1); // the replaced element
    bytes.extend([[5.0_f32, 6.0, 7.0]].iter().flatten().flat_map(|x| x.to_le_bytes()));
    document["buffers"][0] = json!({"byteLength": bytes.len(), "uri": data_uri(&bytes)});
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(json!({"buffer": 0, "byteOffset": 108, "byteLength": 18}));
    views.push(json!({"buffer": 0, "byteOffset": 126, "byteLength": 13}));
    document["accessors"][0] =
        json!({"bufferView": 3, "componentType": 5122, "count": 3, "type": "VEC3", "normalized": true});
    document["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": 0}});
    let large = 16_384.0 / 32_767.0;
    let positions = [[0.0, 1.0, -1.0], [-1.0, large, 1.0 / 32_767.0], [0.0; 3]];
    assert_eq!(load(&document).positions, positions);
    document["accessors"][0]["normalized"] = false.into();
    assert_eq!(load(&document).positions[0], [0.0, 32_767.0, -32_768.0]);

    document["accessors"][0] = json!({
        "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "sparse": {
            "count": 1,
            "indices": {"bufferView": 4, "componentType": 5121},
            "values": {"bufferView": 4, "byteOffset": 1},
        },
    });
    assert_eq!(load(&document).positions, [CORNERS[0], [5.0, 6.0, 7.0], CORNERS[2]]);
    document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(load(&document).positions, [[0.0; 3], [5.0, 6.0, 7.0], [0.0; 3]]);
    document["accessors"][0]["count"] = 1.into();
    assert!(error(&document).contains("accessor 0 replaces its element 1, which it does not have"));
}

#[test]
fn uvs_survive_where_a_primitive_has_none() {
    let whole = load(&square());
    let mut document = square();
    let second = json!({"attributes": {"POSITION": 0}, "indices": 3});
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
    let text = document.to_string();
    let (mesh, warnings) = decode_with_warnings(text.as_bytes(), Format::Gltf, "partial.gltf");
    assert_eq!(mesh.faces.len(), 3);
    assert_eq!(corner_uvs(&mesh), [corner_uvs(&whole), vec![[0.0, 0.0]; 3]].concat());
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].contains("3 of 9 face corners have no usable texture coordinates"),
        "{}",
        warnings[0]
    );
}

#[test]
fn external_buffers_lie_beside_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.GLTF");
    let mut document = square();
    document["buffers"][0]["uri"] = "the%20face.bin".into();
    std::fs::write(&path, document.to_string()).unwrap();
    let missing = message(read(&path).map(|_| ()));
    assert!(
        missing.contains("face.GLTF: keeps its numbers in ") && missing.contains("the face.bin"),
        "{missing}"
    );
    std::fs::write(folder.path().join("the face.bin"), data()).unwrap();
    assert_eq!(read(&path).unwrap(), load(&square()));
    std::fs::write(folder.path().join("the face.bin"), &data()[1..]).unwrap();
    assert!(
        message(read(&path).map(|_| ())).contains("buffer 0 has 107 bytes, expected 108; it is cut short")
    );
    assert!(error(&document).contains("which cannot be reached from here"));
    document["buffers"][0]["uri"] = "https://example.com/face.bin".into();
    std::fs::write(&path, document.to_string()).unwrap();
    assert!(message(read(&path).map(|_| ())).contains("expected a file beside it"));
}

#[test]
fn scenes_and_animations_may_be_without_nodes() {
    let mut document = square();
    let mesh = load(&document);
    document["scenes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"name": "no list of nodes, as Blender writes it"}));
    assert_eq!(load(&document), mesh);
    // In a GLB, whose second half is the buffer.
    document["buffers"][0] = json!({"byteLength": data().len()});
    assert_eq!(decode(&glb(&document, &data()), Format::Gltf, "face").unwrap(), mesh);
    document["buffers"][0]["uri"] = data_uri(&data()).into();
    // An animation may move something else than a node.
    document["animations"] = json!([{
        "samplers": [{"input": 0, "output": 0}],
        "channels": [{
            "sampler": 0,
            "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0"}}},
        }],
    }]);
    assert_eq!(load(&document), mesh);
    document["scene"] = 1.into();
    assert!(error(&document).contains("has 0 vertices but no faces"), "{}", error(&document));
}

#[test]
fn errors_name_what_is_wrong() {
    let text = square().to_string();
    let glb = include_bytes!("data/trimesh.glb");
    let bytes_refused = |bytes: &[u8], expected: &str| {
        let message = refused(bytes, Format::Gltf);
        assert!(message.contains(expected), "{message:?} lacks {expected:?}");
    };
    bytes_refused(b"", "face: is empty");
    bytes_refused(
        b"ply\nformat ascii 1.0\n",
        "is a PLY file by its first bytes, not glTF; rename it to .ply",
    );
    bytes_refused(&text.as_bytes()[..200], "its JSON ends too early: EOF while parsing");
    bytes_refused(br#"{"asset": {"version": "1.0"}, "meshes": {"a": {}}}"#, "is glTF 1.0, expected glTF 2.0");
    bytes_refused(br#"{"asset": {"version": 1}, "meshes": {"a": {}}}"#, "is glTF 1.0, expected glTF 2.0");
    // The version may be missing there; meshes then have names.
    bytes_refused(br#"{"asset": {}, "meshes": {"a": {}}, "scene": "b"}"#, "is glTF 1.0, expected glTF 2.0");
    bytes_refused(
        br#"{"asset": {"version": "2.0"}, "meshes": 3}"#,
        "is not that of a glTF 2.0 file: invalid type: integer `3`, expected a sequence at line 1 column 41; \
         export the mesh again",
    );
    bytes_refused(b"glTF\x03\0\0\0\x0c\0\0\0", "is not a valid glTF file: unsupported version");
    bytes_refused(b"{}", "is not that of a glTF 2.0 file: missing field `asset`");
    bytes_refused(&glb[..10], "has 10 bytes, expected at least the 12 of a GLB header");
    bytes_refused(
        &glb[..1000],
        "has 1000 bytes, expected the 1700 that its header announces; the file is cut short",
    );
    bytes_refused(b"glTF\x02\0\0\0\x05\0\0\0", "announces a length of 5 bytes");
    bytes_refused(b"glTF\x01\0\0\0\x0c\0\0\0", "is glTF 1.0, expected glTF 2.0");

    let huge = 18_446_744_073_709_551_615_u64;
    for (pointer, value, expected) in [
        ("/scene", json!(3), "has 1 scenes, expected a default one with number 3"),
        ("/scenes/0/nodes/0", json!(9), "node 9 does not exist"),
        ("/nodes/0", json!({"children": [0]}), "node 0 is placed twice"),
        ("/nodes/0/mesh", json!(1), "mesh 1 does not exist"),
        ("/nodes/0", json!({"mesh": 0, "rotation": [0, 0, 0, 0]}), "vertex 0 (counted from 0) is at [NaN"),
        (
            "/nodes/0",
            json!({"mesh": 0, "scale": [1e38, 1, 1], "translation": [3e38, 0, 0]}),
            "vertex 1 (counted",
        ),
        ("/nodes/0", json!({}), "has 0 vertices but no faces"),
        ("/meshes/0/primitives/0/attributes", json!({}), "mesh 0, primitive 0 has no POSITION"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(77), "accessor 77 does not exist"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(1), "accessor 1 does not have 3 components"),
        ("/meshes/0/primitives/0/indices", json!(0), "accessor 0 holds indices as F32, expected U8"),
        ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(0), "accessor 0 does not have 2 components"),
        ("/accessors/1/count", json!(3), "has 3 texture coordinates for 4 vertices"),
        (
            "/accessors/0/count",
            json!(5),
            "accessor 0 takes 5 elements of 16 bytes from byte 0 of buffer view 0, which has 64",
        ),
        ("/accessors/0/count", json!(huge), "accessor 0 takes 18446744073709551615 elements"),
        ("/accessors/0/byteOffset", json!(huge), "from byte 18446744073709551615 of buffer view 0"),
        ("/accessors/0/count", json!(3), "primitive 0 has"),
        ("/accessors/2/count", json!(13), "accessor 2 takes 13 elements of 1 bytes"),
        ("/accessors/0/componentType", json!(5130), "accessor 0 has an unknown component type"),
        ("/accessors/0/bufferView", json!(5), "buffer view 5 does not exist, expected one of the 3"),
        ("/accessors/0/bufferView", Value::Null, "mesh 0, primitive 0 is compressed with an extension"),
        (
            "/accessors/2",
            json!({"componentType": 5121, "count": huge, "type": "SCALAR"}),
            "accessor 2 announces 18446744073709551615 elements and has none",
        ),
        ("/bufferViews/0/byteStride", json!(8), "accessor 0 has a stride of 8 bytes, expected at least 12"),
        ("/bufferViews/0/byteLength", json!(huge), "buffer view 0 takes 18446744073709551615 bytes"),
        ("/bufferViews/0/byteOffset", json!(huge), "from byte 18446744073709551615 of buffer 0"),
        ("/bufferViews/0/buffer", json!(4), "buffer view 0 lies in buffer 4, which has no data here"),
        ("/buffers/0/byteLength", json!(109), "buffer 0 has 108 bytes, expected 109"),
        ("/buffers/0/uri", json!("data:;base64,@@"), "buffer 0 is not valid base64 data"),
        ("/buffers/0/uri", Value::Null, "buffer view 0 lies in buffer 0, which has no data here"),
    ] {
        let mut document = square();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match document.pointer_mut(parent).unwrap() {
            Value::Array(array) => array[key.parse::<usize>().unwrap()] = value.clone(),
            parent => parent[key] = value.clone(),
        }
        let message = error(&document);
        assert!(message.contains(expected), "{pointer} = {value} gave {message:?}");
    }

    for (extension, expected) in [
        ("ACME_mesh_compression", "is compressed with ACME_mesh_compression, which is not supported"),
        ("ACME_shape", "requires the extension ACME_shape, which is not supported"),
    ] {
        let mut document = square();
        document["extensionsRequired"] = json!([extension]);
        assert!(error(&document).contains(expected), "{}", error(&document));
    }
}

#[test]
fn a_crowd_from_a_few_bytes_is_refused() {
    let mut document = square();
    let crowd: Vec<Value> = (0..20_000).map(|_| json!({"mesh": 0})).collect();
    document["scenes"][0]["nodes"] = (0..crowd.len()).collect();
    document["nodes"] = crowd.into();
    assert!(error(&document).contains("expected one face"), "{}", error(&document));
}

#[test]
fn a_long_chain_of_nodes_does_not_overflow_the_stack() {
    let mut document = square();
    let mut chain: Vec<Value> = (1..200_000).map(|i| json!({"children": [i]})).collect();
    chain.push(json!({"mesh": 0}));
    document["nodes"] = chain.into();
    assert_eq!(load(&document).positions, CORNERS);
}
