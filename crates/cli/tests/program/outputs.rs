//! Outputs onto an input, a link, a device, or a file that is private or read-only. Also two writers of one
//! file, and writers that are killed.
#![cfg(unix)]

use crate::common::{Fixture, assert_refused, list};
use rhytid::formats::{Reach, animation::open_within};
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A rig, a take and two parts of its animation, none of them in `out/`.
fn prepared() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (frames, part) in [("0..9", "a"), ("9..17", "b")] {
        f.done(&format!(
            "animate face.safetensors take.csv --device cpu:0 --frames {frames} -o part-{part}.usd"
        ));
    }
    f
}

/// Every command that writes a file: its start up to `-o`, one of its inputs, and the ending of its output.
const WRITERS: [(&str, &str, &str); 8] = [
    ("solve face.toml -o", "neutral.obj", "safetensors"),
    ("solve face.toml -o", "poses/pinch.obj", "safetensors"),
    ("animate face.safetensors take.csv --device cpu:0 -o", "take.csv", "usd"),
    ("animate face.safetensors take.csv --device cpu:0 -o", "face.safetensors", "gltf"),
    ("export-shapes face.safetensors --device cpu:0 -o", "face.safetensors", "glb"),
    ("prepare take.csv --rig face.safetensors -o", "take.csv", "csv"),
    ("pack face.safetensors -o", "face.safetensors", "safetensors"),
    ("stitch part-a.usd part-b.usd -o", "part-a.usd", "usd"),
];

#[test]
fn no_input_is_overwritten_by_whatever_name() {
    let f = prepared();
    std::fs::create_dir(f.path("names")).unwrap();
    for (command, input, ending) in WRITERS {
        let before = f.read(input);
        let stem = input.replace('/', "-");
        let [soft, hard, twice] =
            ["soft", "hard", "twice"].map(|name| format!("names/{name}-{stem}.{ending}"));
        let _ = symlink(f.path(input), f.path(&soft));
        let _ = symlink(f.path(&soft), f.path(&twice));
        let _ = std::fs::hard_link(f.path(input), f.path(&hard));
        let mut names = vec![soft, hard, twice];
        if input.ends_with(ending) {
            names.extend([input.to_owned(), format!("names/../{input}")]);
        }
        for name in names {
            f.refused(&format!("{command} {name}"), &[&name, "which this command reads"]);
            assert_eq!(f.read(input), before, "{command} {name}");
        }
    }
    f.refused(
        "prepare take.csv --rig face.safetensors -o out/a.csv --write-markers names/../out/a.csv",
        &["two outputs"],
    );
}

/// A table that only TAKE.toml names is an input as well.
#[test]
fn the_table_of_markers_is_an_input() {
    let f = prepared();
    f.write("known.csv", "handle,marker\n");
    f.write("take.toml", "markers = \"known.csv\"\n");
    f.refused(
        "prepare take.csv --rig face.safetensors --setup take.toml -o known.csv",
        &["known.csv", "which this command reads"],
    );
    assert_eq!(f.read_text("known.csv"), "handle,marker\n");
}

#[test]
fn a_device_and_a_pipe_stay_what_they_are() {
    let f = prepared();
    let made = Command::new("mkfifo").arg(f.path("pipe")).status().unwrap();
    assert!(made.success());
    for (command, _, ending) in WRITERS {
        for (target, name) in [("/dev/null", "null"), ("pipe", "fifo")] {
            let name = format!("{name}.{ending}");
            let _ = symlink(target, f.path(&name));
            // A stitched file is refused because of the link, since it has another file beside it.
            let why =
                if command.starts_with("stitch") { "is a link" } else { "a device, a pipe or a socket" };
            f.refused(&format!("{command} {name}"), &[&name, why]);
        }
        let said =
            assert_refused(&f.rhytid(&format!("{command} /dev/null")).output().unwrap(), &["/dev/null"]);
        assert!(!said.contains("nothing was written"), "{command}: {said}");
    }
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    assert!(!std::fs::metadata(f.path("pipe")).unwrap().is_file());
}

