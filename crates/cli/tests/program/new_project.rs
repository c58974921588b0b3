//! `rhytid new` on what people have: shapes in one file, poses in another unit, a scan beside the program.

use crate::common::{assert_refused, demo, rhytid, stderr};
use rhytid::formats::mesh::{self, shape_groups};
use rhytid::formats::project;
use rhytid::formats::{Reach, usd};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs a command in a folder; it must succeed.
fn done(command: &str, folder: &Path) -> String {
    let output = rhytid(command).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(command: &str, folder: &Path) -> Value {
    serde_json::from_str(&done(&format!("{command} --json"), folder)).unwrap()
}

fn names(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect()
}

/// An OBJ whose vertices are multiplied.
fn scaled(obj: &Path, factor: f64) -> String {
    let mut out = String::new();
    for line in fs::read_to_string(obj).unwrap().lines() {
        match line.strip_prefix("v ") {
            Some(numbers) => {
                let numbers: Vec<String> = numbers
                    .split_whitespace()
                    .map(|x| (x.parse::<f64>().unwrap() * factor).to_string())
                    .collect();
                out += &format!("v {}\n", numbers.join(" "));
            }
            None => out += &format!("{line}\n"),
        }
    }
    out
}

#[test]
fn poses_in_metres_beside_a_neutral_in_millimetres_are_taken_in() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("poses")).unwrap();
    fs::write(folder.join("neutral.obj"), scaled(&demo().join("neutral.obj"), 10.0)).unwrap();
    let poses: Vec<_> = fs::read_dir(demo().join("poses")).unwrap().flatten().collect();
    for pose in &poses {
        fs::write(folder.join("poses").join(pose.file_name()), scaled(&pose.path(), 0.01)).unwrap();
    }
    // Inside the folder of the scan.
    let made = json("new neutral.obj", folder);
    assert_eq!((made["unit"].as_str(), made["left_out"].as_array().unwrap().len()), (Some("mm"), 0));
    let taken_in = made["in_another_space"].as_array().unwrap();
    assert_eq!(taken_in.len(), poses.len());
    for space in taken_in {
        assert_eq!(names(&space["keys"]), ["unit = \"m\""]);
        assert_eq!(space["said"], "is 1000 times smaller than the neutral, as if it were in metres");
    }
    let face = project::read(&folder.join("face.toml"), Reach::Below).unwrap();
    for example in &face.examples {
        let pose = mesh::read(&demo().join(format!("poses/{}.obj", example.name))).unwrap();
        for (found, expected) in example.positions.iter().flatten().zip(pose.positions.iter().flatten()) {
            assert!((found - 10.0 * expected).abs() < 1e-3, "{found} {expected}");
        }
    }
    done("solve face.toml", folder);
}

#[test]
fn shapes_of_one_file_become_examples_in_gltf_and_in_usd() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["glb", "usd"] {
        let folder = folder.path().join(extension);
        fs::create_dir(&folder).unwrap();
        let file = format!("head.{extension}");
        done(
            &format!("export-shapes {} -o {file} --device cpu:0", demo().join("face.safetensors").display()),
            &folder,
        );
        let read = mesh::read_shapes(&folder.join(&file)).unwrap();
        let groups: Vec<String> = shape_groups(&read.shapes).into_iter().map(|group| group.name).collect();
        assert!(groups.len() >= 4, "{groups:?}");
        let made = json(&format!("new {file}"), &folder);
        assert_eq!(names(&made["examples"]), groups);
        // glTF is in metres, and the export in USD is in the demo's unit.
        assert_eq!(made["unit"], if extension == "glb" { "m" } else { "cm" });
        let solved = json("solve face.toml", &folder);
        assert_eq!(solved["examples"], groups.len());
        assert_eq!(solved["vertices"], read.neutral.positions.len());

        let chosen = json(&format!("new {file} --shapes {} -o chosen", groups[0]), &folder);
        assert_eq!(names(&chosen["examples"]), [groups[0].as_str()]);
        let output =
            rhytid(&format!("new {file} --shapes nothing* -o none")).current_dir(&folder).output().unwrap();
        assert_refused(&output, &["no shape fits \"nothing*\""]);

        // The file of the shapes may be named, also if it is the neutral.
        let named = json(&format!("new {file} --examples {file} -o named"), &folder);
        assert_eq!(named["examples"], made["examples"]);

        let info = json(&format!("info {file}"), &folder);
        assert_eq!(
            (info["kind"].as_str(), info["shapes"].as_array().unwrap().len()),
            (Some("shapes"), read.shapes.len())
        );
        assert!(info["details"][0]["vertices"].as_u64().unwrap() > 10, "{info}");
    }
}

