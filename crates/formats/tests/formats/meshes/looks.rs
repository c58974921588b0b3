//! The looks of materials, as Blender and USD's own library read or write them.

use rhytid_core::{Materials, Mesh, Reach, StatedLook, TextureFormat, Tissue, Transparency};
use rhytid_formats::mesh::{Looks, read, read_looks};
use rhytid_test_support::{Logged, installed, python, root};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

const MTL: &str = "newmtl plain\nKd 0.5 0.25 0.125\nNs 250\nd 0.25\n\
    newmtl skin\nKd 0.1 0.2 0.3\nmap_Kd image.png\nNs 810\n\
    newmtl cut\nmap_Kd -clamp on image.png\nmap_d image.png\n\
    newmtl cloth\nPr 0.75\nPm 0.5\nKd 1 0 0\n";

/// A face for each of these materials.
fn obj(materials: &[&str]) -> String {
    let mut text = "mtllib looks.mtl\nvt 0 0\nvt 1 0\nvt 1 1\n".to_owned();
    for (i, material) in materials.iter().enumerate() {
        // Blender joins faces of the same vertices.
        text.push_str(&format!("v 0 0 {i}\nv 1 0 {i}\nv 1 1 {i}\nusemtl {material}\nf -3/1 -2/2 -1/3\n"));
    }
    text
}

/// A folder with what the script writes into it.
fn made(script: &str, python: &Path, files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let script = root().join("crates/formats/tests/formats/meshes").join(script);
    let output = Command::new(python).arg(script).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

fn blender() -> tempfile::TempDir {
    let obj = obj(&["plain", "skin", "cut", "cloth"]);
    let python = installed("venv-blender/bin/python");
    // Blender writes the image first, which the MTL names.
    made("looks_blender.py", &python, &[("looks.obj", obj.as_bytes()), ("looks.mtl", MTL.as_bytes())])
}

/// The mesh with its looks, and the warnings.
fn with_looks(path: &Path) -> (Mesh, Vec<String>) {
    let mut mesh = read(path).unwrap();
    let logged = Logged::start();
    read_looks(path, Reach::Below).unwrap().give_to(mesh.materials.as_mut().unwrap());
    assert_eq!(mesh.materials.as_ref().unwrap().fault(&mesh.faces), None);
    let lines = logged.lines();
    (mesh, lines.iter().filter_map(|line| line.strip_prefix("WARN ")).map(str::to_owned).collect())
}

fn stated<'a>(materials: &'a Materials, name: &str) -> &'a StatedLook {
    &materials.list.iter().find(|material| material.name == name).unwrap().stated
}

fn is_close(found: f32, expected: &Value) -> bool {
    (f64::from(found) - expected.as_f64().unwrap()).abs() < 1e-6
}

/// The pixels of a PNG as red, green, blue and alpha.
fn pixels(bytes: &[u8]) -> Vec<[u8; 4]> {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::ALPHA | png::Transformations::EXPAND);
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    assert_eq!(reader.next_frame(&mut pixels).unwrap().color_type, png::ColorType::Rgba);
    pixels.as_chunks().0.to_vec()
}

