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

/// The header of a PNG of this size: an image of zeros follows, if `has_data`.
fn png_of(width: u32, height: u32, has_data: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().unwrap();
    if has_data {
        let mut stream = writer.stream_writer().unwrap();
        let row = vec![0; width as usize];
        (0..height).for_each(|_| std::io::Write::write_all(&mut stream, &row).unwrap());
        stream.finish().unwrap();
    }
    drop(writer);
    bytes
}

/// A few bytes of a picture can announce any size.
#[test]
fn pictures_larger_than_memory() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.write("huge.png", png_of(1 << 30, 1 << 30, false));
    f.write("large.png", png_of(20_000, 20_000, true));
    f.write("fine.png", png_of(64, 64, true));
    assert!(f.read("large.png").len() < 500_000);
    let project = f.read_text("face.toml");
    let mesh = "mesh = \"poses/pinch.obj\"\n";
    for map in ["huge", "large"] {
        let pixels = if map == "huge" {
            "pixels, expected at most 67,108,864 in all"
        } else {
            "20,000 × 20,000 pixels"
        };
        let displacement = format!("{mesh}displacement = \"{map}.png\"\nmillimetres = 1\n");
        f.write("map.toml", project.replace(mesh, &displacement));
        for command in ["info map.toml", "doctor map.toml", "solve map.toml -o out/a.safetensors"] {
            soon(&f, command, 2, &format!("{map}.png: has "));
            soon(&f, command, 2, pixels);
            soon(&f, command, 2, "--max-pixels");
        }
        let render = "render face.safetensors take.csv --frames 0..1 --size 64x64 -o out/a.png";
        soon(&f, &format!("{render} --show textured --texture {map}.png"), 2, pixels);
        soon(&f, &format!("{render} --show matcap --matcap {map}.png"), 2, pixels);
    }
    f.assert_nothing_written();
    let displacement = format!("{mesh}displacement = \"fine.png\"\nmillimetres = 1\n");
    f.write("map.toml", project.replace(mesh, &displacement));
    soon(
        &f,
        "solve map.toml -o out/a.safetensors --max-pixels 4095",
        2,
        "64 × 64 pixels, expected at most 4,095",
    );
    f.done("solve map.toml -o out/a.safetensors --max-pixels 4096");
}

#[test]
fn a_palette_that_ends_within_a_colour() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 8, 8);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(&[0; 5][..]);
    encoder.write_header().unwrap().write_image_data(&[0; 64]).unwrap();
    f.write("map.png", bytes);
    let mesh = "mesh = \"poses/pinch.obj\"\n";
    let displacement = format!("{mesh}displacement = \"map.png\"\nmillimetres = 1\n");
    f.write("map.toml", f.read_text("face.toml").replace(mesh, &displacement));
    soon(&f, "solve map.toml -o out/a.safetensors", 2, "map.png: has a palette of 5 bytes");
    let render = "render face.safetensors take.csv --frames 0..1 --size 64x64 -o out/a.png";
    for picture in ["--show textured --texture map.png", "--show matcap --matcap map.png"] {
        soon(&f, &format!("{render} {picture}"), 2, "map.png: has a palette of 5 bytes");
    }
}

/// A file that is named many times is read and kept once.
#[cfg(target_os = "linux")]
#[test]
fn what_is_named_many_times_is_kept_once() {
    let f = Fixture::new();
    f.replace("neutral.obj", "f ", "usemtl a\nf ");
    f.done("solve face.toml -o face.safetensors");
    // 20 MB of picture that is none, 200 times; 8 MB of take, 600 times.
    f.write("big.png", vec![7; 20 << 20]);
    let mut mtl = String::new();
    (0..200).for_each(|i| writeln!(mtl, "newmtl m{i}\nmap_Kd big.png\nmap_Kd big.png").unwrap());
    f.write("a.mtl", mtl + "newmtl a\nmap_Kd big.png\n");
    f.write("long.csv", f.take(20_000));
    f.write("edit.toml", "[[add]]\ntake = \"long.csv\"\n".repeat(600));
    let render = "render face.safetensors take.csv --frames 0..1 --size 64x64 -o out/a.png";
    let textured = format!("{render} --show textured --texture a.mtl");
    let edited =
        "animate face.safetensors take.csv --edit edit.toml --frames 0..1 --device cpu:0 -o edited.usd";
    for (command, code, says) in [(textured.as_str(), 2, "a.mtl"), (edited, 0, "")] {
        // Drivers map much memory that they do not use, so what is measured is what is in use.
        let script = format!("{} {command}; code=$?; exit $code", env!("CARGO_BIN_EXE_rhytid"));
        let mut shell = std::process::Command::new("/bin/sh");
        shell.args(["-c", &format!("ulimit -d 2000000; {script}")]).current_dir(f.path("."));
        let output = shell.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let is_expected = output.status.code() == Some(code) && said.contains(says);
        assert!(is_expected && !said.contains("memory"), "{command}: {}", &said[..said.len().min(500)]);
    }
}

/// A take whose frames are too many to compare every one with every other.
#[test]
fn compressing_a_long_take() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.write("long.csv", f.take(3_000));
    for options in ["a.glb --compressed", "a.glb --shapes 8", "a.usd --shapes 8"] {
        let command = format!("animate face.safetensors long.csv --device cpu:0 -o out/{options}");
        soon(&f, &command, 0, "");
        let (file, _) = options.split_once(' ').unwrap();
        f.done(&format!("verify out/{file} --rig face.safetensors --take long.csv --device cpu:0"));
    }
}

/// Numbers with which nothing can be computed.
#[test]
fn numbers_beyond_reason() {
    let f = Fixture::new();
    let project = f.read_text("face.toml");
    f.write("fine.png", png_of(64, 64, true));
    let map = "mesh = \"poses/pinch.obj\"\ndisplacement = \"fine.png\"\nmillimetres = 1e308\n";
    f.write("map.toml", project.replace("mesh = \"poses/pinch.obj\"\n", map));
    soon(&f, "solve map.toml -o out/a.safetensors", 2, "millimetres is 1e308, expected");
    for (setting, words) in [
        ("marker_noise = 1e308", "marker_noise is 1e308, expected millimetres, a number from 0 to 1000"),
        ("ridge = 1e300", "ridge is 1e300, expected a number above 0, at most 1000000"),
        ("wrinkle_ridge = 1e300", "wrinkle_ridge is 1e300, expected a number above 0, at most 1000000"),
    ] {
        f.write("learned.toml", format!("{project}[learned]\n{setting}\n"));
        soon(&f, "solve learned.toml -o out/a.safetensors", 2, words);
    }
    f.assert_nothing_written();
}
