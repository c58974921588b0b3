//! Texture coordinates of glTF are those at which a material reads its base colour.

use super::support::{Document, corner_uvs, decode_with_warnings, message};
use rhytid_formats::mesh::{Format, decode};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;

/// A triangle with two sets of texture coordinates: floats, and integers of 12 bits as gltfpack stores them.
fn triangle(material: Value) -> Document {
    let mut document = Document::default();
    let position = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let first = document.floats("VEC2", &[0.25, 0.125, 0., 0., 1., 0.5]);
    let integers = [0_u16, 4095, 2047, 4095, 1, 0];
    let integers = integers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let second = document.accessor("VEC2", 5123, 3, integers);
    document.json = json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": position, "TEXCOORD_0": first, "TEXCOORD_1": second},
            "material": 0,
        }]}],
        "materials": [material],
    });
    document
}

fn uvs(document: &Document) -> (Vec<[f32; 2]>, Vec<String>) {
    let (mesh, warnings) = decode_with_warnings(document.text().as_bytes(), Format::Gltf, "face");
    (corner_uvs(&mesh), warnings)
}

fn base_colour(texture: &Value) -> Value {
    json!({"pbrMetallicRoughness": {"baseColorTexture": texture}})
}

#[test]
fn scale_then_rotation_then_offset() {
    // As three.js and Blender do it: u' = cos · 2 u + sin · 4 v + 0.5, and v' = cos · 4 v - sin · 2 u + 0.25.
    let transform = json!({"offset": [0.5, 0.25], "rotation": FRAC_PI_2, "scale": [2, 4]});
    let document =
        triangle(base_colour(&json!({"index": 0, "extensions": {"KHR_texture_transform": transform}})));
    let (found, warnings) = uvs(&document);
    assert_eq!(found, [[1.0, 1.25], [0.5, 0.75], [2.5, 2.75]]);
    assert!(warnings.is_empty(), "{warnings:?}");
    // The transform of another texture serves where there is no base colour, and only there.
    let other = json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}});
    let (found, _) = uvs(&triangle(json!({"normalTexture": other})));
    assert_eq!(found, [[0.5, 0.75], [0.0, 1.0], [2.0, 0.0]]);
    let mut both = base_colour(&json!({"index": 0}));
    both["normalTexture"] = other;
    let (found, _) = uvs(&triangle(both));
    assert_eq!(found, [[0.25, 0.875], [0.0, 1.0], [1.0, 0.5]]);
}

#[test]
fn a_texture_names_its_set() {
    let scale = 1.0 / 4095.0;
    let transform = json!({"scale": [scale, scale]});
    let expected = [[0.0, 0.0], [2047.0 / 4095.0, 0.0], [1.0 / 4095.0, 1.0]];
    for texture in [
        json!({"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": transform}}),
        json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [scale, scale], "texCoord": 1}}}),
    ] {
        let (found, warnings) = uvs(&triangle(base_colour(&texture)));
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        assert!(warnings.is_empty(), "{warnings:?}");
    }
    // Integers that nothing explains.
    let (found, warnings) = uvs(&triangle(base_colour(&json!({"index": 0, "texCoord": 1}))));
    assert_eq!(found[0], [0.0, -4094.0]);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("texture coordinates that are integers"), "{warnings:?}");
}

#[test]
fn primitives_share_coordinates_that_are_transformed_in_the_same_way() {
    let transform =
        |scale| json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": [scale, scale]}}});
    let mut document = triangle(base_colour(&transform(2.0)));
    document.json["materials"]
        .as_array_mut()
        .unwrap()
        .extend([base_colour(&transform(2.0)), base_colour(&transform(4.0))]);
    let primitives = document.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    for material in [1, 2] {
        let mut other = primitives[0].clone();
        other["material"] = material.into();
        primitives.push(other);
    }
    let mesh = decode(document.text().as_bytes(), Format::Gltf, "face").unwrap();
    let found = corner_uvs(&mesh);
    assert_eq!((mesh.positions.len(), mesh.uvs.unwrap().values.len()), (3, 6));
    assert_eq!([found[0], found[3], found[6]], [[0.5, 0.75], [0.5, 0.75], [1.0, 0.5]]);
}

#[test]
fn a_wrong_transform_is_one_sentence() {
    let texture = json!({"index": 0, "extensions": {"KHR_texture_transform": {"scale": "large"}}});
    let document = triangle(base_colour(&texture));
    let said = message(decode(document.text().as_bytes(), Format::Gltf, "face").map(|_| ()));
    assert!(said.contains("material 0 has a KHR_texture_transform that cannot be read"), "{said}");
}
