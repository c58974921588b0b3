//! Where the face is in a USD layer, layers that go over another, and text as three.js reads it.

use super::common::{input_error, python, python_usd_24_3, root, run};
use crate::animation::{Animation, UvKind, animation, with_everything};
use rhytid_core::channel;
use rhytid_formats::animation;
use rhytid_formats::export::{Options, Subdivision};
use rhytid_formats::usd;
use rhytid_test_support::installed;
use serde_json::json;
use std::path::Path;
use std::process::Command;

fn at(path: Option<&str>, over: bool) -> Options {
    Options { prim_path: path.map(|path| path.parse().unwrap()), over, ..Options::default() }
}

/// Fails unless Rhytid's own comparison finds nothing.
fn assert_same(path: &Path, animation: &Animation) {
    let mut reader = animation::open(path).unwrap();
    assert_eq!(reader.compare(&animation.scene()).unwrap(), [""; 0], "{}", path.display());
    let mut out = Vec::new();
    reader.positions(1, &mut out).unwrap();
    assert_eq!(out, animation.frames[1][0]);
    let head = animation.head.as_ref().map(|head| head[1].matrix());
    assert_eq!((reader.head(1).unwrap(), &reader.summary().recipe), (head, &Some(animation.recipe.clone())));
}

/// USD plays what lies over an asset as it plays the whole export.
fn check(python: &Path) {
    let folder = tempfile::tempdir().unwrap();
    let mut cases = Vec::new();
    let full = with_everything(UvKind::PerCorner, 5, 71);
    for (i, path) in [None, Some("/char/anna/face")].into_iter().enumerate() {
        for (asset_extension, extension) in [("usd", "usda"), ("usda", "usdc")] {
            let name = |what: &str, extension: &str| folder.path().join(format!("{what}{i}.{extension}"));
            // An asset with other frames, as from another take.
            let asset = name("asset", asset_extension);
            let mut other = animation(UvKind::PerCorner, 2, 72);
            (other.faces, other.triangle_corners) = (full.faces.clone(), full.triangle_corners.clone());
            (other.uvs, other.materials) = (full.uvs.clone(), full.materials.clone());
            other.rest.clone_from(&full.rest);
            other.export_with(&asset, &at(path, false)).unwrap();
            let whole = name("whole", extension);
            full.export_with(&whole, &at(path, false)).unwrap();
            let over = name("over", extension);
            full.export_with(&over, &at(path, true)).unwrap();
            assert_same(&whole, &full);
            assert_same(&over, &full);
            cases.push(json!([asset, whole, over, path.unwrap_or("/face")]));
        }
    }
    let list = folder.path().join("cases.json");
    std::fs::write(&list, json!(cases).to_string()).unwrap();
    let script = root().join("crates/formats/tests/formats/export/usd_place_check.py");
    let printed = run(Command::new(python).arg(script).arg(&list));
    assert!(printed.contains("4 layers over assets play as the whole"), "{printed}");
}

#[test]
fn a_layer_over_an_asset_plays_as_the_whole_export() {
    check(&python());
}

#[test]
fn the_oldest_usd_plays_a_layer_over_an_asset_too() {
    check(&python_usd_24_3());
}

#[test]
fn a_smooth_mesh_and_a_mesh_of_another_name_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.usda");
    let made = with_everything(UvKind::PerVertex, 3, 73);
    let options = Options {
        subdivision: Subdivision::CatmullClark,
        mesh_name: Some("head_geo".into()),
        ..at(Some("/char/face"), false)
    };
    made.export_with(&path, &options).unwrap();
    assert_same(&path, &made);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.contains("token subdivisionScheme = \"catmullClark\"") && text.contains("def Mesh \"head_geo\"")
    );
    // Another scheme is none that an export writes.
    std::fs::write(&path, text.replace("catmullClark", "loop")).unwrap();
    let found = animation::open(&path).unwrap().compare(&made.scene()).unwrap();
    assert!(found.len() == 1 && found[0].contains("subdivisionScheme"), "{found:?}");
}