#[test]
fn a_place_without_examples_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::copy(demo().join("neutral.obj"), folder.join("neutral.obj")).unwrap();
    fs::create_dir(folder.join("empty")).unwrap();
    fs::write(folder.join("noise.obj"), "v 0,5 0 0\n").unwrap();
    for (place, words) in [
        ("nowhere", "no such file or folder"),
        ("empty", "empty: has no mesh that could be an example; name a folder"),
        ("neutral.obj", "neutral.obj: has no mesh that could be an example"),
        ("noise.obj", "noise.obj: has no example (noise.obj: line 1: found \"0,5\""),
    ] {
        let new = format!("new neutral.obj --examples {place} -o out");
        let output = rhytid(&new).current_dir(folder).output().unwrap();
        assert_refused(&output, &[place, words]);
        assert!(!folder.join("out").exists());
    }
    let pose = fs::read_dir(demo().join("poses")).unwrap().flatten().next().unwrap().path();
    fs::copy(&pose, folder.join("pose.obj")).unwrap();
    let made = json("new neutral.obj --examples pose.obj -o out", folder);
    assert_eq!(names(&made["examples"]), ["pose"]);
}

/// A mesh with another unit and another up axis than its take: the next command is one that works.
#[test]
fn the_next_command_brings_the_take_into_the_faces_space() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("poses")).unwrap();
    // Z points up, and millimetres.
    let turned = |obj: &Path| {
        let mut out = String::new();
        for line in scaled(obj, 10.0).lines() {
            let numbers: Vec<&str> = line.strip_prefix("v ").unwrap_or_default().split(' ').collect();
            match numbers[..] {
                [x, y, z] => out += &format!("v {x} {} {y}\n", -z.parse::<f64>().unwrap()),
                _ => out += &format!("{line}\n"),
            }
        }
        out
    };
    fs::write(folder.join("neutral.obj"), turned(&demo().join("neutral.obj"))).unwrap();
    for pose in fs::read_dir(demo().join("poses")).unwrap().flatten() {
        fs::write(folder.join("poses").join(pose.file_name()), turned(&pose.path())).unwrap();
    }
    let take = demo().join("performance.csv");
    let new = format!("new neutral.obj --take {}", take.display());
    let made = json(&new, folder);
    let options = names(&made["take_options"]).join(" ");
    assert_eq!(options, "--take-unit cm --take-axes=+x-z+y");
    done("solve face.toml", folder);
    let animate =
        format!("animate face.safetensors {} --frames 0..3 --device cpu:0 -o face.usd", take.display());
    assert_eq!(rhytid(&animate).current_dir(folder).output().unwrap().status.code(), Some(2));
    done(&format!("{animate} {options}"), folder);
    let said = done(&format!("{new} -o again"), folder);
    assert!(said.contains(&format!("face.usd {options}\n")), "{said}");
    // A take of the same space needs nothing.
    fs::copy(demo().join("neutral.obj"), folder.join("again/neutral.obj")).unwrap();
    let same = json(&format!("new again/neutral.obj --take {} -o same", take.display()), folder);
    assert_eq!(same["take_options"], serde_json::json!([]));
}

#[test]
fn the_reason_why_a_file_is_left_out_is_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::copy(demo().join("neutral.obj"), folder.join("neutral.obj")).unwrap();
    fs::create_dir(folder.join("poses")).unwrap();
    let pose = |name: &str, text: &str| fs::write(folder.join("poses").join(name), text).unwrap();
    pose("comma.obj", "v 0,5 0 0\n");
    pose("other.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n");
    pose("same.obj", &fs::read_to_string(demo().join("neutral.obj")).unwrap());
    pose("gone.glb", "version https://git-lfs.github.com/spec/v1\n");
    let made = json("new neutral.obj", folder);
    let why = |name: &str| {
        let all = made["left_out"].as_array().unwrap();
        let found = all.iter().find(|left| left["file"] == format!("poses/{name}")).unwrap();
        found["why"].as_str().unwrap().to_owned()
    };
    assert!(why("comma.obj").starts_with("line 1: found \"0,5\""), "{}", why("comma.obj"));
    assert!(why("comma.obj").contains("decimal commas"), "{}", why("comma.obj"));
    assert_eq!(why("same.obj"), "is the neutral itself");
    assert!(why("gone.glb").contains("git lfs pull"), "{}", why("gone.glb"));
    assert!(!why("other.ply").is_empty());
}

