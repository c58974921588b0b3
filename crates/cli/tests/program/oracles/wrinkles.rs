//! Wrinkle activations in files, compared with those that a script computes in another way from the rig file
//! and the take.

use super::animation::Animation;
use super::{faces, programs};
use serde_json::{Value, json};

/// Both sides compute activations in 64 bits and store them in 32. The systems are as badly conditioned as
/// their ridge allows.
const ROUNDING: f64 = 1e-6;

/// Groups of an animation's examples: the first two, and the third; the others are in none.
fn groups(animation: &Animation) -> (String, Value) {
    let names = &animation.rig.examples().names;
    let [a, b, c] = [0, 1, 2].map(|i| names[i].as_str());
    (format!("--wrinkle-group both={a}+{b} --wrinkle-group one={c}"), json!({ "both": [a, b], "one": [c] }))
}

#[test]
fn usd_has_the_activations_of_the_formula() {
    let heads = faces::real_head();
    let mut cases = Vec::new();
    for animation in [Some(faces::demo()), Some(faces::other_axes_and_units()), heads].into_iter().flatten() {
        let (options, groups) = groups(animation);
        for (name, options, groups) in [("each", String::new(), Value::Null), ("grouped", options, groups)] {
            let usd = animation.export(&format!("wrinkles-{name}.usd"), &format!("--wrinkles {options}"));
            let [rig, take] = ["face.safetensors", "take.csv"].map(|name| usd.with_file_name(name));
            let case = json!({ "rig": rig, "take": take, "groups": groups, "first": animation.frames.first, "usd": usd });
            cases.push((animation, case));
        }
    }
    let found = programs::wrinkles(cases.iter().map(|(_, case)| case.clone()).collect());
    for ((animation, case), found) in cases.iter().zip(&found) {
        let number = |name: &str| found[name].as_f64().unwrap();
        let (what, largest, worst) = (&case["usd"], number("largest"), number("worst"));
        eprintln!("{what}: activations up to {largest:.3}, off by {worst:.1e}");
        assert_eq!(found["frames"], json!(animation.frames.count), "{what}");
        let channels = if case["groups"].is_null() { animation.rig.examples().names.len() } else { 2 };
        assert_eq!(found["channels"], json!(channels), "{what}");
        assert!(largest > 0.3, "{what}: {largest} at most");
        assert!(worst <= ROUNDING, "{what}: off by {worst}");
    }
}
