//! Small files that demand very much. Each is read in time and memory proportional to its size, or refused
//! with a sentence.

use crate::common::Fixture;
use std::fmt::Write;
use std::time::Duration;

/// These files take milliseconds; a busy machine may take longer.
const SOON: Duration = Duration::from_secs(20);

fn soon(f: &Fixture, command: &str, code: i32, says: &str) {
    let output = f.rhytid(command).timeout(SOON).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let said = &said[..said.len().min(1_000)];
    assert!(output.status.code() == Some(code) && said.contains(says), "{command}: {said}");
}

#[test]
fn a_header_of_elements_without_end() {
    let f = Fixture::new();
    let mut ply = String::from("ply\nformat ascii 1.0\n");
    for i in 0..200_000 {
        writeln!(ply, "element e{i} 0\nproperty float a").unwrap();
    }
    f.write("elements.ply", ply + "end_header\n");
    soon(&f, "info elements.ply", 2, "expected at most 256 elements");
}

#[test]
fn strips_that_are_all_the_same() {
    let f = Fixture::new();
    f.write("s.bin", vec![0_u8; 36 + 120_000]);
    let strip = r#"{"attributes": {"POSITION": 0}, "indices": 1, "mode": 5}"#;
    let strips = vec![strip; 20_000].join(",");
    f.write(
        "strips.gltf",
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"uri": "s.bin", "byteLength": 120036}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}, {{"buffer": 0, "byteOffset": 36, "byteLength": 120000}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
            {{"bufferView": 1, "componentType": 5123, "count": 60000, "type": "SCALAR"}}],
            "meshes": [{{"primitives": [{strips}]}}], "nodes": [{{"mesh": 0}}], "scenes": [{{"nodes": [0]}}], "scene": 0}}"#
        ),
    );
    soon(&f, "info strips.gltf", 2, "from 120036 bytes of data");
}

#[test]
fn a_face_of_many_corners_and_a_vertex_of_many_faces() {
    let f = Fixture::new();
    let (mut ring, mut corners, mut spokes) = (String::from("v 0 0 0\n"), String::from("f"), String::new());
    let n = 5_000;
    for i in 0..n {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        writeln!(ring, "v {} {} 0", angle.cos() * f64::from(1 + i % 2), angle.sin()).unwrap();
        write!(corners, " {}", i + 2).unwrap();
        writeln!(spokes, "f 1 {} {}", i + 2, (i + 1) % n + 2).unwrap();
    }
    f.write("polygon.obj", format!("{ring}{corners}\n"));
    f.write("wheel.obj", format!("{ring}{spokes}"));
    soon(&f, "info polygon.obj", 2, "face 1 has 5000 corners, expected at most 4096");
    soon(
        &f,
        "info wheel.obj",
        2,
        "vertex 0 (counted from 0) is a corner of 5000 faces, expected at most 4096",
    );
}

#[test]
fn groups_without_end() {
    let f = Fixture::new();
    let mesh = f.obj(0.0);
    let faces = mesh.lines().filter(|line| line.starts_with('f')).count();
    let mut i = 0;
    let with_groups: String = mesh
        .lines()
        .map(|line| {
            let mut text = String::new();
            if line.starts_with('f') {
                for _ in 0..200_000 / faces {
                    writeln!(text, "g region{i}").unwrap();
                    i += 1;
                }
            }
            text + line + "\n"
        })
        .collect();
    f.write("neutral.obj", &with_groups);
    let project = f.read_text("face.toml") + "[pins]\ngroups = [\"nobody\"]\n";
    f.write("face.toml", project);
    soon(&f, "doctor face.toml", 2, "groups has \"nobody\"");
    let names: String = (0..100_000).fold("g".into(), |line, i| line + " a" + &i.to_string());
    f.write("neutral.obj", with_groups.replacen("\nf ", &format!("\n{names}\nf "), 1));
    soon(&f, "doctor face.toml", 2, "into 100000 groups at once, expected at most 64");
}

#[test]
fn a_gap_of_nine_hours() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let take = f.read_text("take.csv");
    let mut rows: Vec<String> = take.lines().take(4).map(str::to_owned).collect();
    let (_, last) = rows[3].split_once(',').unwrap();
    rows[3] = format!("32400,{last}");
    f.write("gap.csv", rows.join("\n") + "\n");
    let command = "animate face.safetensors gap.csv --fps 30 --device cpu:0 -o out/gap.usd";
    soon(&f, command, 2, "frame 2 comes 32400.0 s after the frame before it");
    f.assert_nothing_written();
}

#[test]
fn a_cell_longer_than_any_line() {
    let f = Fixture::new();
    f.write("handles.csv", format!("label,vertex\n{},0\nb,1\n", "a".repeat(70_000)));
    soon(&f, "info handles.csv", 0, "handle table");
    soon(&f, "info handles.csv --json", 0, "handle");
}
