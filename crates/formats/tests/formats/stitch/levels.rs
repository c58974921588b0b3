//! Levels of detail as variants, as USD's own library shows them.

use super::{FIRST_TIME_CODE, FRAMES, pythons, sentence};
use crate::animation::{Animation, Other, UvKind, with_everything};
use rhytid_formats::animation::open;
use rhytid_formats::usd;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Three animations with the same frames, the last one with a vertex less, that have nothing else in common.
fn exported(folder: &Path) -> [PathBuf; 3] {
    let mut last = level(UvKind::None, 7);
    last.rest.pop();
    last.rest_normals.pop();
    last.frames.iter_mut().flatten().for_each(|numbers| numbers.truncate(3 * last.rest.len()));
    for Other { channel, frames } in &mut last.others {
        frames.iter_mut().for_each(|numbers| numbers.truncate(channel.width * last.rest.len()));
    }
    let all = [level(UvKind::PerCorner, 5), level(UvKind::PerVertex, 6), last];
    std::fs::create_dir_all(folder.join("less detail")).unwrap();
    let names = ["whole.usd", "less detail/half.usda", "quarter.usdz"].map(|name| folder.join(name));
    for (animation, path) in all.iter().zip(&names) {
        animation.export(path).unwrap();
    }
    names
}

fn level(kind: UvKind, seed: u64) -> Animation {
    let mut level = with_everything(kind, FRAMES, seed);
    level.first_time_code = FIRST_TIME_CODE;
    level
}

#[test]
fn each_variant_is_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let files = exported(folder.path());
    let output = folder.path().join("levels.usda");
    let done = usd::levels(&files, &output).unwrap();
    assert_eq!((done.frames, done.time_codes), (FRAMES, [11.0, 19.0]));
    assert_eq!(done.variants, ["LOD0", "LOD1", "LOD2"]);
    assert_eq!(done.bytes, std::fs::metadata(&output).unwrap().len());
    for python in pythons() {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/stitch/levels.py");
        let mut command = Command::new(python);
        command.arg(script).arg(folder.path());
        let output = command.args(["whole.usd", "less detail/half.usda", "quarter.usdz"]).output().unwrap();
        let printed = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
        assert!(printed.contains("3 levels are as their files"), "{printed}");
    }
    // We do not read variants, and say so.
    let message = sentence(open(&output));
    assert!(message.contains("the variant set LOD is not read: open a file"), "{message}");
}

#[test]
fn files_that_are_no_levels_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, half, quarter] = exported(folder.path());
    let output = folder.path().join("out.usda");
    let refused = |files: &[&PathBuf], output: &Path, says: &[&str]| {
        let files: Vec<PathBuf> = files.iter().map(|&path| path.clone()).collect();
        let message = usd::levels(&files, output).unwrap_err().to_string();
        says.iter().for_each(|says| assert!(message.contains(says), "{message}"));
    };
    refused(&[&whole], &output, &["two files at least"]);
    refused(&[&whole, &half], &folder.path().join("out.usdc"), &["out.usdc", ".usda"]);
    refused(&[&whole, &half], &half, &["half.usda"]);
    refused(&[&quarter, &whole], &output, &["whole.usd", "name the whole face first"]);
    let missing = folder.path().join("missing.usd");
    refused(&[&whole, &missing], &output, &["missing.usd"]);
    let mut other = level(UvKind::None, 5);
    other.frames.pop();
    other.others.iter_mut().for_each(|other| drop(other.frames.pop()));
    other.head.as_mut().unwrap().pop();
    let shorter = folder.path().join("shorter.usd");
    other.export(&shorter).unwrap();
    refused(&[&whole, &shorter], &output, &["shorter.usd", "whole.usd", "frames: 8 and 9", "the same take"]);
    assert!(!output.exists());
}