#[test]
fn an_mtl_is_as_blender_reads_it() {
    let folder = blender();
    let read: Value = serde_json::from_slice(&fs::read(folder.path().join("read.json")).unwrap()).unwrap();
    let (mesh, warnings) = with_looks(&folder.path().join("looks.obj"));
    assert!(warnings.is_empty(), "{warnings:?}");
    let materials = mesh.materials.unwrap();
    assert_eq!(materials.list.len(), 4);
    for material in &materials.list {
        let (look, stated) = (material.look(), &material.stated);
        let blender = &read[&material.name];
        let image = stated.texture.map(|texture| materials.textures[texture as usize].name.as_str());
        assert_eq!(image, blender["image"].as_str(), "{}", material.name);
        if image.is_none() {
            for (found, expected) in look.base_color.iter().zip(blender["color"].as_array().unwrap()) {
                assert!(is_close(*found, expected), "{}: {found}, {expected}", material.name);
            }
        } else {
            assert_eq!(look.base_color, [1.0; 3]);
        }
        assert!(is_close(look.opacity, &blender["opacity"]), "{}: {look:?}", material.name);
        let shows_alpha = !blender["opacity_image"].is_null();
        assert!(!shows_alpha || look.transparency == Transparency::Blend, "{}", material.name);
        if let Some(roughness) = stated.roughness {
            assert!(is_close(roughness, &blender["roughness"]), "{}: {roughness}", material.name);
        }
        if let Some(metallic) = stated.metallic {
            assert!(is_close(metallic, &blender["metallic"]), "{}: {metallic}", material.name);
        }
        assert!(!look.is_default);
    }
    assert!(
        stated(&materials, "plain").roughness.is_some() && stated(&materials, "cloth").metallic.is_some()
    );
    // The image is the file's, and its alpha counts only where the MTL says so.
    assert_eq!(materials.textures.len(), 1);
    assert_eq!(*materials.textures[0].bytes, *fs::read(folder.path().join("image.png")).unwrap());
    assert_eq!(materials.textures[0].path.as_deref(), Some("image.png"));
    assert_eq!(materials.textures[0].size(), Some([4, 2]));
    assert_eq!(stated(&materials, "skin").transparency, Some(Transparency::Opaque));
}

#[test]
fn images_of_other_formats_become_png_or_a_warning() {
    let folder = blender();
    fs::write(folder.path().join("looks.obj"), obj(&["skin"])).unwrap();
    let of_png = pixels(&fs::read(folder.path().join("image.png")).unwrap());
    for (file, has_alpha) in
        [("image.tga", true), ("image.bmp", false), ("image.tif", true), ("image.webp", true)]
    {
        fs::write(folder.path().join("looks.mtl"), format!("newmtl skin\nmap_Kd {file}\n")).unwrap();
        let (mesh, warnings) = with_looks(&folder.path().join("looks.obj"));
        assert!(warnings.is_empty(), "{file}: {warnings:?}");
        let textures = mesh.materials.unwrap().textures;
        assert_eq!(textures[0].name, "image.png");
        assert_eq!((textures[0].format(), textures[0].path.as_deref()), (Some(TextureFormat::Png), None));
        for (found, expected) in pixels(&textures[0].bytes).iter().zip(&of_png) {
            // Without an alpha, Blender shows the image before black.
            let [.., opacity] = *expected;
            let before_black = |part: u8| (u16::from(part) * u16::from(opacity) / 255) as u8;
            let expected = match has_alpha {
                true => *expected,
                false => {
                    [before_black(expected[0]), before_black(expected[1]), before_black(expected[2]), 255]
                }
            };
            // WebP loses a little.
            for (found, expected) in found.iter().zip(expected) {
                assert!(found.abs_diff(expected) < 24, "{file}: {found}, {expected}");
            }
        }
    }
    let jpeg = fs::read(folder.path().join("image.jpg")).unwrap();
    fs::write(folder.path().join("looks.mtl"), "newmtl skin\nmap_Kd image.jpg\n").unwrap();
    let (mesh, _) = with_looks(&folder.path().join("looks.obj"));
    let textures = mesh.materials.unwrap().textures;
    assert_eq!((textures[0].name.as_str(), textures[0].size()), ("image.jpg", Some([4, 2])));
    assert_eq!(*textures[0].bytes, *jpeg);

    fs::write(folder.path().join("noise.png"), "no image").unwrap();
    fs::write(folder.path().join("cut.png"), &fs::read(folder.path().join("image.png")).unwrap()[..20])
        .unwrap();
    fs::write(folder.path().join("image.dds"), b"DDS |\0\0\0").unwrap();
    for (file, words) in [
        ("image.exr", "is an OpenEXR file, which cannot be read, so it is left out; save it as PNG or JPEG"),
        ("image.dds", "is a DDS file"),
        ("noise.png", "is of no known format"),
        ("cut.png", "cannot be read"),
        ("skin.<UDIM>.png", "tiles (skin.<UDIM>.png), which cannot be read, so it is without them; bake"),
        ("not-there.png", "material \"skin\" is without its image"),
        ("../outside.png", "is not in"),
        ("-s 2 2 2 image.png", "moved or scaled"),
    ] {
        fs::write(folder.path().join("looks.mtl"), format!("newmtl skin\nKd 0 1 0\nmap_Kd {file}\n"))
            .unwrap();
        let (mesh, warnings) = with_looks(&folder.path().join("looks.obj"));
        assert!(warnings.len() == 1 && warnings[0].contains(words), "{file}: {warnings:?}");
        // The colour is still there.
        let materials = mesh.materials.unwrap();
        let is_left_out = stated(&materials, "skin").texture.is_none();
        assert_eq!(is_left_out, !file.ends_with(" image.png"), "{file}");
        assert!(!is_left_out || stated(&materials, "skin").base_color == Some([0.0, 1.0, 0.0]), "{file}");
    }
    fs::remove_file(folder.path().join("looks.mtl")).unwrap();
    let (mesh, warnings) = with_looks(&folder.path().join("looks.obj"));
    assert!(warnings.len() == 1 && warnings[0].contains("looks.mtl"), "{warnings:?}");
    assert!(warnings[0].contains("default looks; put"), "{warnings:?}");
    assert!(mesh.materials.unwrap().list.iter().all(|material| material.look().is_default));
}

