//! Files that other files name must be in the same folder or below, unless the user allows others. Text from
//! files moves no cursor.
#![cfg(unix)]

use crate::common::{Fixture, assert_refused};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// A mesh in JSON whose numbers are in the file `uri`.
fn gltf(f: &Fixture, name: &str, uri: &str) {
    f.write(
        name,
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"uri": "{uri}", "byteLength": 36}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
            "nodes": [{{"mesh": 0}}], "scenes": [{{"nodes": [0]}}], "scene": 0}}"#
        ),
    );
}

#[test]
fn a_mesh_reads_nothing_above_its_folder() {
    let f = Fixture::new();
    let numbers: Vec<u8> =
        [0.0_f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()).collect();
    for place in ["secret.bin", "in/below/mesh.bin", "in/beside.bin", "in/with space.bin"] {
        f.write(place, &numbers);
    }
    assert!(Command::new("mkfifo").arg(f.path("in/pipe.bin")).status().unwrap().success());
    symlink("../secret.bin", f.path("in/link.bin")).unwrap();
    symlink("..", f.path("in/folder")).unwrap();
    symlink("/dev/zero", f.path("in/zero.bin")).unwrap();
    for uri in ["beside.bin", "below/mesh.bin", "./below/../beside.bin", "with%20space.bin"] {
        gltf(&f, "in/mesh.gltf", uri);
        f.done("info in/mesh.gltf");
    }
    let absolute = f.path("secret.bin").display().to_string();
    for uri in ["../secret.bin", "below/../../secret.bin", "%2e%2e/secret.bin", "..%2Fsecret.bin", &absolute]
        .into_iter()
        .chain(["link.bin", "folder/secret.bin", "zero.bin"])
    {
        gltf(&f, "in/mesh.gltf", uri);
        f.refused("info in/mesh.gltf", &["in/mesh.gltf", "expected a file beside it or below"]);
    }
    gltf(&f, "in/mesh.gltf", "pipe.bin");
    f.refused("info in/mesh.gltf", &["pipe.bin", "which is no file"]);
}

/// Many buffers of one file take its memory and time only once.
#[test]
fn a_file_that_many_buffers_name_is_read_once() {
    let f = Fixture::new();
    f.write("large.bin", vec![0_u8; 64 << 20]);
    gltf(&f, "mesh.gltf", "large.bin");
    let one = r#"{"uri": "large.bin", "byteLength": 36}"#;
    let text = f.read_text("mesh.gltf").replace(one, &[one; 400].join(", "));
    f.write("mesh.gltf", text);
    // 25 GB would not fit.
    let limited = format!("ulimit -v 4000000; exec {} info mesh.gltf", env!("CARGO_BIN_EXE_rhytid"));
    let output = Command::new("sh").current_dir(f.path("")).args(["-c", &limited]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("memory") && !said.contains("panic"), "{said}");
    assert!(matches!(output.status.code(), Some(0 | 2)), "{output:?}");
}

#[test]
fn a_project_names_files_elsewhere_only_if_the_user_says_so() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let expected = f.read("face.safetensors");
    let project = f.read_text("face.toml");
    let keys =
        [("neutral.obj", "[mesh] neutral"), ("markers.csv", "[handles] vertices"), ("poses/", "[[example]]")];
    for (name, key) in keys {
        assert!(project.contains(&format!("\"{name}")), "{project}");
        std::fs::remove_dir_all(f.path("in")).ok();
        f.write("in/face.toml", project.replace(&format!("\"{name}"), &format!("\"../{name}")));
        for file in ["neutral.obj", "markers.csv", "poses"] {
            if !file.starts_with(name.trim_end_matches('/')) {
                copy(&f.path(file), &f.path(format!("in/{file}")));
            }
        }
        for command in ["solve in/face.toml -o rig.safetensors", "doctor in/face.toml", "info in/face.toml"] {
            f.refused(command, &["in/face.toml", key, "--allow-elsewhere"]);
        }
    }
    f.write("in/face.toml", project.replace("\"poses/", "\"../poses/"));
    f.done("solve in/face.toml -o rig.safetensors --allow-elsewhere");
    assert!(f.read("rig.safetensors") == expected);
}

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap().flatten() {
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        std::fs::copy(from, to).unwrap();
    }
}

#[test]
fn a_setup_names_its_table_below() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.write("in/take.toml", "markers = \"../known.csv\"\n");
    f.write("known.csv", "handle,marker\n");
    let command = "prepare take.csv --rig face.safetensors --setup in/take.toml -o out.csv";
    f.refused(command, &["in/take.toml", "markers names ../known.csv", "--allow-elsewhere"]);
    let output = f.rhytid(&format!("{command} --allow-elsewhere")).output().unwrap();
    assert!(!String::from_utf8_lossy(&output.stderr).contains("elsewhere"), "{output:?}");
}

#[test]
fn parts_elsewhere_are_played_only_if_the_user_says_so() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (frames, part) in [("0..9", "a"), ("9..17", "b")] {
        f.done(&format!(
            "animate face.safetensors take.csv --device cpu:0 --frames {frames} -o part-{part}.usd"
        ));
    }
    std::fs::create_dir_all(f.path("in")).unwrap();
    f.done("stitch part-a.usd part-b.usd -o in/whole.usd");
    let verify = "verify in/whole.usd --rig face.safetensors --take take.csv --device cpu:0";
    for command in ["info in/whole.usd", verify] {
        f.refused(command, &["in/whole.usd", "assetPaths names ../part-a.usd", "--allow-elsewhere"]);
        f.done(&format!("{command} --allow-elsewhere"));
    }
}

#[test]
fn a_name_cannot_drive_the_terminal() {
    let f = Fixture::new();
    let evil = "\u{1b}]0;owned\u{7}\u{1b}[2J\u{9b}31m\u{202e}";
    let text = f.read_text("face.toml");
    f.write("evil.toml", text.replace("[mesh]\n", "[mesh]\nname = \"\\u001b[2J\\u009b31m\\u202e\"\n"));
    f.write("wrong.toml", format!("{text}\n[\"\\u001b[2J\"]\nx = 1\n"));
    f.write("take.csv", format!("time,{evil}_x,{evil}_y,{evil}_z\n0,1,2,3\n1,1,2,3\n"));
    f.write("handles-evil.csv", format!("label,vertex\n{evil},0\n"));
    for command in [
        "info evil.toml",
        "info evil.toml --json",
        "doctor wrong.toml",
        "info take.csv",
        "info take.csv --json",
        "info handles-evil.csv",
    ] {
        let output = f.rhytid(command).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8(said).unwrap();
        assert!(!said.contains(['\u{1b}', '\u{7}', '\u{9b}', '\u{202e}']), "{command}: {said:?}");
        assert!(said.contains("[2J"), "{command}: {said:?}");
        if command.ends_with("--json") {
            serde_json::from_str::<serde_json::Value>(&said).unwrap();
        }
    }
    assert_refused(&f.rhytid(&format!("info {}", "\u{1b}[2J.obj")).output().unwrap(), &["\\u{1b}[2J.obj"]);
}
