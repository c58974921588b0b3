//! `rhytid bench`: what it prints, and what it refuses. Times themselves are nobody's to test.

mod common;

use common::{Fixture, assert_documented, stderr};
use serde_json::Value;

#[test]
fn every_device_and_stage_is_in_the_json() {
    let f = Fixture::new();
    for (flags, storage) in [("", "f32"), ("--storage f16 --frames 6", "f16")] {
        let printed = f.done(&format!("bench --vertices 1000 --device all --json {flags}"));
        let report: Value = serde_json::from_str(&printed).unwrap();
        assert_documented(&report, "bench");
        assert_eq!(report["storage"], storage);
        let devices = report["devices"].as_array().unwrap();
        let listed: Value = serde_json::from_str(&f.done("devices --json")).unwrap();
        assert_eq!(devices.len(), listed["devices"].as_array().unwrap().len());
        for device in devices {
            assert_documented(device, "a measured device");
            assert_eq!(device["error"], Value::Null, "{device}");
            assert_documented(&device["whole"], "a whole frame");
            let stages = device["stages"].as_array().unwrap();
            assert!(stages.len() == 6 || device["device"] != "cpu:0", "{device}");
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
fn a_rig_of_ones_own_is_measured() {
    let f = Fixture::new();
    f.done("demo demo --vertices 3000");
    let info: Value = serde_json::from_str(&f.done("info demo/face.safetensors --json")).unwrap();
    let report: Value = serde_json::from_str(&f.done("bench demo/face.safetensors --json")).unwrap();
    for key in ["vertices", "strain_edges"] {
        assert_eq!(report[key], info[key], "{key}");
    }
    let printed = f.done("bench demo/face.safetensors --frames 2");
    for word in ["large_scale", "whole frame", "frames a second", "per frame", "GeForce 8800"] {
        assert!(printed.contains(word), "{word}: {printed}");
    }
}

#[test]
fn what_cannot_be_measured_is_said() {
    let f = Fixture::new();
    f.refused("bench --device cpu:7", &["cpu:7", "no such device"]);
    f.refused("bench missing.safetensors", &["missing.safetensors"]);
    for (args, word) in [
        ("bench --vertices 10", "1000..=4000000"),
        ("bench some.safetensors --vertices 5000", "cannot be used with"),
        ("bench --frames 0", "1..=256"),
    ] {
        let output = f.rhytid(args).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{args}");
        assert!(stderr(&output).contains(word), "{args}: {}", stderr(&output));
    }
}