/// Photoshop writes JPEGs of four inks, which glTF and most programs do not know.
#[test]
fn inks_become_colours() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("looks.obj"), obj(&["skin"])).unwrap();
    fs::write(folder.path().join("looks.mtl"), "newmtl skin\nmap_Kd inks.jpg\n").unwrap();
    // Quarters of one colour each, written by Pillow with Adobe's mark: inks are inverted.
    let inks = root().join("crates/formats/tests/formats/meshes/inks.jpg");
    fs::copy(inks, folder.path().join("inks.jpg")).unwrap();
    let (mesh, warnings) = with_looks(&folder.path().join("looks.obj"));
    assert!(warnings.is_empty(), "{warnings:?}");
    let textures = mesh.materials.unwrap().textures;
    assert_eq!((textures[0].name.as_str(), textures[0].format()), ("inks.png", Some(TextureFormat::Png)));
    let found = pixels(&textures[0].bytes);
    for (quarter, inks) in
        [[0, 180, 200, 10], [200, 20, 0, 0], [0, 0, 0, 255], [30, 40, 60, 0]].iter().enumerate()
    {
        let at = 16 * (8 * (quarter / 2) + 4) + 8 * (quarter % 2) + 4;
        for c in 0..3 {
            let expected = (255 - inks[c]) * (255 - inks[3]) / 255;
            let off = (i32::from(found[at][c]) - expected).abs();
            assert!(off <= 6, "quarter {quarter}: {:?}, {inks:?}", found[at]);
        }
    }
}

/// A material that the MTL lacks has a default look, which is likely a mistake.
#[test]
fn materials_that_no_mtl_states_are_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let warned = |materials: &[&str], mtl: &str| {
        fs::write(folder.path().join("looks.obj"), obj(materials)).unwrap();
        fs::write(folder.path().join("looks.mtl"), mtl).unwrap();
        with_looks(&folder.path().join("looks.obj")).1
    };
    assert!(warned(&["a", "b", "a"], "newmtl a\nKd 1 0 0\nnewmtl b\n").is_empty());
    let [said] = &warned(&["a", "b", "a"], "newmtl a\nKd 1 0 0\n")[..] else { panic!() };
    assert!(said.contains("the material \"b\" is in none of its files of materials"), "{said}");
    let [said] = &warned(&["c", "b", "a"], "newmtl d\n")[..] else { panic!() };
    assert!(said.contains("the material \"a\" (and 2 more) is in none"), "{said}");
    // A mesh that names no MTL has the looks that were meant.
    fs::write(folder.path().join("looks.obj"), obj(&["b"]).replace("mtllib", "#")).unwrap();
    assert!(with_looks(&folder.path().join("looks.obj")).1.is_empty());
}

