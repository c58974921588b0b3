//! ezc3d as the oracle in both directions. This reader reads the files of ezc3d number for number, and ezc3d
//! reads the files of the tests' writer as this reader does.
use super::c3d_writer::{C3d, PROCESSORS, Value, trial};
use super::{is_missing, read};
use rhytid_core::{RawTake, Take};
use serde_json::Value as Json;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Python with the packages of `xtask/requirements.txt`.
fn ezc3d(arguments: &[&Path]) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = rhytid_test_support::python();
    let mut command = Command::new(&python);
    command.arg(folder.join("tests/formats/raw_take/oracle.py")).args(arguments);
    let output = command
        .output()
        .unwrap_or_else(|e| panic!("{}: {e}; run `cargo xtask setup` first", python.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Compares a take with what ezc3d says of the same file, exactly.
fn assert_same(take: &Take, oracle: &Json, what: &str) {
    let labels: Vec<&str> =
        oracle["labels"].as_array().unwrap().iter().map(|l| l.as_str().unwrap()).collect();
    assert_eq!(take.labels, labels, "{what}");
    assert_eq!(take.rate(), oracle["rate"].as_f64().unwrap(), "{what}");
    let positions = oracle["positions"].as_array().unwrap();
    assert_eq!(take.positions.len(), positions.len(), "{what}");
    for (i, (position, oracle)) in take.positions.iter().zip(positions).enumerate() {
        // Single precision is what the file has and what ezc3d computes in.
        let oracle = [0, 1, 2].map(|axis| oracle[axis].as_f64().map(|x| x as f32));
        let found = (!is_missing(position)).then_some(position.map(|x| x as f32));
        assert_eq!(found.map_or([None; 3], |p| p.map(Some)), oracle, "{what}: sample {i}");
    }
    let confidence = |i: usize| take.confidence.as_ref().map_or(1.0, |confidence| confidence[i]);
    for (i, residual) in oracle["residuals"].as_array().unwrap().iter().enumerate() {
        let residual = residual.as_f64().unwrap();
        assert_eq!(residual < 0.0, is_missing(&take.positions[i]), "{what}: sample {i}");
        assert_eq!(confidence(i), if residual == 0.0 { RawTake::FILLED } else { 1.0 }, "{what}: sample {i}");
    }
}

#[test]
fn what_ezc3d_writes_is_read_number_for_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trial.c3d");
    for (points, frames, first, analogs) in
        [(7, 40, 0, 0), (7, 40, 240, 2), (300, 6, 0, 0), (2, 70_000, 0, 0)]
    {
        let numbers = [points, frames, first, analogs].map(|n: usize| n.to_string());
        let arguments: Vec<&Path> =
            [Path::new("write"), &path].into_iter().chain(numbers.iter().map(Path::new)).collect();
        ezc3d(&arguments);
        let take = read(&std::fs::read(&path).unwrap(), "ezc3d.c3d");
        // ezc3d leaves its counter full where there are more frames than that counts.
        assert_eq!(take.warnings.len(), usize::from(frames > 65535), "{:?}", take.warnings);
        assert_eq!(take.metres_per_unit, Some(0.001));
        let tracks = &take.tracks;
        assert_eq!((tracks.labels.len(), tracks.frames()), (points, frames), "{numbers:?}");
        assert_eq!(tracks.labels[points - 1], format!("a{}", points - 1));
        assert_eq!(tracks.times[0], first as f64 / 120.0);
        for (at, found) in tracks.positions.iter().enumerate() {
            let (i, j) = ((at / points) as f64, (at % points) as f64);
            let written =
                [-700.0 + 3.0 * j + i / 16.0, 12.5 * j - i / 4.0, 1500.0 - j + i * 7.0 % 64.0 / 16.0];
            let is_gap = (at / points, at % points) == (3, 1);
            assert!(is_missing(found) == is_gap && (is_gap || *found == written), "{at}: {found:?}");
            let filled = (at / points, at % points) == (4, 1);
            assert_eq!(tracks.confidence.as_ref().unwrap()[at] < 1.0, filled, "{at}");
        }
    }
}

#[test]
fn ezc3d_reads_what_the_tests_write_as_this_reader_does() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    let mut add = |name: &str, written: C3d| {
        let path = folder.path().join(format!("{name}.c3d"));
        std::fs::write(&path, written.bytes()).unwrap();
        files.push(path);
    };
    // It knows no SGI.
    for (name, processor) in &PROCESSORS[..2] {
        let mut written = C3d { processor: *processor, ..trial(7, 40) };
        written.set("POINT", "LABELS", Value::Texts((0..7).map(|j| format!("marker{j}")).collect()));
        add(&format!("{name}-float"), written.clone());
        add(&format!("{name}-integer"), written.integer(0.1));
    }
    let mut many = trial(300, 6);
    for (name, range) in [("LABELS", 0..255), ("LABELS2", 255..300)] {
        many.set("POINT", name, Value::Texts(range.map(|j| format!("a{j}")).collect()));
    }
    add("many", many);
    let arguments: Vec<&Path> =
        std::iter::once(Path::new("read")).chain(files.iter().map(PathBuf::as_path)).collect();
    let said: Vec<Json> = serde_json::from_str(&ezc3d(&arguments)).unwrap();
    assert_eq!(said.len(), files.len());
    for (path, oracle) in files.iter().zip(&said) {
        let take = read(&std::fs::read(path).unwrap(), "trial.c3d");
        assert_same(&take.tracks, oracle, &path.display().to_string());
    }
}
