//! The looks of materials in USD, as USD's own library, Blender and Rhytid read them.

use super::common::{files_in, input_error, python, python_usd_24_3, root, run};
use super::usd_shapes::described;
use crate::animation::{Animation, UvKind};
use crate::gltf::textures::{assert_same, options, picture, textured};
use rhytid_core::{Material, Materials, NoProgress, Reach, Transparency};
use rhytid_formats::animation;
use rhytid_formats::export::{Options, Shape, TextureFiles};
use rhytid_formats::mesh::{read, read_looks};
use rhytid_test_support::{Logged, installed};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;

/// An animation whose materials have every kind of look: textures that are opaque, cut out and mixed, an
/// opacity without a texture, and defaults.
fn looks(uvs: UvKind) -> Animation {
    let mut animation = textured(uvs);
    let materials = animation.materials.as_mut().unwrap();
    for (name, stated) in [("glass: left", None), ("hair", Some(1))] {
        let mut material = Material::new(name);
        material.stated.opacity = Some(0.25);
        material.stated.texture = stated;
        let number = materials.list.len() as u32;
        materials.of_face[number as usize] = number;
        materials.list.push(material);
    }
    animation
}

/// What every face looks like, by the numbers of the library and not of the file.
fn expectation(animation: &Animation, with_textures: bool) -> Value {
    let materials = animation.materials.as_ref().unwrap();
    let faces: Vec<Value> = materials
        .of_face
        .iter()
        .map(|&index| {
            let material = materials.list.get(index as usize);
            let look = if with_textures { Material::look } else { Material::look_without_texture };
            let look = material.map_or(Materials::look_without(), look);
            json!({
                "name": material.map_or(if materials.list.is_empty() { "skin" } else { "skin_1" }, |material| &material.name),
                "color": look.base_color,
                "opacity": if look.transparency == Transparency::Opaque { 1.0 } else { look.opacity },
                "mixes": look.transparency != Transparency::Opaque,
                "cutoff": match look.transparency { Transparency::Mask(cutoff) => cutoff, _ => 0.0 },
                "roughness": look.roughness,
                "metallic": look.metallic,
                "default": look.is_default,
                "image": look.texture.map(|texture| &*materials.textures[texture as usize].bytes),
            })
        })
        .collect();
    json!(faces)
}

/// The files of one folder, each with what it should look like.
#[derive(Default)]
struct Cases(Vec<(PathBuf, Value)>);

impl Cases {
    fn check(&self, folder: &Path, python: &Path) {
        let list = folder.join("looks.json");
        let cases: Vec<Value> = self.0.iter().map(|(path, faces)| json!([path, faces])).collect();
        std::fs::write(&list, json!(cases).to_string()).unwrap();
        let script = root().join("crates/formats/tests/formats/export/usd_looks_check.py");
        let printed = run(Command::new(python).arg(script).arg(&list));
        assert!(printed.contains(&format!("{} files look as they should", self.0.len())), "{printed}");
    }
}

#[test]
fn usd_finds_every_look_and_every_image() {
    let folder = tempfile::tempdir().unwrap();
    let mut cases = Cases::default();
    for uvs in [UvKind::PerVertex, UvKind::PerCorner, UvKind::None] {
        let mut animation = looks(uvs);
        let has_uvs = animation.uvs.is_some();
        for (i, extension) in ["usd", "usda", "usdz"].into_iter().enumerate() {
            let path = folder.path().join(format!("Zoë {uvs:?}.{extension}"));
            let before = files_in(folder.path()).len();
            let written = animation.export(&path).unwrap();
            assert_same(&path, &animation);
            // `.usd` and `.usda` name the same two copies.
            let copies = if i == 0 && has_uvs { 2 } else { 0 };
            assert_eq!(files_in(folder.path()).len(), before + 1 + copies, "{extension}");
            let size = |name: &str| std::fs::metadata(folder.path().join(name)).unwrap().len();
            let is_of_file =
                |name: &String| name.starts_with(&format!("Zoë {uvs:?}.")) && name.ends_with("png");
            let beside = files_in(folder.path()).into_iter().filter(is_of_file);
            let beside: u64 = if extension == "usdz" { 0 } else { beside.map(|name| size(&name)).sum() };
            assert_eq!(written.bytes, std::fs::metadata(&path).unwrap().len() + beside);
            cases.0.push((path, expectation(&animation, has_uvs)));
            let without = folder.path().join(format!("without {uvs:?}.{extension}"));
            animation.export_with(&without, &options(Some(TextureFiles::None))).unwrap();
            assert_same(&without, &animation);
            cases.0.push((without, expectation(&animation, false)));
        }
        let shape = Shape {
            name: "smile".into(),
            offsets: vec![[0.5; 3]; animation.rest.len()],
            normal_offsets: None,
        };
        let of_rig = folder.path().join(format!("shapes {uvs:?}.usd"));
        animation::write_shapes(&of_rig, &described(&animation, &[shape]), &Options::default(), &NoProgress)
            .unwrap();
        cases.0.push((of_rig, expectation(&animation, has_uvs)));
        let baked = folder.path().join(format!("baked {uvs:?}.usdz"));
        animation.others.clear();
        animation.export_with(&baked, &Options { shapes: Some(2), ..Options::default() }).unwrap();
        assert_same(&baked, &animation);
        cases.0.push((baked, expectation(&animation, has_uvs)));
        // Nobody names a material: all is skin.
        let bare = folder.path().join(format!("bare {uvs:?}.usd"));
        animation.materials = None;
        animation.export(&bare).unwrap();
        assert_same(&bare, &animation);
        animation.materials = Some(Materials::named(["x"; 0], vec![Materials::NONE; animation.faces.len()]));
        cases.0.push((bare, expectation(&animation, false)));
    }
    cases.check(folder.path(), &python());
    cases.check(folder.path(), &python_usd_24_3());
}