#[test]
fn a_link_stays_a_link_and_a_mode_a_mode() {
    let f = prepared();
    // Outputs with another file beside them: links to these are refused.
    for (command, _, ending) in WRITERS.iter().filter(|(command, ..)| !command.starts_with("stitch")) {
        let ending = if *ending == "gltf" { "glb" } else { ending };
        let [link, file] = [format!("link.{ending}"), format!("out/file.{ending}")];
        f.write(&file, "old");
        std::fs::set_permissions(f.path(&file), std::fs::Permissions::from_mode(0o600)).unwrap();
        let owner = std::os::unix::fs::chown(f.path(&file), Some(4321), Some(4321)).is_ok();
        let _ = symlink(&file, f.path(&link));
        f.done(&format!("{command} {link}"));
        assert!(std::fs::symlink_metadata(f.path(&link)).unwrap().is_symlink(), "{command}");
        assert!(f.read(&file).len() > 3, "{command}");
        let found = std::fs::metadata(f.path(&file)).unwrap();
        assert_eq!(found.mode() & 0o7777, 0o600, "{command}");
        assert!(!owner || (found.uid(), found.gid()) == (4321, 4321), "{command}");
        std::fs::remove_file(f.path(&file)).unwrap();

        f.write(&file, "kept");
        std::fs::set_permissions(f.path(&file), std::fs::Permissions::from_mode(0o444)).unwrap();
        assert_refused(&f.rhytid(&format!("{command} {file}")).output().unwrap(), &[&file, "read-only"]);
        assert_eq!(f.read(&file), b"kept");
        std::fs::remove_file(f.path(&file)).unwrap();
        f.assert_nothing_written();
    }
}

/// Two takes that differ in length, each written under the same name by its own process.
const RIVALS: [&str; 2] = ["0..17", "3..11"];

fn started(f: &Fixture, args: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_rhytid"))
        .args(args.split_whitespace())
        .current_dir(f.path("."))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// The number of frames of a file, which can be read from its first to its last frame.
fn frames(f: &Fixture, name: &str) -> usize {
    let mut animation = open_within(&f.path(name), Reach::Anywhere).unwrap();
    let frames = animation.summary().frames;
    let mut positions = Vec::new();
    for frame in 0..frames {
        animation.positions(frame, &mut positions).unwrap();
    }
    frames
}

#[test]
fn of_two_writers_one_wins_whole() {
    let f = prepared();
    for (ending, files) in [("gltf", 2), ("usd", 1)] {
        for round in 0..6 {
            let name = format!("out/face.{ending}");
            let mut rivals = RIVALS.map(|frames| {
                started(
                    &f,
                    &format!("animate face.safetensors take.csv --device cpu:0 --frames {frames} -o {name}"),
                )
            });
            for rival in &mut rivals {
                assert!(rival.wait().unwrap().success(), "{ending}, round {round}");
            }
            let found = frames(&f, &name);
            assert!(found == 17 || found == 8, "{ending}, round {round}: {found} frames");
            assert_eq!(list(&f.path("out")).len(), files, "{ending}, round {round}");
        }
        std::fs::remove_dir_all(f.path("out")).unwrap();
        std::fs::create_dir(f.path("out")).unwrap();
    }
}

/// Kills each command at moments spread over its whole run.
/// Afterwards the old or the new output is there. The next run removes leftover files.
#[test]
fn a_writer_that_is_killed_leaves_no_half_file() {
    let f = prepared();
    let animate = "animate face.safetensors take.csv --device cpu:0";
    for (command, name, files) in [
        (format!("{animate} --frames 0..17 -o"), "out/face.gltf", 2),
        (format!("{animate} --frames 0..17 -o"), "out/face.usd", 1),
        ("stitch part-a.usd part-b.usd -o".to_owned(), "out/all.usd", 2),
    ] {
        f.done(&format!("{command} {name}"));
        let started_at = std::time::Instant::now();
        f.done(&format!("{command} {name}"));
        let whole = started_at.elapsed();
        for round in 0..24 {
            let mut child = started(&f, &format!("{command} {name}"));
            std::thread::sleep(Duration::from_secs_f64(whole.as_secs_f64() * f64::from(round) / 22.0));
            let _ = child.kill();
            child.wait().unwrap();
            assert_eq!(frames(&f, name), 17, "{command} {name}, round {round}");
        }
        f.done(&format!("{command} {name}"));
        assert_eq!(frames(&f, name), 17, "{command} {name}");
        assert_eq!(list(&f.path("out")).len(), files, "{command} {name}: {:?}", list(&f.path("out")));
        std::fs::remove_dir_all(f.path("out")).unwrap();
        std::fs::create_dir(f.path("out")).unwrap();
    }
}
