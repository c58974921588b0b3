//! Damaged and hostile files with compressed numbers. (`skins` has files of other programs.)

use super::support::{Document, glb, message};
use rhytid_core::Error;
use rhytid_formats::mesh::{Format, check, decode};
use serde_json::{Value, json};

const FILES: [(&str, &[u8]); 4] = [
    ("meshopt", include_bytes!("data/skin/gltfpack-c.glb")),
    ("version 1", include_bytes!("data/skin/gltfpack-khr.glb")),
    ("draco", include_bytes!("data/skin/draco.glb")),
    ("draco-edgebreaker", include_bytes!("data/skin/draco-edgebreaker.glb")),
];

/// The JSON and the binary part of a GLB.
fn parts(glb: &[u8]) -> (Value, &[u8]) {
    let json = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&glb[20..20 + json]).unwrap(), &glb[28 + json..])
}

fn refused(json: &Value, binary: &[u8]) -> String {
    message(decode(&glb(json, binary), Format::Gltf, "face").map(|_| ()))
}

#[test]
fn every_damaged_byte_gives_a_mesh_or_one_sentence() {
    for (name, bytes) in FILES {
        let (json, binary) = parts(bytes);
        let mut refused = 0;
        for at in 0..binary.len() {
            for flip in [1, 0x10, 0x80, 0xff] {
                let mut damaged = binary.to_vec();
                damaged[at] ^= flip;
                match decode(&glb(&json, &damaged), Format::Gltf, "face") {
                    Ok(mesh) => check(&mesh, "face").unwrap(),
                    Err(Error::Input(said)) => {
                        assert!(said.sentence().starts_with("face: "), "{said}");
                        refused += 1;
                    }
                    Err(other) => panic!("{name}: {other:?}"),
                }
            }
        }
        assert!(refused > 300, "{name}: {refused}");
    }
}

#[test]
fn streams_that_are_cut_short_are_refused() {
    for (name, bytes) in FILES {
        let (json, binary) = parts(bytes);
        let lengths = |json: &mut Value, by: u64| {
            let shorten = |length: &mut Value| *length = length.as_u64().unwrap().saturating_sub(by).into();
            let draco =
                json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["bufferView"]
                    .as_u64();
            for (v, view) in json["bufferViews"].as_array_mut().unwrap().iter_mut().enumerate() {
                match view["extensions"].as_object_mut().and_then(|e| e.values_mut().next()) {
                    Some(compressed) => shorten(&mut compressed["byteLength"]),
                    None if draco == Some(v as u64) => shorten(&mut view["byteLength"]),
                    None => {}
                }
            }
        };
        for by in [1, 2, 7, 40, 200, 100_000] {
            let mut json = json.clone();
            lengths(&mut json, by);
            let said = refused(&json, binary);
            assert!(said.contains("cannot be unfolded"), "{name} {by}: {said}");
        }
    }
}

#[test]
fn what_the_extensions_say_is_checked() {
    let with = |file: usize, pointer: &str, value: Value| {
        let (mut json, binary) = parts(FILES[file].1);
        *json.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}")) = value;
        refused(&json, binary)
    };
    let position = "/bufferViews/1/extensions/EXT_meshopt_compression";
    let huge = 1_u64 << 40;
    for (member, value, expected) in [
        ("/mode", json!("LINES"), "buffer view 1 is compressed in the unknown mode LINES"),
        ("/count", json!(huge), "unfolds to more than"),
        ("/count", json!(3), "buffer view 1 cannot be unfolded to 3 elements of 8 bytes"),
        ("/byteStride", json!(7), "cannot be unfolded to 75 elements of 7 bytes"),
        ("/byteStride", json!("x"), "buffer view 1 is compressed in an unknown way"),
        ("/buffer", json!(1), "buffer view 1 lies in buffer 1, which has no data here"),
        ("/buffer", json!(9), "buffer view 1 lies in buffer 9, which has no data here"),
        ("/byteOffset", json!(huge), "from byte 1099511627776 of buffer 0"),
    ] {
        let said = with(0, &format!("{position}{member}"), value);
        assert!(said.contains(expected), "{said}");
    }
    let primitive = "/meshes/0/primitives/0";
    let draco = format!("{primitive}/extensions/KHR_draco_mesh_compression");
    for (member, value, expected) in [
        (format!("{draco}/attributes/POSITION"), json!(77), "names the attribute 77"),
        (
            format!("{draco}/attributes/POSITION"),
            json!("x"),
            "KHR_draco_mesh_compression that cannot be read",
        ),
        (
            format!("{draco}/attributes"),
            json!({}),
            "primitive 0 is compressed with KHR_draco_mesh_compression",
        ),
        (format!("{draco}/bufferView"), json!(99), "buffer view 99 does not exist"),
        (format!("{draco}/bufferView"), json!(0), "cannot be unfolded"),
        (format!("{primitive}/mode"), json!(5), "has no list of triangles"),
        ("/accessors/1/type".into(), json!("VEC2"), "has 3 components in its KHR_draco_mesh_compression"),
        ("/accessors/1/count".into(), json!(huge), "accessor 1 takes 1099511627776 elements"),
    ] {
        let said = with(2, &member, value);
        assert!(said.contains(expected), "{member}: {said}");
    }
}

