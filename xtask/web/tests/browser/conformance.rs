//! The conformance suite as a page.

use super::*;
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{Suite, run_device};
use rhytid_core::{Backend, Device, Stage, UploadOptions};
use std::collections::BTreeSet;

const FACE: [(&str, &str); 2] =
    [("handles", "Array.from(rhytid.handlePositions)"), ("positions", "Array.from(rhytid.positions)")];

/// The page as a user sees it, visited once.
fn usual() -> &'static Value {
    static USUAL: OnceLock<Value> = OnceLock::new();
    USUAL.get_or_init(|| {
        let adapter =
            ("adapter", "navigator.gpu.requestAdapter().then((a) => a.limits.maxStorageBufferBindingSize)");
        let shown = ("shown", "document.body.innerText");
        // Clicks one after the other, like a hand.
        let clicked = (
            "clicked",
            "(async () => {
                for (const link of document.querySelectorAll('#downloads a')) {
                    link.click();
                    await new Promise((resolve) => setTimeout(resolve, 500));
                }
            })()",
        );
        let narrow = ("width", "document.documentElement.scrollWidth");
        let evaluate = [&RESULT[..], &FACE, &[adapter, shown, narrow, clicked]].concat();
        let mut visit = visit("conformance.html", "", ENDED, &evaluate);
        visit["width"] = json!(360);
        let downloads = tempfile::tempdir().unwrap();
        let mut visited = visited_with_downloads(visit, downloads.path());
        for name in ["report.md", "report.json", "junit.xml"] {
            visited[name] = std::fs::read_to_string(downloads.path().join(name)).ok().into();
        }
        visited
    })
}

/// Verdicts by name, in the order of the report.
fn verdicts(report: &Value) -> Vec<(&str, &str)> {
    let outcomes = report["devices"][0]["outcomes"].as_array().unwrap().iter();
    outcomes.map(|o| (o["name"].as_str().unwrap(), o["verdict"].as_str().unwrap())).collect()
}

#[test]
fn the_quick_suite_is_green_with_every_case_that_there_is_natively() {
    let found = &usual()["found"];
    assert_eq!(found["state"], "passed", "{}", found["shown"]);
    let info = Cpu::devices().unwrap().remove(0);
    let native = run_device(&Device::open::<Cpu>(&info).unwrap(), Suite::Quick, |_, _, _| true);
    let expected: Vec<(&str, &str)> = native.outcomes.iter().map(|o| (o.name.as_str(), "Pass")).collect();
    assert_eq!(verdicts(&found["report"]), expected);
    println!("{} outcomes in {} s", expected.len(), found["report"]["devices"][0]["wall_seconds"]);

    assert_eq!(found["report"]["suite"], "quick");
    assert!(found["report"]["system"].as_str().unwrap().contains("Chrome"), "{}", found["report"]["system"]);
    let device = &found["report"]["devices"][0]["device"];
    assert_eq!(device["driver"], "WebGPU");
    // More than WebGPU promises: the page requests the adapter's limits.
    assert_eq!(device["max_binding_bytes"], found["adapter"]);
    assert!(found["adapter"].as_u64().unwrap() > 128 << 20, "{}", found["adapter"]);
    let shown = found["shown"].as_str().unwrap();
    assert!(shown.contains(&format!("{0} of {0} passed", expected.len())), "{shown}");
    let width = found["width"].as_u64().unwrap();
    assert!(width <= 360, "a telephone's screen has to be scrolled sideways: {width}");
}

