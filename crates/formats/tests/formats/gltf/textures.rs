//! The looks of materials, and their textures.

use super::cases::{Case, animation, three_materials};
use super::tools::unfold;
use super::validator::assert_valid;
use crate::animation::{Animation, UvKind};
use rhytid_core::{StatedLook, Texture, Transparency};
use rhytid_formats::animation;
use rhytid_formats::export::{Options, TextureFiles};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A PNG of one colour.
pub(crate) fn picture(color: [u8; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&color.repeat(4)).unwrap();
    bytes
}

fn texture(name: &str, path: Option<&str>, bytes: &[u8]) -> Texture {
    Texture { name: name.into(), path: path.map(String::from), bytes: bytes.into() }
}

/// An animation with three materials. Two of them have textures with the same bytes, and one states nothing.
pub(crate) fn textured(uvs: UvKind) -> Animation {
    let mut animation = animation(uvs, 3, 80);
    let mut materials = three_materials(animation.faces.len());
    let skin = picture([200, 150, 120, 255]);
    materials.textures = vec![
        texture("unused.png", None, &picture([1, 2, 3, 4])),
        texture("skin.png", Some("maps/skin 1.png"), &skin),
        texture("again.png", Some("maps/again.png"), &skin),
        texture("eye.png", None, &picture([20, 30, 40, 128])),
    ];
    materials.list[0].stated =
        StatedLook { texture: Some(1), roughness: Some(0.25), ..StatedLook::default() };
    materials.list[2].stated = StatedLook {
        base_color: Some([0.5, 0.25, 1.0]),
        texture: Some(3),
        opacity: Some(0.75),
        transparency: Some(Transparency::Mask(0.125)),
        metallic: Some(1.0),
        ..StatedLook::default()
    };
    animation.materials = Some(materials);
    animation
}

pub(crate) fn options(textures: Option<TextureFiles>) -> Options {
    Options { textures, ..Options::default() }
}

/// The JSON and the binary part of a file.
fn parts(path: &Path) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(path).unwrap();
    if !bytes.starts_with(b"glTF") {
        let json: Value = serde_json::from_slice(&bytes).unwrap();
        let bin = path.with_file_name(json["buffers"][0]["uri"].as_str().unwrap());
        return (json, std::fs::read(bin).unwrap());
    }
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), bytes[28 + length..].to_vec())
}

/// The bytes of an image of the file.
fn bytes_of(path: &Path, image: &Value) -> Vec<u8> {
    let (json, bin) = parts(path);
    if let Some(uri) = image["uri"].as_str() {
        return std::fs::read(path.with_file_name(uri)).unwrap();
    }
    let view = &json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
    let begin = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    bin[begin..begin + view["byteLength"].as_u64().unwrap() as usize].to_vec()
}

/// Fails unless Rhytid's own comparison finds nothing.
pub(crate) fn assert_same(path: &Path, animation: &Animation) {
    let differences = animation::open(path).unwrap().compare(&animation.scene()).unwrap();
    assert_eq!(differences, [""; 0], "{}", path.display());
}

#[test]
fn textures_and_looks_are_in_the_file_or_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut files: Vec<PathBuf> = Vec::new();
    let animation = textured(UvKind::PerCorner);
    for (i, (extension, textures, beside)) in [
        ("glb", None, false),
        ("gltf", None, true),
        ("glb", Some(TextureFiles::Copy), true),
        ("gltf", Some(TextureFiles::Embed), false),
    ]
    .into_iter()
    .enumerate()
    {
        for meshopt in [false, true] {
            let path = folder.path().join(format!("{i}-{meshopt}.{extension}"));
            let written = animation.export_with(&path, &Options { meshopt, ..options(textures) }).unwrap();
            let (json, _) = parts(&path);
            let images = json["images"].as_array().unwrap();
            // The texture that two materials name is there once, and the one that nobody names is not.
            assert_eq!(images.len(), 2);
            for (image, expected) in images.iter().zip([1, 3]) {
                let expected = &animation.materials.as_ref().unwrap().textures[expected];
                assert_eq!(bytes_of(&path, image), *expected.bytes);
                assert_eq!(
                    (&image["mimeType"], &image["name"]),
                    (&json!("image/png"), &json!(expected.name))
                );
                assert_eq!(image["uri"].is_string(), beside);
            }
            let number = |x: &Value| x.as_f64().unwrap();
            let [skin, teeth, eye, without] = &json["materials"].as_array().unwrap()[..] else {
                panic!("{json}")
            };
            let of = |material: &Value| material["pbrMetallicRoughness"].clone();
            assert_eq!(of(skin)["baseColorTexture"]["index"], 0);
            assert_eq!(of(skin)["baseColorFactor"], json!([1.0, 1.0, 1.0, 1.0]));
            assert_eq!(number(&of(skin)["roughnessFactor"]), 0.25);
            assert_eq!(of(eye)["baseColorTexture"]["index"], 1);
            assert_eq!(of(eye)["baseColorFactor"], json!([0.5, 0.25, 1.0, 0.75]));
            assert_eq!((&eye["alphaMode"], number(&eye["alphaCutoff"])), (&json!("MASK"), 0.125));
            assert_eq!(number(&of(eye)["metallicFactor"]), 1.0);
            // What nobody stated says so.
            for (material, is_default) in [(skin, false), (teeth, true), (eye, false), (without, true)] {
                assert_eq!(material["extras"] == json!({ "defaultLook": true }), is_default, "{material}");
            }
            assert_ne!(of(teeth)["baseColorFactor"], of(without)["baseColorFactor"]);
            assert_same(&path, &animation);
            let stem = format!("{i}-{meshopt}.");
            let of_file = std::fs::read_dir(folder.path()).unwrap().map(Result::unwrap);
            let of_file = of_file.filter(|entry| entry.file_name().to_str().unwrap().starts_with(&stem));
            assert_eq!(written.bytes, of_file.map(|entry| entry.metadata().unwrap().len()).sum::<u64>());
            files.push(path);
        }
    }
    assert_valid(&files);
    assert_valid(&unfold(&files));
}