#[test]
fn textures_may_be_the_originals() {
    let folder = tempfile::tempdir().unwrap();
    let animation = looks(UvKind::PerVertex);
    let materials = animation.materials.as_ref().unwrap();
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    std::fs::write(folder.path().join("maps/skin 1.png"), &materials.textures[1].bytes).unwrap();
    let path = folder.path().join("face.usda");
    let logged = Logged::start();
    animation.export_with(&path, &options(Some(TextureFiles::Refer))).unwrap();
    let lines = logged.lines();
    assert!(
        lines.iter().any(|line| line.contains("the texture eye.png has no file of its own")),
        "{lines:?}"
    );
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches("@./maps/skin 1.png@").count(), 2, "two materials have it");
    assert_eq!(files_in(folder.path()).iter().filter(|name| name.ends_with(".usd.png")).count(), 1);
    assert_same(&path, &animation);
    let mut cases = Cases::default();
    cases.0.push((path, expectation(&animation, true)));
    cases.check(folder.path(), &python());
}

#[test]
fn a_place_that_a_file_does_not_have_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let animation = looks(UvKind::PerVertex);
    for (name, files, expected) in [
        ("face.usd", TextureFiles::Embed, "only a package has textures inside it; write .usdz"),
        ("face.usdz", TextureFiles::Copy, "a USD package has its textures inside it"),
        ("face.usdz", TextureFiles::Refer, "a USD package has its textures inside it"),
    ] {
        for shapes in [None, Some(2)] {
            let options = Options { shapes, ..options(Some(files)) };
            let path = folder.path().join(name);
            let message = input_error(animation::create(&path, &animation.scene(), &options));
            assert!(message.contains(name) && message.contains(expected), "{message}");
        }
    }
    assert_eq!(files_in(folder.path()), [""; 0]);
    // Without textures, there is nothing to place.
    let plain = textured(UvKind::None);
    plain.export_with(&folder.path().join("face.usd"), &options(Some(TextureFiles::Embed))).unwrap();
}

#[test]
fn old_copies_go_and_those_of_gltf_stay() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut animation = looks(UvKind::PerVertex);
    for name in ["face.gltf", "face.usd", "face.usda"] {
        animation.export(&at(name)).unwrap();
    }
    let pictures = || -> Vec<String> {
        files_in(folder.path()).into_iter().filter(|name| name.ends_with(".png")).collect()
    };
    let first = pictures();
    assert_eq!(first.len(), 4);
    for texture in &mut animation.materials.as_mut().unwrap().textures[1..3] {
        texture.bytes = picture([90, 60, 50, 255]).into();
    }
    // The text still names the old image.
    animation.export(&at("face.usd")).unwrap();
    assert_eq!(pictures().len(), 5);
    animation.export(&at("face.usda")).unwrap();
    assert_eq!(pictures().len(), 4);
    animation.export(&at("face.gltf")).unwrap();
    assert_eq!(pictures().len(), 4);
    for name in ["face.gltf", "face.usd", "face.usda"] {
        assert_same(&at(name), &animation);
    }
    // An image that was painted over, or is gone, is noticed.
    let copy =
        pictures().into_iter().find(|name| name.ends_with(".usd.png") && !first.contains(name)).unwrap();
    let found = || animation::open(&at("face.usd")).unwrap().compare(&animation.scene()).unwrap();
    std::fs::write(at(&copy), picture([0; 4])).unwrap();
    assert!(found()[0].contains("inputs:file") && found()[0].contains("skin.png"), "{:?}", found());
    std::fs::remove_file(at(&copy)).unwrap();
    assert!(found()[0].contains("skin.png"), "{:?}", found());
}

