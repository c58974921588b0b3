//! Principal strains in files, compared with those that a script computes from the triangles in another way.

use super::animation::Animation;
use super::programs::Shown;
use super::{faces, original, programs};
use serde_json::{Value, json};
use std::path::Path;

/// Both sides compute strains in 64 bits and store them in 32.
const ROUNDING: f64 = 1e-6;

/// The sine of the largest angle between directions.
const DIRECTION: f64 = 1e-3;

/// The triangles of an animation's mesh, for the script.
fn triangles(animation: &Animation, folder: &Path) -> Value {
    let path = folder.join(format!("{}.triangles", animation.rig.surface().name));
    let numbers = animation.rig.surface().triangles.as_flattened();
    std::fs::write(&path, numbers.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    json!(path)
}

/// Asserts that the script's errors are at most `within`, and that it had something to compare.
fn assert_found(what: &str, animation: &Animation, found: &Value, within: f64) {
    let number = |name: &str| found[name].as_f64().unwrap();
    let (largest, worst, direction) = (number("largest"), number("worst"), number("worst_direction"));
    eprintln!("{what}: strains up to {largest:.3}, off by {worst:.1e}, directions by {direction:.1e}");
    assert_eq!(found["frames"], json!(animation.frames.count), "{what}");
    assert!(largest > 0.1, "{what}: strains of {largest} at most");
    assert!(worst <= within, "{what}: strains are off by {worst}");
    assert!(direction <= DIRECTION, "{what}: directions are off by {direction}");
}

#[test]
fn usd_has_the_strains_of_the_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let made = [faces::demo(), faces::other_axes_and_units()]
        .map(|animation| (animation, &["usd", "usda", "usdz"][..]));
    let all: Vec<_> = made.into_iter().chain(faces::real_head().map(|head| (head, &["usd"][..]))).collect();
    let mut cases = Vec::new();
    for (animation, extensions) in &all {
        let triangles = triangles(animation, folder.path());
        for extension in *extensions {
            let file = animation.export(&format!("strained.{extension}"), "--strain");
            cases.push((*animation, file.clone(), json!({ "usd": file, "triangles": triangles })));
        }
    }
    let found = programs::strain(cases.iter().map(|case| case.2.clone()).collect());
    for ((animation, file, _), found) in cases.iter().zip(&found) {
        assert_found(&file.display().to_string(), animation, found, ROUNDING);
    }
}

/// The first two shown strains of each of the original's vertices, in every frame. A vertex of no face, which
/// a glTF file has too, is at 0.
fn shown_strains(animation: &Animation, shown: &Shown) -> Vec<f64> {
    let vertices = animation.rig.vertices();
    let mut strains = vec![0.0; animation.frames.count * vertices * 2];
    for (frame, of_frame) in shown.strains.as_ref().expect("strains").iter().enumerate() {
        for (v, &[first, second, area]) in original(shown).zip(of_frame) {
            let expected = (1.0 + first) * (1.0 + second) - 1.0;
            // Strains that are fitted to few targets have an error of their own for each number.
            assert!(
                shown.stated_strain.is_some() || (area - expected).abs() < 1e-5,
                "{area}, expected {expected}"
            );
            strains[2 * (frame * vertices + v)..][..2].copy_from_slice(&[first, second]);
        }
    }
    strains
}

#[test]
fn three_js_has_the_strains_of_the_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let exports = [
        ("strained.glb", "--strain"),
        ("strained-integers.glb", "--strain --quantize"),
        ("strained-few.glb", "--strain --compressed --max-error 0.02"),
        ("strained-small.gltf", "--strain --shapes 12 --quantize --meshopt"),
    ];
    let write = |name: &str, bytes: Vec<u8>| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        json!(path)
    };
    let floats = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    for animation in [faces::demo(), faces::other_axes_and_units()] {
        let triangles = triangles(animation, folder.path());
        let rest = write("rest", floats(animation.rig.surface().rest.as_flattened()));
        let positions = write("positions", floats(&animation.positions));
        let files: Vec<_> = exports.iter().map(|(file, options)| animation.export(file, options)).collect();
        let all = programs::three(&files, &animation.frames);
        let cases = all.iter().zip(exports).map(|(shown, (file, _))| {
            let strains = shown_strains(animation, shown).into_iter().flat_map(f64::to_le_bytes).collect();
            let strains = write(&format!("{file}.strains"), strains);
            json!({ "triangles": triangles, "rest": rest, "positions": positions, "strains": strains })
        });
        let found = programs::strain(cases.collect());
        for (((file, options), shown), found) in exports.iter().zip(&all).zip(&found) {
            let what = format!("three.js, {} as {file} {options}", animation.rig.surface().name);
            // Frame times have 32 bits, so that each frame contains a trace of the next one.
            assert_eq!(
                shown.stated_strain.is_some(),
                options.contains("--compressed") || options.contains("--shapes")
            );
            assert_found(&what, animation, found, shown.stated_strain.unwrap_or(2e-5) + 2e-5);
        }
    }
}
