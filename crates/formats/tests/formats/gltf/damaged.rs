//! Files that are cut, swapped or changed.

use super::cases::{animation, cases, head};
use super::tools::{bin_beside, input_error};
use crate::animation::{Random, UvKind};
use rhytid_core::Error;
use rhytid_formats::animation;
use rhytid_formats::export::Options;
use std::path::Path;

/// Reads all of a file; never panics.
fn read(path: &Path) -> rhytid_core::Result<()> {
    let mut reader = animation::open(path)?;
    let mut out = Vec::new();
    for k in 0..reader.summary().frames.min(8) {
        reader.positions(k, &mut out)?;
        for channel in reader.summary().channels.clone() {
            reader.channel(&channel, k, &mut out)?;
        }
        reader.head(k)?;
    }
    Ok(())
}

#[test]
fn cut_and_swapped_files_give_clear_errors() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let plain = Options::default();
    animation(UvKind::None, 3, 50).export_with(&at("a.glb"), &plain).unwrap();
    animation(UvKind::None, 3, 51).export_with(&at("a.gltf"), &plain).unwrap();
    animation(UvKind::PerCorner, 2, 52).export_with(&at("b.gltf"), &plain).unwrap();
    let bytes = std::fs::read(at("a.glb")).unwrap();
    let refused = |name: &str, expected: &str| {
        let message = input_error(read(&at(name)));
        assert!(message.contains(name.split('.').next().unwrap()) && message.contains(expected), "{message}");
    };

    std::fs::write(at("cut.glb"), &bytes[..bytes.len() - 100]).unwrap();
    refused("cut.glb", "expected the");
    std::fs::write(at("cut.glb"), &bytes[..7]).unwrap();
    refused("cut.glb", "cut short");
    std::fs::write(at("long.glb"), [&bytes[..], &[0; 5]].concat()).unwrap();
    refused("long.glb", "expected the");
    std::fs::write(at("empty.glb"), "").unwrap();
    refused("empty.glb", "JSON");
    std::fs::write(at("usd.glb"), "PXR-USDC and more").unwrap();
    refused("usd.glb", "JSON");

    let [a, b] = ["a.gltf", "b.gltf"].map(|name| bin_beside(&at(name)));
    let bin = std::fs::read(&a).unwrap();
    std::fs::write(&a, &bin[..bin.len() - 4]).unwrap();
    refused("a.gltf", "cut short");
    // Another file's numbers.
    std::fs::copy(&b, &a).unwrap();
    assert!(matches!(read(&at("a.gltf")), Err(Error::Input(_))));
    std::fs::remove_file(&a).unwrap();
    refused("a.gltf", "does not exist");

    let json = std::fs::read_to_string(at("b.gltf")).unwrap();
    for uri in ["../b.bin", "/etc/hostname", "https://example.com/b.bin", "data:,x", "..", ""] {
        let name = b.file_name().unwrap().to_str().unwrap();
        assert!(json.contains(name));
        std::fs::write(at("c.gltf"), json.replace(name, uri)).unwrap();
        refused("c.gltf", "expected a file beside it");
    }
    assert!(matches!(animation::open(&at("none.glb")), Err(Error::Io { .. })));
}

#[test]
fn files_that_say_something_else_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.gltf");
    let mut animation = animation(UvKind::PerCorner, 3, 53);
    animation.head = Some(head(3));
    animation.export_with(&path, &Options { quantize: true, ..Options::default() }).unwrap();
    let json = std::fs::read_to_string(&path).unwrap();
    read(&path).unwrap();
    for (from, to, expected) in [
        ("\"frames\":3", "\"frames\":0", "0 frames"),
        ("\"frames\":3", "\"frames\":4", "3 times for 4 frames"),
        ("\"frames\":3", "\"frames\":99999999999999", "frames"),
        ("\"framesPerSecond\":30.0", "\"framesPerSecond\":31.0", "frame 1 (from 0) is at"),
        ("\"framesPerSecond\":30.0", "\"framesPerSecond\":-1.0", "above 0"),
        ("\"metresPerUnit\":0.01", "\"metresPerUnit\":0", "above 0"),
        ("\"upAxis\":\"Y\"", "\"upAxis\":\"X\"", "Rhytid has written"),
        ("\"vertices\":34", "\"vertex\":34", "which of them are copies"),
        ("\"vertices\":34", "\"vertices\":35", "expected the 35"),
        ("\"vertices\":34", "\"vertices\":18446744073709551615", "expected the"),
        ("\"copies\":[", "\"copies\":[34,", "expected the 34"),
        ("KHR_mesh_quantization", "KHR_draco_mesh_compression", "KHR_draco_mesh_compression"),
        ("\"LINEAR\"", "\"STEP\"", "Rhytid has written"),
        ("\"path\":\"rotation\"", "\"path\":\"scale\"", "Rhytid has written"),
        ("\"byteLength\":", "\"byteLength\":9", "damaged"),
        ("\"byteOffset\":", "\"byteOffset\":9", "damaged"),
        ("\"count\":", "\"count\":9", "damaged"),
        ("\"VEC3\"", "\"VEC2\"", "damaged"),
        ("\"componentType\":5122", "\"componentType\":5130", "damaged"),
    ] {
        assert!(json.contains(from), "{from}: {json}");
        std::fs::write(&path, json.replace(from, to)).unwrap();
        let message = input_error(read(&path));
        assert!(message.contains(expected), "{to}: “{message}” lacks “{expected}”");
    }
}

#[test]
fn copies_that_part_from_their_vertex_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    animation(UvKind::PerCorner, 2, 54).export_with(&path, &Options::default()).unwrap();
    let viewer = super::viewer::Viewer::open(&path);
    let mut bytes = std::fs::read(&path).unwrap();
    // The last position of the last target is that of a copy.
    let target = viewer.document.meshes().next().unwrap().primitives().next().unwrap().morph_targets().last();
    let view = target.unwrap().positions().unwrap().view().unwrap();
    let end = bytes.len() - viewer.bin.len() + view.offset() + view.length();
    bytes[end - 4..end].copy_from_slice(&5_f32.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    let message = input_error(read(&path));
    assert!(message.contains("in frame 1 (from 0)") && message.contains("copy"), "{message}");
}

#[test]
fn changed_bytes_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(55);
    let (mut refused, mut tried) = (0, 0);
    for case in cases().iter().filter(|case| case.extension == "glb") {
        let (path, _) = case.export(folder.path());
        let bytes = std::fs::read(&path).unwrap();
        let json = 20 + u64::from(u32::from_le_bytes(bytes[12..16].try_into().unwrap()));
        for _ in 0..30 {
            let mut changed = bytes.clone();
            for _ in 0..=random.below(3) {
                // As often in the JSON as behind it.
                let at = match random.below(2) {
                    0 => random.below(json),
                    _ => json + random.below(bytes.len() as u64 - json),
                };
                changed[at as usize] = match random.below(3) {
                    0 => random.bits() as u8,
                    1 => b"0123456789"[random.below(10) as usize],
                    _ => changed[at as usize] ^ (1 << random.below(8)),
                };
            }
            std::fs::write(&path, &changed).unwrap();
            tried += 1;
            match read(&path) {
                Ok(()) => {}
                Err(Error::Input(_)) => refused += 1,
                Err(other) => panic!("{}: {other}", case.label),
            }
        }
    }
    assert!(refused * 3 > tried, "{refused} of {tried} were refused");
}
