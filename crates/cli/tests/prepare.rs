//! `rhytid prepare` and raw takes in `animate`: the demo's performance, made raw, comes back.
mod common;

use common::{rhytid, stderr};
use rhytid_formats::take::{Missing, read};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Output;

/// The demo's performance as a TRC file in millimetres with Z up, at 30 frames per second: turned, with a gap, a ghost and four markers of a cap.
fn make_raw(demo: &Path, path: &Path) {
    let take = read(&demo.join("performance.csv"), None, Missing::Error).unwrap();
    let m = take.labels.len();
    let labels: Vec<String> = take.labels.iter().cloned().chain((0..4).map(|i| format!("cap{i}"))).collect();
    let mut text = format!(
        "PathFileType\t4\t(X/Y/Z)\traw.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
         30\t30\t{0}\t{1}\tmm\t30\t1\t{0}\nFrame#\tTime\t{2}\n\t\t\n\n",
        take.frames(),
        m + 4,
        labels.join("\t\t\t")
    );
    for f in 0..take.frames() {
        write!(text, "{}\t{:.6}", f + 1, f as f64 / 30.0).unwrap();
        let angle = 0.2 * (f as f64 / 40.0).sin();
        let cap = [[0.0, 14.0, 5.0], [7.0, 10.0, -1.0], [-7.0, 10.0, -1.0], [0.0, 16.0, -4.0]];
        for (j, p) in take.positions[f * m..(f + 1) * m].iter().chain(&cap).enumerate() {
            let [x, y, z] =
                [p[0] * angle.cos() - p[1] * angle.sin(), p[0] * angle.sin() + p[1] * angle.cos(), p[2]];
            let ghost = if (j, f) == (5, 150) { 60.0 } else { 0.0 };
            if j == 3 && (60..63).contains(&f) {
                text.push_str("\t\t\t");
            } else {
                write!(text, "\t{:.5}\t{:.5}\t{:.5}", 10.0 * x + ghost, -10.0 * z, 1500.0 + 10.0 * y)
                    .unwrap();
            }
        }
        text.push('\n');
    }
    std::fs::write(path, text).unwrap();
}

/// A small demo with its performance made raw; its folder.
fn demo() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_owned();
    let output = rhytid(&format!("demo {} --vertices 1000", path.display())).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    make_raw(&path, &path.join("raw.trc"));
    (folder, path)
}

/// Runs `prepare` on the raw take.
fn prepare(folder: &Path, options: &str) -> Output {
    let [raw, rig, out] =
        ["raw.trc", "face.safetensors", "clean.csv"].map(|name| folder.join(name).display().to_string());
    rhytid(&format!("prepare {raw} --rig {rig} -o {out} {options}")).output().unwrap()
}

#[test]
fn a_raw_take_is_cleaned_reported_and_animated() {
    let (_kept, folder) = demo();
    let report = folder.join("report");
    let output = prepare(&folder, &format!("--neutral 0..1 --report {}", report.display()));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(said.contains("cap0, cap1, cap2, cap3") && said.contains("outliers"), "{said}");

    let truth = read(&folder.join("performance.csv"), None, Missing::Error).unwrap();
    let found = read(&folder.join("clean.csv"), Some(&truth.labels), Missing::Error).unwrap();
    assert_eq!(found.frames(), truth.frames());
    let m = truth.labels.len();
    for (i, (a, b)) in found.positions.iter().zip(&truth.positions).enumerate() {
        let off: f64 = 10.0 * a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let confidence = found.confidence.as_ref().unwrap()[i];
        let is_filled = (i % m, i / m) == (5, 150) || (i % m == 3 && (60..63).contains(&(i / m)));
        assert_eq!(confidence < 1.0, is_filled, "frame {} marker {}", i / m, i % m);
        assert!(off < if is_filled { 2.0 } else { 0.05 }, "frame {} marker {}: {off} mm", i / m, i % m);
    }
    assert!(found.head.is_some());
    let html = std::fs::read_to_string(report.join("report.html")).unwrap();
    assert!(html.contains("raw.trc"), "the report does not name its take");
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(report.join("report.json")).unwrap()).unwrap();
    assert_eq!(json["setup"]["axes"], "+x+z-y");

    // In passing: verify cleans the raw take anew and agrees.
    let [raw, rig, usd] =
        ["raw.trc", "face.safetensors", "shot.usd"].map(|name| folder.join(name).display().to_string());
    for command in [
        format!("animate {rig} {raw} -o {usd} --device cpu:0"),
        format!("verify {usd} --rig {rig} --take {raw} --device cpu:0"),
    ] {
        let output = rhytid(&command).output().unwrap();
        assert!(output.status.success(), "{command}: {}", stderr(&output));
    }
}

#[test]
fn mistakes_are_told() {
    let (_kept, folder) = demo();
    for (options, expected) in [
        ("--neutral 500..600", "the neutral frames are 500..600"),
        ("--map nobody=cap0", "no such handle"),
        ("--rigid cap0,cap1,hat", "“hat” is not in the file"),
        ("--axes +x+y", "is no way to turn axes"),
    ] {
        let output = prepare(&folder, options);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected) && !folder.join("clean.csv").exists(), "{said}");
    }
}