#[test]
fn the_report_can_be_downloaded_in_its_three_forms() {
    let text = |name: &str| usual()[name].as_str().unwrap_or_else(|| panic!("{name} was not handed over"));
    let json: Value = serde_json::from_str(text("report.json")).unwrap();
    let shown = &usual()["found"]["report"];
    assert_eq!(verdicts(&json), verdicts(shown));
    assert_eq!(json["devices"][0]["wall_seconds"], shown["devices"][0]["wall_seconds"]);
    assert!(json["memory_bandwidth"].is_null(), "{}", json["memory_bandwidth"]);
    assert!(
        text("report.md").starts_with("# Conformance report\n") && text("report.md").contains("swiftshader")
    );
    let cases = text("junit.xml").matches("<testcase ").count();
    assert_eq!(cases, verdicts(&json).len());
}

#[test]
fn a_face_is_where_the_processor_has_it() {
    let found = &usual()["found"];
    let rig = demo().0.clone();
    let (handles, positions) = (floats(&found["handles"]), floats(&found["positions"]));
    let frames = handles.len() / (3 * rig.handles().len());
    assert!(frames > 10, "{frames}");
    let device = Device::open::<Cpu>(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = device.upload(&rig, UploadOptions::frames(frames)).unwrap();
    animator.evaluate(&handles).unwrap();
    let mut expected = Vec::new();
    animator.read(Stage::Positions, &mut expected).unwrap();
    assert_eq!(positions.len(), expected.len());
    let off = positions.iter().zip(&expected).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    let off = off / height(&rig);
    println!(
        "{off:e} of the face's height off the processor's, {} of its size off the reference's",
        found["off"]
    );
    assert!(off < 2e-5, "{off:e}");
    // The face moves: the last pose differs from rest.
    let moved = positions[positions.len() - rig.surface().rest.len() * 3..]
        .iter()
        .zip(rig.surface().rest.as_flattened());
    assert!(moved.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) > 0.1);
}

fn height(rig: &Rig) -> f64 {
    let y = rig.surface().rest.iter().map(|p| f64::from(p[1]));
    y.clone().fold(f64::NEG_INFINITY, f64::max) - y.fold(f64::INFINITY, f64::min)
}

#[test]
fn arrays_that_are_split_give_the_same_bits() {
    let split = visited(visit("conformance.html?binding=65536", "", ENDED, &[&RESULT[..], &FACE].concat()));
    let (split, whole) = (&split["found"], &usual()["found"]);
    assert_eq!(split["state"], "passed", "{split}");
    assert_eq!(split["report"]["devices"][0]["device"]["max_binding_bytes"], 65536);
    // Both the basis and the positions of all poses are larger than that.
    let rig = demo().0.clone();
    assert!(rig.basis().as_slice().len() * 4 > 65536 && floats(&split["positions"]).len() * 4 > 65536);
    assert_eq!(split["positions"], whole["positions"]);

    let refused = visited(visit("conformance.html?binding=much", "", ENDED, &RESULT));
    assert_eq!(refused["found"]["state"], "broken");
    assert!(refused["found"]["message"].as_str().unwrap().contains("binding=much"), "{refused}");
}

#[test]
fn a_driver_that_gets_one_kernel_wrong_is_found_out() {
    // The browser's compiler gets a changed strain kernel, with results larger by a part in 100,000.
    let fault = "const make = GPUDevice.prototype.createShaderModule;
        GPUDevice.prototype.createShaderModule = function (descriptor) {
            const code = descriptor.code.replace('/ (length + l) / l', '/ (length + l) / l * 1.00001');
            return make.call(this, { ...descriptor, code });
        };";
    let shown = ("shown", "document.querySelector('.verdict').innerText");
    let found = visited(visit("conformance.html", fault, ENDED, &[&RESULT[..], &[shown]].concat()));
    let found = &found["found"];
    assert_eq!(found["state"], "failed");
    assert!(found["shown"].as_str().unwrap().starts_with("Failed"), "{}", found["shown"]);
    let failed = verdicts(&found["report"]).into_iter().filter(|(_, verdict)| *verdict != "Pass");
    let stages: BTreeSet<&str> = failed.map(|(name, _)| name.split('/').next().unwrap()).collect();
    assert_eq!(stages, BTreeSet::from(["strain"]));
}
