//! `rhytid stitch`: parts of a take that were exported separately make up the take.

use crate::common::Fixture;
use assert_cmd::Command;
use rhytid::formats::animation;

fn rhytid(fixture: &Fixture) -> Command {
    let mut command = Command::cargo_bin("rhytid").unwrap();
    command.current_dir(fixture.path("."));
    command
}

fn animate(fixture: &Fixture, frames: &str, output: &str) {
    let args = [
        "animate",
        "out/face.safetensors",
        "take.csv",
        "--device",
        "cpu:0",
        "--frames",
        frames,
        "-o",
        output,
    ];
    rhytid(fixture).args(args).assert().success();
}

#[test]
fn parts_of_a_take_are_the_take() {
    let fixture = Fixture::new();
    rhytid(&fixture).args(["solve", "face.toml", "-o", "out/face.safetensors"]).assert().success();
    animate(&fixture, "2..17", "out/whole.usd");
    for (frames, output) in [("2..8", "out/a.usd"), ("8..9", "out/b.usda"), ("9..17", "out/c.usd")] {
        animate(&fixture, frames, output);
    }
    let args = ["stitch", "out/c.usd", "out/a.usd", "out/b.usda", "-o", "out/stitched.usd"];
    let done = rhytid(&fixture).args(args).assert().success();
    let printed = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(printed.contains("15 frames in 3 parts, time codes 2 to 16"), "{printed}");
    let [mut stitched, mut whole] =
        ["out/stitched.usd", "out/whole.usd"].map(|name| animation::open(&fixture.path(name)).unwrap());
    assert_eq!(stitched.summary(), whole.summary());
    let [mut a, mut b] = [Vec::new(), Vec::new()];
    for frame in 0..15 {
        stitched.positions(frame, &mut a).unwrap();
        whole.positions(frame, &mut b).unwrap();
        assert_eq!(a, b, "frame {frame}");
    }

    let files = || std::fs::read_dir(fixture.path("out")).unwrap().map(|entry| entry.unwrap().path());
    let manifest = files().find(|path| path.to_string_lossy().ends_with(".manifest.usdc")).unwrap();
    std::fs::rename(fixture.path("out/stitched.usd"), fixture.path("out/renamed.usd")).unwrap();
    for damaged in [false, true] {
        if damaged {
            std::fs::remove_file(&manifest).unwrap();
        }
        let args = ["verify", "out/renamed.usd", "--rig", "out/face.safetensors", "--take", "take.csv"];
        let done = rhytid(&fixture).args(args).args(["--device", "cpu:0"]).output().unwrap();
        let said = String::from_utf8_lossy(if damaged { &done.stderr } else { &done.stdout });
        assert_eq!(done.status.code(), Some(if damaged { 2 } else { 0 }), "{said}");
        let expected = if damaged { ".manifest.usdc is not there" } else { "sound" };
        assert!(said.contains(expected), "{said}");
    }

    let args = ["stitch", "out/a.usd", "out/c.usd", "-o", "out/gap.usd"];
    let failed = rhytid(&fixture).args(args).assert().code(2);
    let said = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(said.contains("frames 8 to 8 are in no part"), "{said}");
    assert!(files().all(|path| !path.to_string_lossy().contains("out/gap")));
}