#[test]
fn a_gltf_of_blender_has_the_looks_of_its_obj() {
    let folder = blender();
    for (file, path) in [("packed.glb", None), ("beside.gltf", Some("maps/image.png"))] {
        let (mesh, warnings) = with_looks(&folder.path().join(file));
        assert!(warnings.is_empty(), "{file}: {warnings:?}");
        let materials = mesh.materials.unwrap();
        let plain = stated(&materials, "plain");
        assert_eq!(plain.base_color, Some([0.5, 0.25, 0.125]), "{file}");
        assert_eq!((plain.opacity, plain.transparency), (Some(0.25), Some(Transparency::Blend)), "{file}");
        assert_eq!((plain.roughness, plain.metallic), (Some(0.5), Some(0.0)), "{file}");
        let skin = stated(&materials, "skin");
        let texture = &materials.textures[skin.texture.unwrap() as usize];
        assert_eq!((texture.name.as_str(), texture.path.as_deref()), ("image.png", path), "{file}");
        assert_eq!(texture.size(), Some([4, 2]));
        assert_eq!(skin.transparency, Some(Transparency::Opaque));
        assert_eq!(stated(&materials, "cloth").base_color, Some([1.0, 0.0, 0.0]));
    }
}

#[test]
fn the_looks_of_a_gltf_are_those_of_its_factors() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("face.gltf");
    let document = serde_json::json!({"asset": {"version": "2.0"}, "materials": [
        {"name": "named"},
        {"name": "mask", "alphaMode": "MASK"},
        {"alphaMode": "MASK", "alphaCutoff": 0.25},
        {"name": "metal", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 0.5], "roughnessFactor": 0.25}},
        {"name": "maps", "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}},
        {"name": "lost", "pbrMetallicRoughness": {"baseColorTexture": {"index": 7}}}
    ]});
    fs::write(&at, document.to_string()).unwrap();
    let logged = Logged::start();
    let Looks { materials, textures } = read_looks(&at, Reach::Below).unwrap();
    assert!(textures.is_empty());
    let names: Vec<&str> = materials.iter().map(|material| material.name.as_str()).collect();
    // A name alone says nothing of the look. What has a look and no name is called after its number.
    assert_eq!(names, ["mask", "material-2", "metal", "maps", "lost"]);
    let [mask, numbered, metal, maps, _] = &materials[..] else { panic!("{names:?}") };
    assert_eq!(mask.stated.transparency, Some(Transparency::Mask(0.5)));
    assert_eq!(numbered.stated.transparency, Some(Transparency::Mask(0.25)));
    let expected = StatedLook {
        base_color: Some([0.5; 3]),
        texture: None,
        opacity: Some(0.5),
        transparency: Some(Transparency::Opaque),
        roughness: Some(0.25),
        metallic: Some(1.0),
    };
    assert_eq!(metal.stated, expected);
    // Factors of an image that is not read would make a face of metal.
    assert_eq!((maps.stated.roughness, maps.stated.metallic), (None, None));
    let warnings = logged.lines();
    assert!(warnings.iter().any(|line| line.contains("the texture of the material \"lost\" does not exist")));
}