#[test]
fn in_metres_the_points_keep_every_bit_and_the_size_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let made = with_everything(UvKind::PerVertex, 3, 76);
    for (i, shapes) in [None, Some(2)].into_iter().enumerate() {
        let mut made = made.clone();
        if shapes.is_some() {
            made.others.clear();
        }
        let [plain, scaled, over] =
            ["plain", "metres", "over"].map(|name| folder.path().join(format!("{name}{i}.usd")));
        made.export_with(&plain, &Options { shapes, ..Options::default() }).unwrap();
        made.export_with(&scaled, &Options { shapes, metres: true, ..Options::default() }).unwrap();
        let mut reader = animation::open(&scaled).unwrap();
        assert_eq!(reader.compare(&made.scene()).unwrap(), [""; 0]);
        assert_eq!(reader.summary().metres_per_unit, made.metres_per_unit);
        if shapes.is_none() {
            made.export_with(&over, &Options { over: true, metres: true, ..Options::default() }).unwrap();
            assert_same(&scaled, &made);
            assert_same(&over, &made);
        }
        let script = root().join("crates/formats/tests/formats/export/usd_metres_check.py");
        let printed = run(Command::new(python()).arg(script).args([plain, scaled]));
        assert!(printed.contains("3 frames have the same size in metres"), "{printed}");
    }
}

#[test]
fn what_a_layer_over_another_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let made = animation(UvKind::None, 3, 74);
    let path = folder.path().join("face.usd");
    let both = Options { shapes: Some(2), ..at(None, true) };
    let message = input_error(animation::create(&path, &made.scene(), &both));
    assert!(message.contains("face.usd: a layer over another has samples alone"), "{message}");
    let named = Options { mesh_name: Some("2nd mesh".into()), ..Options::default() };
    let message = input_error(animation::create(&path, &made.scene(), &named));
    assert!(message.contains("the mesh is to be called “2nd mesh”, expected ASCII"), "{message}");
    made.export_with(&path, &at(None, true)).unwrap();
    let message = input_error(usd::stitch(&[path], &folder.path().join("whole.usd")));
    assert!(message.contains("face.usd: holds samples for a mesh in another file"), "{message}");
}

#[test]
fn three_js_reads_the_text_as_it_reads_the_binary() {
    let folder = tempfile::tempdir().unwrap();
    let mut made = with_everything(UvKind::PerCorner, 3, 75);
    // It fails on attributes with a colon in their name, metadata and no value at rest.
    made.others.retain(|other| other.channel.name == channel::VELOCITIES.name);
    // It takes the head's first pose from binary files alone.
    made.head = None;
    let files = ["face.usda", "face.usdc"].map(|name| folder.path().join(name));
    for file in &files {
        made.export(file).unwrap();
    }
    let script = root().join("crates/formats/tests/formats/export/usd_three.mjs");
    let printed = run(Command::new("node").arg(script).arg(installed("node/node_modules")).args(&files));
    let read: Vec<serde_json::Value> =
        printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(read.len(), 2, "{printed}");
    for read in &read {
        // Each triangle has its own corners there, in metres.
        let corners: usize = made.faces.counts.iter().map(|&count| 3 * (count as usize - 2)).sum();
        assert_eq!(read["corners"], corners);
        // It shows the mesh at rest or the first frame.
        let shows = |pose: &[f32]| {
            [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)].into_iter().all(|(c, ends)| {
                (0..3).all(|axis| {
                    let used = made.faces.indices.iter().map(|&v| pose[3 * v as usize + axis]);
                    let expected = f64::from(used.reduce(ends).unwrap()) * made.metres_per_unit;
                    (read[c][axis].as_f64().unwrap() - expected).abs() < 1e-6
                })
            })
        };
        assert!(shows(made.rest.as_flattened()) || shows(&made.frames[0][0]), "{read}");
        assert!(read["materials"].as_array().unwrap().contains(&json!([0.85, 0.56, 0.44])), "{read}");
    }
}
