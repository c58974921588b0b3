//! Principal strains in files, compared with those that a script computes from the triangles by another way.

use super::animation::Animation;
use super::{faces, programs};
use serde_json::{Value, json};
use std::path::Path;

/// Strains that are computed in 64 bits on both sides and stored in 32.
const ROUNDING: f64 = 1e-6;

/// The sine of the largest angle between directions.
const DIRECTION: f64 = 1e-3;

/// The triangles of an animation's mesh, for the script.
fn triangles(animation: &Animation, folder: &Path) -> Value {
    let path = folder.join(format!("{}.triangles", animation.rig.name));
    let numbers = animation.rig.triangles.as_flattened();
    std::fs::write(&path, numbers.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    json!(path)
}

/// Asserts that what the script found is no farther off than that, and that there was something to find.
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