#[test]
fn the_neutral_of_an_export_has_the_looks_that_were_exported() {
    let folder = tempfile::tempdir().unwrap();
    let animation = looks(UvKind::PerVertex);
    let expected = animation.materials.as_ref().unwrap();
    for extension in ["usd", "usda", "usdz"] {
        let path = folder.path().join(format!("face.{extension}"));
        animation.export(&path).unwrap();
        let mut mesh = read(&path).unwrap();
        let logged = Logged::start();
        read_looks(&path, Reach::Below).unwrap().give_to(mesh.materials.as_mut().unwrap());
        let lines = logged.lines();
        assert!(!lines.iter().any(|line| line.starts_with("WARN")), "{lines:?}");
        let found = mesh.materials.unwrap();
        for (face, (&index, &wanted)) in found.of_face.iter().zip(&expected.of_face).enumerate() {
            let found_material = &found.list[index as usize];
            let wanted = expected.list.get(wanted as usize);
            let name = wanted.map_or("skin_1", |material| &material.name);
            assert_eq!(found_material.name, name, "face {face}");
            let look = wanted.map_or(Materials::look_without(), Material::look);
            let found_look = found_material.look();
            let bytes = |materials: &Materials, texture: Option<u32>| {
                texture.map(|texture| materials.textures[texture as usize].bytes.clone())
            };
            assert_eq!(bytes(&found, found_look.texture), bytes(expected, look.texture), "face {face}");
            let mut wanted = look;
            (wanted.texture, wanted.is_default) = (found_look.texture, false);
            assert_eq!(found_look, wanted, "{extension}, face {face}, {name}");
        }
    }
}

#[test]
fn blender_shows_the_looks() {
    let folder = tempfile::tempdir().unwrap();
    let animation = looks(UvKind::PerCorner);
    let script = root().join("crates/formats/tests/formats/export/usd_looks_blender.py");
    for extension in ["usd", "usda", "usdz"] {
        let path = folder.path().join(format!("face.{extension}"));
        animation.export(&path).unwrap();
        let read = folder.path().join("read.json");
        run(Command::new(installed("venv-blender/bin/python")).arg(&script).arg(&path).arg(&read));
        let read: Value = serde_json::from_slice(&std::fs::read(&read).unwrap()).unwrap();
        let found = |name: &str| read.get(name).unwrap_or_else(|| panic!("{name} is not in {read}"));
        let close = |found: &Value, expected: f32, what: &str| {
            let off = (found.as_f64().unwrap() - f64::from(expected)).abs();
            assert!(off < 1e-6, "{extension} {what}: {found}, expected {expected}");
        };
        let materials = animation.materials.as_ref().unwrap();
        for (name, material) in [
            ("skin", materials.list.first()),
            ("teeth", materials.list.get(1)),
            ("Auge___links", materials.list.get(2)),
            ("glass__left", materials.list.get(3)),
            ("hair", materials.list.get(4)),
            ("skin_1", None),
        ] {
            let look = material.map_or(Materials::look_without(), Material::look);
            let found = found(name);
            close(&found["roughness"], look.roughness, name);
            close(&found["metallic"], look.metallic, name);
            let Some(texture) = look.texture else {
                for (c, expected) in look.base_color.into_iter().enumerate() {
                    close(&found["color"][c], expected, name);
                }
                close(&found["opacity"], look.opacity, name);
                assert_eq!(found["image"], Value::Null);
                continue;
            };
            // The pixel's bytes, which Blender has decoded from the file that it has found.
            let wanted = &materials.textures[texture as usize];
            let file = std::fs::read(found["image"]["file"].as_str().unwrap()).unwrap();
            assert_eq!(file, *wanted.bytes, "{extension} {name}");
            assert_eq!(found["image"]["size"], json!([2, 2]));
            assert_eq!(found["image"]["space"], "sRGB");
            let scale = [look.base_color[0], look.base_color[1], look.base_color[2]];
            if scale != [1.0; 3] {
                for (c, expected) in scale.into_iter().enumerate() {
                    close(&found["scale"][c], expected, name);
                }
            }
        }
    }
}