#[test]
fn the_looks_of_usd_are_those_of_its_preview_surface() {
    let folder = blender();
    let png = fs::read(folder.path().join("image.png")).unwrap();
    // A mask of another size: 0 on the left, 255 on the right.
    let mut mask = Vec::new();
    let mut encoder = png::Encoder::new(&mut mask, 2, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[0, 255]).unwrap();
    let folder = made("looks_usd.py", &python(), &[("image.png", &png), ("mask.png", &mask)]);
    for file in ["looks.usda", "looks.usdc", "looks.usdz"] {
        let (mesh, warnings) = with_looks(&folder.path().join(file));
        assert!(warnings.is_empty(), "{file}: {warnings:?}");
        let materials = mesh.materials.unwrap();
        let names: Vec<&str> = materials.names().collect();
        assert_eq!(names, ["plain", "textured", "cut", "masked", "empty"], "{file}");
        let plain = StatedLook {
            base_color: Some([0.5, 0.25, 0.125]),
            texture: None,
            opacity: Some(0.5),
            transparency: Some(Transparency::Blend),
            roughness: Some(0.25),
            metallic: Some(0.75),
        };
        assert_eq!(*stated(&materials, "plain"), plain, "{file}");
        assert_eq!(*stated(&materials, "empty"), StatedLook::default(), "{file}");
        let texture = |name: &str| &materials.textures[stated(&materials, name).texture.unwrap() as usize];
        assert_eq!(texture("textured").name, "image.png");
        assert_eq!(*texture("textured").bytes, *png, "{file}");
        assert_eq!(texture("textured").path.is_some(), file != "looks.usdz");
        assert_eq!(stated(&materials, "textured").transparency, Some(Transparency::Opaque));
        assert_eq!(stated(&materials, "cut").texture, stated(&materials, "textured").texture);
        assert_eq!(stated(&materials, "cut").transparency, Some(Transparency::Mask(0.75)));
        assert_eq!(stated(&materials, "masked").transparency, Some(Transparency::Blend));
        for (combined, original) in pixels(&texture("masked").bytes).chunks(4).zip(pixels(&png).chunks(4)) {
            for (x, (combined, original)) in combined.iter().zip(original).enumerate() {
                assert_eq!(combined[..3], original[..3], "{file}");
                assert_eq!(combined[3], if x < 2 { 0 } else { 255 }, "{file}");
            }
        }
    }
}

#[test]
fn names_tell_tissues_apart() {
    for (name, tissue) in [
        ("M_EyeLashes", Some(Tissue::Hair)),
        ("eyebrow001", Some(Tissue::Hair)),
        ("Std_Cornea_L", Some(Tissue::Clear)),
        ("M_LacrimalFluid", Some(Tissue::Clear)),
        ("M_EyeOcclusion", Some(Tissue::Clear)),
        ("M_IrisLeft", Some(Tissue::Iris)),
        ("brown_eyes", Some(Tissue::Eye)),
        ("ScleraRight", Some(Tissue::Eye)),
        ("M_GumsTongue", Some(Tissue::Mouth)),
        ("upper teeth", Some(Tissue::Teeth)),
        ("eyelids", Some(Tissue::Skin)),
        ("Std_Skin_Head", Some(Tissue::Skin)),
        ("lambert1", None),
    ] {
        assert_eq!(Tissue::of_name(name), tissue, "{name}");
    }
}

#[test]
fn files_that_are_cut_short_never_panic() {
    let blender = blender();
    let png = fs::read(blender.path().join("image.png")).unwrap();
    let usd = made("looks_usd.py", &python(), &[("image.png", &png), ("mask.png", &png)]);
    let folder = tempfile::tempdir().unwrap();
    for from in [
        blender.path().join("packed.glb"),
        usd.path().join("looks.usdz"),
        usd.path().join("looks.usda"),
        blender.path().join("image.tga"),
        blender.path().join("image.tif"),
        blender.path().join("image.webp"),
        blender.path().join("image.bmp"),
    ] {
        let bytes = fs::read(&from).unwrap();
        let cut = folder.path().join(from.file_name().unwrap());
        let is_image = from.file_stem().unwrap() == "image";
        let mtl = folder.path().join("cut.mtl");
        fs::write(&mtl, format!("newmtl a\nmap_Kd {}\nmap_d {0}\n", cut.file_name().unwrap().display()))
            .unwrap();
        for length in (0..bytes.len()).step_by(1 + bytes.len() / 97) {
            fs::write(&cut, &bytes[..length]).unwrap();
            // Images that are cut may be left out; files that are cut may be errors.
            let read = read_looks(if is_image { &mtl } else { &cut }, Reach::Below);
            assert!(!is_image || read.is_ok());
        }
    }
}
