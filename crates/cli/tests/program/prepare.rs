//! `rhytid prepare`, and raw takes in `animate`: the demo's performance is made raw, and recovered.

use crate::common::raw::{Raw, off, rig, truth};
use crate::common::{rhytid, stderr};
use rhytid::formats::take::{Missing, read};
use serde_json::Value;

/// A ghost and a gap.
fn spoilt(j: usize, f: usize, [x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
    let ghost = if (j, f) == (5, 150) { 60.0 } else { 0.0 };
    (j != 3 || !(60..63).contains(&f)).then_some([x + ghost, y, z])
}

#[test]
fn a_raw_take_is_cleaned_reported_and_animated() {
    let raw = Raw::new();
    raw.write(&spoilt);
    let report = raw.path("report");
    let output = raw.prepare(&format!("--neutral 0..1 --report {}", report.display()));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(said.contains("cap0, cap1, cap2, cap3") && said.contains("outliers"), "{said}");

    let truth = truth();
    let found = read(&raw.path("clean.csv"), Some(&truth.labels), Missing::Error).unwrap();
    assert_eq!(found.times.len(), truth.times.len());
    let m = truth.labels.len();
    for (i, confidence) in found.confidence.as_ref().unwrap().iter().enumerate() {
        let is_filled = (i % m, i / m) == (5, 150) || (i % m == 3 && (60..63).contains(&(i / m)));
        assert_eq!(*confidence < 1.0, is_filled, "frame {} marker {}", i / m, i % m);
        let off = off(&found, &truth, i % m, i / m);
        assert!(off < if is_filled { 2.0 } else { 0.05 }, "frame {} marker {}: {off} mm", i / m, i % m);
    }
    assert!(found.head.is_some());
    let html = std::fs::read_to_string(report.join("report.html")).unwrap();
    assert!(html.contains("raw.trc"), "the report does not name its take");
    let json: Value = serde_json::from_slice(&std::fs::read(report.join("report.json")).unwrap()).unwrap();
    assert_eq!(json["setup"]["axes"], "+x+z-y");

    // `animate` cleans the raw take as well. `verify` cleans it anew and agrees.
    let [take, usd] = ["raw.trc", "shot.usd"].map(|name| raw.path(name).display().to_string());
    let rig = rig().display().to_string();
    for command in [
        format!("animate {rig} {take} -o {usd} --device cpu:0"),
        format!("verify {usd} --rig {rig} --take {take} --device cpu:0"),
    ] {
        let output = rhytid(&command).output().unwrap();
        assert!(output.status.success(), "{command}: {}", stderr(&output));
    }
}

#[test]
fn a_setup_says_what_cannot_be_found() {
    let mut raw = Raw::new();
    for (j, label) in raw.labels.iter_mut().enumerate() {
        *label = format!("M{j}");
    }
    raw.write(&spoilt);

    let truth = truth();
    let map: String =
        truth.labels.iter().enumerate().map(|(j, label)| format!("{label} = \"M{j}\"\n")).collect();
    let cap: Vec<String> = (0..4).map(|i| format!("\"M{}\"", truth.labels.len() + i)).collect();
    let setup = format!("neutral = \"0..1\"\nunit = \"mm\"\nrigid = [{}]\n[map]\n{map}", cap.join(", "));
    std::fs::write(raw.path("anna.toml"), setup).unwrap();
    let [take, toml, usd, clean] =
        ["raw.trc", "anna.toml", "shot.usd", "clean.csv"].map(|name| raw.path(name).display().to_string());
    let (found, _, json) = raw.prepared(&format!("--setup {toml}"));
    assert!((0..truth.frames()).all(|f| off(&found, &truth, 7, f) < 0.05));
    assert_eq!(json["setup"]["neutral_is_found"], false);
    // An option beside it wins.
    let (_, _, json) = raw.prepared(&format!("--setup {toml} --neutral 1..3"));
    assert_eq!(json["setup"]["neutral"], serde_json::json!({ "start": 1, "end": 3 }));

    let rig = rig().display().to_string();
    for (command, code, words) in [
        (format!("animate {rig} {take} -o {usd} --device cpu:0 --setup {toml}"), 0, ""),
        (format!("verify {usd} --rig {rig} --take {take} --device cpu:0 --setup {toml}"), 0, ""),
        (format!("coverage {rig} {take} --setup {toml}"), 0, ""),
        (format!("animate {rig} {clean} -o {usd} --setup {toml}"), 2, "is a clean take"),
    ] {
        let output = rhytid(&command).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{command}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{command}: {}", stderr(&output));
    }
}

#[test]
fn gaps_can_be_left_open() {
    let raw = Raw::new();
    raw.write(&spoilt);
    let (found, _, json) = raw.prepared("--neutral 0..1 --skip gaps");
    let m = found.labels.len();
    for (i, p) in found.positions.iter().enumerate() {
        let is_open = (i % m, i / m) == (5, 150) || (i % m == 3 && (60..63).contains(&(i / m)));
        assert_eq!(p[0].is_nan(), is_open, "frame {} marker {}", i / m, i % m);
    }
    assert_eq!(json["summary"]["events"], serde_json::json!({ "left": 2, "outlier": 1 }));
    std::fs::write(raw.path("open.toml"), "skip = [\"gaps\"]").unwrap();
    let [take, toml, usd] =
        ["raw.trc", "open.toml", "shot.usd"].map(|name| raw.path(name).display().to_string());
    let output =
        rhytid(&format!("animate {} {take} -o {usd} --setup {toml}", rig().display())).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("remove “gaps” from `skip`"), "{}", stderr(&output));
}

#[test]
fn info_says_what_is_in_a_raw_take() {
    let raw = Raw::new();
    raw.write(&spoilt);
    let output = rhytid(&format!("info {} --json", raw.path("raw.trc").display())).output().unwrap();
    let info: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&info["kind"], &info["frames"]), (&"raw_take".into(), &truth().frames().into()));
    assert_eq!((&info["rate"], &info["metres_per_unit"]), (&30.0.into(), &0.001.into()));
    let missing = info["missing"].as_array().unwrap();
    assert!(missing.iter().enumerate().all(|(j, n)| n == if j == 3 { 3 } else { 0 }), "{info}");
    let output = rhytid(&format!("info {}", raw.path("raw.trc").display())).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("raw take") && said.contains("of 1 marker"), "{said}");
}

#[test]
fn mistakes_are_told() {
    let raw = Raw::new();
    raw.write(&spoilt);
    std::fs::write(raw.path("bad.toml"), "rate = 30\nunits = \"mm\"\n").unwrap();
    let bad = format!("--setup {}", raw.path("bad.toml").display());
    for (options, expected) in [
        ("--neutral 500..600", "the neutral frames are 500..600"),
        ("--map nobody=cap0", "no such handle"),
        ("--rigid cap0,cap1,hat", "“hat” is not in the file"),
        ("--axes +x+y", "does not name three axes"),
        (&bad, "bad.toml, line 2: unknown field `units`"),
        ("--setup no.toml", "no.toml"),
    ] {
        let output = raw.prepare(options);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected) && !raw.path("clean.csv").exists(), "{said}");
    }
}