#[test]
fn a_unit_may_be_a_number_and_a_stated_one_counts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::copy(demo().join("neutral.obj"), folder.join("neutral.obj")).unwrap();
    assert_eq!(json("new neutral.obj --unit 0.02 -o a", folder)["unit"], "0.02");
    let output = rhytid("new neutral.obj --unit parsec -o b").current_dir(folder).output().unwrap();
    assert_refused(&output, &["expected m, cm, mm, in, ft or a number above 0"]);

    // The neutral with one vertex far away that no face has: its surface says the unit.
    let stray = fs::read_to_string(demo().join("neutral.obj")).unwrap() + "v 90000 0 0\n";
    fs::write(folder.join("stray.obj"), stray).unwrap();
    assert_eq!(json("new stray.obj -o c", folder)["unit"], "cm");
}

#[test]
fn a_head_named_by_its_part_is_the_one_with_handles() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Two heads beside one another, as groups.
    let head = fs::read_to_string(demo().join("neutral.obj")).unwrap();
    let vertices = head.lines().filter(|line| line.starts_with("v ")).count();
    let (mut both, mut faces) = (String::new(), String::new());
    for (number, name) in ["anna", "ben"].iter().enumerate() {
        faces += &format!("g {name}\n");
        for line in head.lines() {
            if let Some(place) = line.strip_prefix("v ") {
                let place: Vec<f64> = place.split_whitespace().map(|x| x.parse().unwrap()).collect();
                both += &format!("v {} {} {}\n", place[0] + 30.0 * number as f64, place[1], place[2]);
            } else if let Some(face) = line.strip_prefix("f ") {
                let corner = |corner: &str| {
                    let vertex: usize = corner.split('/').next().unwrap().parse().unwrap();
                    (vertex + number * vertices).to_string()
                };
                let corners: Vec<String> = face.split_whitespace().map(corner).collect();
                faces += &format!("f {}\n", corners.join(" "));
            }
        }
    }
    fs::write(folder.join("two.obj"), both + &faces).unwrap();
    let made = json("new two.obj --part ben -o made", folder);
    assert_eq!(made["head"], "the part \"ben\", as wished");
    let table = fs::read_to_string(folder.join("made/markers.csv")).unwrap();
    let placed: Vec<usize> =
        table.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    assert!(placed.len() > 60 && placed.iter().all(|v| *v >= vertices), "{placed:?}");
    let output = rhytid("new two.obj --part carl -o other").current_dir(folder).output().unwrap();
    assert_refused(&output, &["no part of the mesh is called \"carl\"; it has \"anna\", \"ben\""]);
}

/// A layer of USD that another program could have written is what its prims say.
#[test]
fn info_tells_a_usd_mesh_from_an_animation() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.usda");
    let text = "#usda 1.0\ndef Mesh \"a\" { point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] int[] faceVertexCounts = [3] \
                int[] faceVertexIndices = [0,1,2] }\n";
    fs::write(&path, text).unwrap();
    assert!(usd::read::open(&path).is_ok());
    let info = json("info square.usda", folder.path());
    assert_eq!((info["kind"].as_str(), info["vertices"].as_u64()), (Some("mesh"), Some(3)));
}

#[test]
fn a_warning_about_a_file_that_is_read_again_comes_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let neutral = fs::read_to_string(demo().join("neutral.obj")).unwrap();
    fs::write(folder.join("neutral.obj"), neutral + "f 1 2\n").unwrap();
    let output = rhytid("new neutral.obj -o face").current_dir(folder).output().unwrap();
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    let warnings: Vec<&str> = said.lines().filter(|line| line.contains("fewer than 3 corners")).collect();
    assert_eq!(warnings.len(), 1, "{said}");
}