#[test]
fn a_fallback_is_not_needed() {
    // As gltfpack -cf writes it: the bytes are also in a file, for programs that cannot decode them.
    let (mut json, binary) = parts(FILES[0].1);
    let expected = decode(FILES[0].1, Format::Gltf, "face").unwrap();
    json["buffers"][1]["uri"] = "face.fallback.bin".into();
    json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    assert_eq!(decode(&glb(&json, binary), Format::Gltf, "face").unwrap(), expected);
    // A GLB whose primitive is also stored in the plain way needs no Draco.
    let (mut json, binary) = parts(include_bytes!("data/skin/blender.glb"));
    let expected = decode(&glb(&json, binary), Format::Gltf, "face").unwrap();
    let said = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    json["meshes"][0]["primitives"][0]["extensions"] = said;
    json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    assert_eq!(decode(&glb(&json, binary), Format::Gltf, "face").unwrap(), expected);
}

#[test]
fn the_same_bytes_named_a_thousand_times_are_refused() {
    // 25 vertices of 12 bytes become a million: each primitive names another view of the same bytes.
    let (mut json, binary) = parts(FILES[0].1);
    let (view, accessor) = (json["bufferViews"][1].clone(), json["accessors"][0].clone());
    let primitive = json!({"attributes": {"POSITION": 0}});
    let mut primitives = Vec::new();
    for _ in 0..60_000 {
        let views = json["bufferViews"].as_array_mut().unwrap();
        views.push(view.clone());
        let (number, accessors) = (views.len() - 1, json["accessors"].as_array_mut().unwrap());
        let mut accessor = accessor.clone();
        accessor["bufferView"] = number.into();
        accessor["count"] = 3.into();
        accessors.push(accessor);
        let mut primitive = primitive.clone();
        primitive["attributes"]["POSITION"] = (accessors.len() - 1).into();
        primitives.push(primitive);
    }
    json["meshes"][0] = json!({"primitives": primitives});
    json["nodes"] = json!([{"mesh": 0}]);
    json["scenes"][0]["nodes"] = json!([0]);
    let said = refused(&json, binary);
    assert!(said.contains("unfolds to more than") && said.contains("expected one face"), "{said}");

    // The same stream of Draco for many primitives.
    let (mut json, binary) = parts(FILES[2].1);
    let primitive = json["meshes"][0]["primitives"][0].clone();
    let (indices, position) = (json["accessors"][0].clone(), json["accessors"][1].clone());
    let mut primitives = Vec::new();
    for _ in 0..20_000 {
        let accessors = json["accessors"].as_array_mut().unwrap();
        accessors.extend([indices.clone(), position.clone()]);
        let mut primitive = primitive.clone();
        primitive["indices"] = (accessors.len() - 2).into();
        primitive["attributes"] = json!({"POSITION": accessors.len() - 1});
        primitives.push(primitive);
    }
    json["meshes"][0]["primitives"] = primitives.into();
    let said = refused(&json, binary);
    assert!(said.contains("unfolds to more than"), "{said}");
}

#[test]
fn copies_of_a_mesh_are_refused() {
    let mut document = Document::default();
    let position = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    document.json = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": position}}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": position}}]}],
    });
    let said = message(decode(document.text().as_bytes(), Format::Gltf, "face").map(|_| ()));
    assert!(said.contains("node 0 places copies of a mesh (EXT_mesh_gpu_instancing)"), "{said}");
    document.json["nodes"][0].as_object_mut().unwrap().remove("extensions");
    document.json["extensionsRequired"] = json!(["VRMC_vrm", "KHR_materials_unlit", "KHR_animation_pointer"]);
    decode(document.text().as_bytes(), Format::Gltf, "face").unwrap();
}
