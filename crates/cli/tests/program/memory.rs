//! Memory does not grow with the number of frames: measured on the real face, if the test data is there.

use rhytid_test_support::{peak_of, shared};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

const PROJECT: &str = r#"
[mesh]
neutral = "DATA/face/neutral.obj"
units = "cm"
up = "y"
[handles]
vertices = "markers.csv"
[large_scale]
bending_length = 3.0
"#;

/// Runs a command that must succeed and returns the most memory it held, in MB. The high-water mark is read
/// from /proc until the process is gone, so it misses at most the last few milliseconds.
fn peak_megabytes(dir: &Path, args: &str) -> f64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rhytid"))
        .args(args.split_whitespace())
        .current_dir(dir)
        .stdout(Stdio::null())
        .stderr(Stdio::inherit())
        .spawn()
        .unwrap();
    let mut peak = 0.0;
    loop {
        if let Some(bytes) = peak_of(child.id()) {
            peak = bytes as f64 / 1e6;
        }
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{args}");
            return peak;
        }
        std::thread::sleep(Duration::from_millis(3));
    }
}

#[test]
fn animating_the_real_face() {
    let Some(shared) = shared("") else { return };
    let data = shared.join("data").canonicalize().unwrap();
    let dir = TempDir::new().unwrap();
    let mut project = PROJECT.replace("DATA", data.to_str().unwrap());
    let mut poses = crate::common::list(&data.join("face/poses"));
    poses.retain(|name| name.ends_with(".obj"));
    assert_eq!(poses.len(), 8);
    for pose in poses {
        let mesh = data.join("face/poses").join(&pose);
        project += &format!("[[example]]\nname = {pose:?}\nmesh = {mesh:?}\n");
    }
    std::fs::write(dir.path().join("face.toml"), project).unwrap();
    // The table fits the whole head too: all its vertices are below the face's count.
    std::fs::copy(data.join("markers.csv"), dir.path().join("markers.csv")).unwrap();
    peak_megabytes(dir.path(), "solve face.toml --allow-elsewhere -o face.safetensors -q");
    let take = data.join("takes/rom_3_clean.csv");
    let peak = |ending: &str, options: &str, frames: usize| {
        let output = dir.path().join(format!("face.{ending}"));
        let args = format!(
            "animate face.safetensors {} -o face.{ending} {options} --frames 0..{frames} -q --device cpu:0",
            take.display()
        );
        let peak = peak_megabytes(dir.path(), &args);
        let size = std::fs::metadata(&output).unwrap().len() as f64 / 1e6;
        std::fs::remove_file(output).unwrap();
        eprintln!("{ending} {options}, {frames} frames: {peak:.0} MB held, {size:.0} MB written");
        peak
    };
    // Compression holds the vertices that are near the bound, in up to a gigabyte.
    let compressed = peak("glb", "--compressed", 300);
    assert!((10.0..1300.0).contains(&compressed), "compressed: 300 frames hold {compressed} MB");
    // Positions and normals of 300 frames, in megabytes. A busy machine writes later and holds more batches.
    let held = 300.0 * 9409.0 * 24.0 / 1e6;
    for (ending, options) in [("usd", ""), ("usda", ""), ("usdz", ""), ("glb", "--force")] {
        let (short, long) = (peak(ending, options, 300), peak(ending, options, 600));
        assert!((10.0..300.0).contains(&short), "{ending} {options}: 300 frames hold {short} MB");
        assert!(
            long <= short + 0.25 * held,
            "{ending} {options}: 600 frames hold {long} MB, 300 hold {short} MB"
        );
    }
}