#[test]
fn textures_may_be_referred_to_or_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let animation = textured(UvKind::PerVertex);
    animation.export_with(&path, &options(Some(TextureFiles::Refer))).unwrap();
    let (json, _) = parts(&path);
    assert_eq!(json["images"][0]["uri"], "maps/skin%201.png");
    // It has no file that could be referred to.
    assert!(json["images"][1]["bufferView"].is_u64());
    assert_same(&path, &animation);

    let without_uvs = textured(UvKind::None);
    for (animation, options) in
        [(&animation, options(Some(TextureFiles::None))), (&without_uvs, Options::default())]
    {
        animation.export_with(&path, &options).unwrap();
        let (json, _) = parts(&path);
        assert_eq!((json.get("images"), json.get("textures")), (None, None));
        let eye = &json["materials"][2]["pbrMetallicRoughness"];
        // The colour and the opacity belong to the texture, so an eye's default colour stands for them.
        assert_eq!(eye["baseColorFactor"], json!([0.86, 0.83, 0.8, 1.0]));
        assert_same(&path, animation);
    }
}

#[test]
fn old_copies_go_and_changed_ones_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.gltf");
    let mut animation = textured(UvKind::PerVertex);
    let copies = || -> Vec<PathBuf> {
        let all = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
        all.filter(|path| path.extension().unwrap() == "png").collect()
    };
    animation.export_with(&path, &Options::default()).unwrap();
    let first = copies();
    assert_eq!(first.len(), 2);
    // Another image of the skin.
    let textures = &mut animation.materials.as_mut().unwrap().textures;
    for texture in &mut textures[1..3] {
        texture.bytes = picture([90, 60, 50, 255]).into();
    }
    animation.export_with(&path, &Options::default()).unwrap();
    assert_eq!(copies().len(), 2);
    assert_eq!(copies().iter().filter(|copy| first.contains(copy)).count(), 1);
    assert_same(&path, &animation);

    let (json, _) = parts(&path);
    let copy = path.with_file_name(json["images"][0]["uri"].as_str().unwrap());
    let found = || animation::open(&path).unwrap().compare(&animation.scene()).unwrap();
    std::fs::write(&copy, picture([0; 4])).unwrap();
    assert!(found()[0].contains("skin.png"), "{:?}", found());
    std::fs::remove_file(&copy).unwrap();
    assert!(found()[0].contains("skin.png"), "{:?}", found());
}

#[test]
fn as_a_mesh_it_has_the_neutrals_vertices_and_materials() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let case = Case {
        animation: textured(UvKind::PerVertex),
        options: Options::default(),
        extension: "glb",
        label: "mesh".into(),
    };
    case.animation.export_with(&path, &case.options).unwrap();
    let mesh = rhytid_formats::mesh::read(&path).unwrap();
    let first = case.animation.frames[0][0].as_chunks::<3>().0;
    assert_eq!(mesh.positions.len(), first.len());
    for (found, given) in mesh.positions.iter().zip(first) {
        for (found, given) in found.iter().zip(given) {
            // In metres.
            assert!((found - 0.01 * f64::from(*given)).abs() < 1e-6, "{found}, expected {given}");
        }
    }
    let materials = mesh.materials.as_ref().unwrap();
    let names: Vec<&str> =
        materials.of_face.iter().map(|&m| materials.names().nth(m as usize).unwrap()).collect();
    let given = case.animation.materials.as_ref().unwrap();
    let expected = case.corners().into_iter().map(|corners| {
        let material = given.of_face[case.face_of(corners[0])];
        given.names().nth(material as usize).unwrap_or("skin")
    });
    assert_eq!(names, expected.collect::<Vec<_>>());
}
