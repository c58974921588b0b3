//! `rhytid bench`: what it prints, and what it refuses. Times themselves are nobody's to test.

use crate::common::{Fixture, assert_documented, stderr};
use serde_json::Value;

#[test]
fn every_device_and_stage_is_in_the_json() {
    let f = Fixture::new();
    for (flags, storage) in [("", "f32"), ("--storage f16 --frames 6", "f16")] {
        let printed = f.done(&format!("bench --vertices 1000 --device all --json {flags}"));
        let report: Value = serde_json::from_str(&printed).unwrap();
        assert_documented(&report, "bench");
        assert_eq!(report["storage"], storage);
        // The parts of a frame make up its bytes. Strains are of edges, not of vertices.
        let stored: Vec<&Value> = report["bytes"].as_array().unwrap().iter().collect();
        stored.iter().for_each(|stored| assert_documented(stored, "what a frame moves with a storage"));
        let measured = stored.iter().find(|stored| stored["storage"] == storage).unwrap();
        let parts = measured["parts"].as_array().unwrap();
        parts.iter().for_each(|part| assert_documented(part, "a part"));
        let of_vertex: f64 = parts.iter().map(|part| part["bytes_per_vertex"].as_f64().unwrap()).sum();
        let number = |key: &str| report[key].as_f64().unwrap();
        let sum = of_vertex * number("vertices") + 4.0 * number("strain_edges");
        let devices = report["devices"].as_array().unwrap();
        let listed: Value = serde_json::from_str(&f.done("devices --json")).unwrap();
        assert_eq!(devices.len(), listed["devices"].as_array().unwrap().len());
        for device in devices {
            assert_documented(device, "a measured device");
            assert_eq!(device["error"], Value::Null, "{device}");
            assert_documented(&device["whole"], "a whole frame");
            let whole = device["whole"]["bytes"].as_f64().unwrap();
            assert!((whole - sum).abs() < 1e-6 * whole, "{whole} {sum}");
            assert_documented(&device["chapter"], "a frame by the chapter's method");
            let stages = device["stages"].as_array().unwrap();
            // The processor has all up to the positions in one.
            let names: Vec<&str> = stages.iter().map(|stage| stage["stage"].as_str().unwrap()).collect();
            assert!(names == ["strain", "large_scale", "normals"] || device["device"] != "cpu:0", "{device}");
            for stage in stages {
                assert_documented(stage, "a stage");
                assert!(
                    stage["ms"].as_f64().unwrap() >= 0.0 && stage["bytes"].as_f64().unwrap() > 0.0,
                    "{stage}"
                );
            }
        }
    }
}

#[test]
fn the_chapters_method_is_measured_in_turns_or_alone() {
    let f = Fixture::new();
    let both = f.done("bench --vertices 1000 --device cpu:0");
    assert!(both.contains("times as long as the chapter's method"), "{both}");
    let alone: Value =
        serde_json::from_str(&f.done("bench --vertices 1000 --device cpu:0 --method chapter --json"))
            .unwrap();
    assert_eq!(alone["devices"][0]["chapter"], Value::Null);
}

#[test]
fn a_rig_of_ones_own_is_measured() {
    let f = Fixture::new();
    f.done("demo demo --vertices 3000");
    let info: Value = serde_json::from_str(&f.done("info demo/face.safetensors --json")).unwrap();
    let report: Value = serde_json::from_str(&f.done("bench demo/face.safetensors --json")).unwrap();
    for key in ["vertices", "strain_edges"] {
        assert_eq!(report[key], info[key], "{key}");
    }
    let printed = f.done("bench demo/face.safetensors --frames 2");
    for word in
        ["large_scale", "whole frame", "bytes of a vertex", "frames a second", "per frame", "GeForce 8800"]
    {
        assert!(printed.contains(word), "{word}: {printed}");
    }
}

#[test]
fn how_it_grows_is_drawn_and_printed() {
    let f = Fixture::new();
    let printed = f.done("bench --vertices 1000 --device cpu:0 --growth --plot chart.svg --json");
    let report: Value = serde_json::from_str(&printed).unwrap();
    let growth = report["devices"][0]["growth"].as_array().unwrap();
    for point in growth {
        assert_documented(point, "a size");
        assert!(point["ms"].as_f64().unwrap() > 0.0, "{point}");
    }
    let sizes = |what: &str| {
        let of_it = growth.iter().filter(|point| point["what"] == what);
        of_it.map(|point| point["size"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(sizes("frames"), [1, 2, 4, 8, 16, 32, 64]);
    assert_eq!(sizes("handles"), [30, 60, 100, 180, 250]);
    assert_eq!(sizes("examples"), [1, 3, 6, 10, 20, 40]);
    assert!(sizes("vertices").len() > 3 && sizes("vertices").last() > Some(&3_500));

    let svg = String::from_utf8(f.read("chart.svg")).unwrap();
    let ms = report["devices"][0]["whole"]["ms"].as_f64().unwrap();
    let time = format!("{ms:.2} ms");
    for word in ["cpu:0", "large scale", "clustered", "handles", "ms per frame", "frames in a batch", &time] {
        assert!(svg.contains(word), "{word} is not in the chart");
    }

    let printed = f.done("bench --vertices 1000 --growth");
    for word in ["frames in a batch", "examples", "ms per frame"] {
        assert!(printed.contains(word), "{word}: {printed}");
    }
}

#[test]
fn what_cannot_be_measured_is_said() {
    let f = Fixture::new();
    f.refused("bench --device cpu:7", &["cpu:7", "no such device"]);
    f.refused("bench missing.safetensors", &["missing.safetensors"]);
    f.refused("bench --vertices 1000 --plot nowhere/chart.svg", &["nowhere"]);
    for (args, word) in [
        ("bench --vertices 10", "1000..=4000000"),
        ("bench some.safetensors --vertices 5000", "cannot be used with"),
        ("bench some.safetensors --growth", "cannot be used with"),
        ("bench --frames 0", "1..=256"),
    ] {
        let output = f.rhytid(args).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{args}");
        assert!(stderr(&output).contains(word), "{args}: {}", stderr(&output));
    }
}
