//! How `animate`, `export-shapes` and `verify` work together.

use crate::common::{Fixture, image, stderr};
use rhytid::core::{Backend, rig_file};
use rhytid::devices::cpu::Cpu;
use rhytid::formats::mesh;
use rhytid::{Animator, Stage, UploadOptions};
use serde_json::Value;

fn solved() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f
}

fn verify(f: &Fixture, file: &str, take: &str) -> (i32, Value) {
    let args = format!("verify {file} --rig face.safetensors --take {take} --json --device cpu:0");
    let output = f.rhytid(&args).output().unwrap();
    let code = output.status.code().unwrap();
    assert!(code != 2, "{}", stderr(&output));
    (code, serde_json::from_slice(&output.stdout).unwrap())
}

/// The fixture's take with the seven columns of a moving head.
fn take_with_head(f: &Fixture) -> String {
    let take = f.read_text("take.csv");
    let rows = take.trim_end().lines().enumerate().map(|(i, row)| match i {
        0 => format!("{row},head_qw,head_qx,head_qy,head_qz,head_tx,head_ty,head_tz"),
        _ => {
            let half = 0.02 * i as f64;
            let (sine, cosine) = half.sin_cos();
            format!("{row},{cosine},0,{sine},0,{},150,{}", 0.1 * i as f64, -0.2 * i as f64)
        }
    });
    rows.collect::<Vec<_>>().join("\n") + "\n"
}

/// Every format, and all options that it has.
const EXPORTS: [&str; 22] = [
    "face.usd",
    "face.usd --velocities --no-normals",
    "face.usda --velocities",
    "face.usdz",
    "face.usdc --stage large-scale --frames 3..17 --fps 24",
    "face.usdc --stage shell",
    "face.glb",
    "face.gltf --no-normals",
    "face.glb --quantize",
    "face.glb --meshopt",
    "face.gltf --quantize --meshopt",
    "face.glb --compressed",
    "face.glb --compressed --max-error 0.01 --no-normals",
    "face.glb --compressed --quantize --meshopt",
    "face.usdz --strain --velocities",
    "face.glb --strain",
    "face.gltf --strain --quantize --meshopt",
    "face.glb --strain --compressed --no-normals",
    "face.glb --strain --shapes 9",
    "face.glb --strain --vertex-ids --targets 20 --textures copy",
    "face.gltf --compressed --materials one",
    "face.usda --shapes 9 --strain-curves curves.csv",
];

#[test]
fn what_is_exported_is_verified() {
    let f = solved();
    f.write("moving.csv", take_with_head(&f));
    for take in ["take.csv", "moving.csv"] {
        for export in EXPORTS {
            f.done(&format!("animate face.safetensors {take} --device cpu:0 -o {export}"));
            let file = export.split(' ').next().unwrap();
            let (code, report) = verify(&f, file, take);
            assert_eq!((code, &report["passed"]), (0, &true.into()), "{export}: {report}");
            // USD has every bit; glTF states what its offsets, targets and integers round to.
            let stated = report["stated_mm"].as_f64();
            let is_exact = file.contains(".usd") && !export.contains("shapes");
            assert_eq!(stated.is_none(), is_exact, "{export}");
            let bound = match export {
                _ if export.contains("0.01") => 0.01,
                _ if export.contains("compressed") => 0.1,
                _ if export.contains("shapes") => 0.5,
                _ if export.contains("quantize") => 0.005,
                _ => 2e-4,
            };
            assert!(stated.is_none_or(|stated| stated <= bound), "{export}: {report}");
            // With one machine and one device the file's own error is the only difference.
            assert!(report["worst_mm"].as_f64().unwrap() <= stated.unwrap_or(0.0), "{export}: {report}");
            assert_eq!(report["normals_worst"].is_null(), export.contains("no-normals"), "{export}");
            assert_eq!(
                report["strain_rms"].is_null(),
                !export.contains("--strain ") && !export.ends_with("--strain"),
                "{export}"
            );
            assert_eq!(
                report["velocities_worst_mm_per_s"].is_null(),
                !export.contains("velocities"),
                "{export}"
            );
            assert_eq!(report["head_worst"].is_null(), take == "take.csv", "{export}");
        }
    }
}

#[test]
fn verify_finds_what_is_wrong() {
    let f = solved();
    f.write("moving.csv", take_with_head(&f));
    f.done("animate face.safetensors take.csv --device cpu:0 -o face.usd");
    // The first marker is a tenth of a millimetre off in frame 7.
    let take = f.read_text("take.csv");
    let mut rows: Vec<String> = take.lines().map(str::to_owned).collect();
    let mut cells: Vec<String> = rows[8].split(',').map(str::to_owned).collect();
    cells[1] = (cells[1].parse::<f64>().unwrap() + 0.01).to_string();
    rows[8] = cells.join(",");
    f.write("other.csv", rows.join("\n"));
    let (code, report) = verify(&f, "face.usd", "other.csv");
    assert_eq!((code, &report["passed"], &report["frame"]), (1, &false.into(), &7.into()), "{report}");
    assert!((report["worst_mm"].as_f64().unwrap() - 0.1).abs() < 0.03, "{report}");
    // The skin around the marker is compressed, and its wrinkles move it somewhat farther than the marker.
    let vertex = report["vertex"].as_u64().unwrap() as usize;
    assert!(vertex.abs_diff(f.handle(0)) % 21 <= 3, "{report}");

    // The same face, but a head that moves.
    let (code, report) = verify(&f, "face.usd", "moving.csv");
    assert_eq!((code, &report["passed"]), (1, &false.into()), "{report}");

    let output = f.rhytid("verify face.usd --rig face.safetensors --take other.csv -q").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("FAILS"));
}

#[test]
fn verify_refuses_what_cannot_be_compared() {
    let f = solved();
    f.done("animate face.safetensors take.csv --device cpu:0 -o face.usd");
    f.replace("face.toml", "bending_length = 3.0", "bending_length = 2.0");
    f.done("solve face.toml -o other.safetensors");
    let verify = "verify face.usd --take take.csv --rig";
    f.refused(&format!("{verify} other.safetensors"), &["face.usd", "another rig than other.safetensors"]);
    let short: Vec<String> = f.read_text("take.csv").lines().take(11).map(str::to_owned).collect();
    f.write("short.csv", short.join("\n"));
    f.refused("verify face.usd --rig face.safetensors --take short.csv", &["the frames 0..20", "10 frames"]);
    f.write("cut.usd", &f.read("face.usd")[..5000]);
    f.refused("verify cut.usd --rig face.safetensors --take take.csv", &["cut.usd"]);
    f.done("animate face.safetensors take.csv --device cpu:0 -o later.usda");
    let made = f.read_text("later.usda");
    for (known, unknown, what) in [
        (r#""stage" = "full""#, r#""stage" = "pores""#, r#"stage = "pores""#),
        (r#""missing" = "error""#, r#""missing" = "leave""#, r#"missing = "leave""#),
        (r#""head" = "keep""#, r#""head" = "nod""#, r#"head = "nod""#),
        ("\"fps\" = 0\n", "\"fps\" = -1\n", "fps = -1"),
    ] {
        assert!(made.contains(known), "{known}");
        f.write("later.usda", made.replace(known, unknown));
        let sentence = format!("was made with {what}");
        let remedy = ", which this program does not know; export it again";
        f.refused(
            "verify later.usda --rig face.safetensors --take take.csv",
            &["later.usda", &sentence, remedy],
        );
    }
    f.write("neutral.usda", "#usda 1.0\n");
    f.refused("verify neutral.usda --rig face.safetensors --take take.csv", &["neutral.usda"]);
    f.refused("verify absent.glb --rig face.safetensors --take take.csv", &["absent.glb", "no such file"]);
}

#[test]
fn options_of_another_format_are_refused() {
    let f = solved();
    let animate = "animate face.safetensors take.csv -o out/face";
    for option in [
        "--compressed",
        "--quantize",
        "--meshopt",
        "--force",
        "--targets 64",
        "--vertex-ids",
        "--materials one",
    ] {
        let name = option.split(' ').next().unwrap();
        f.refused(&format!("{animate}.usd {option}"), &["out/face.usd", name, ".glb"]);
    }
    f.refused(&format!("{animate}.pc2 --textures none"), &["out/face.pc2", "--textures", "glTF"]);
    f.refused(
        &format!("{animate}.glb --targets 19"),
        &["20 frames", "limit of 19 morph targets", "--targets"],
    );
    f.refused(&format!("{animate}.glb --velocities"), &["out/face.glb", "--velocities", ".usd"]);
    let output = f.rhytid(&format!("{animate}.glb --max-error 1")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--compressed"), "{}", stderr(&output));
    f.refused(&format!("{animate}.glb --compressed --max-error 0"), &["millimetres"]);
    f.assert_nothing_written();
}

/// The values of an attribute's samples in a `.usda`, as text, by time code.
fn samples(usda: &str, attribute: &str) -> Vec<String> {
    let samples = usda.split_once(&format!(" {attribute}.timeSamples = {{")).unwrap().1;
    let samples = samples.split_once('}').unwrap().0;
    samples
        .split("]")
        .map(|sample| sample.trim_start_matches(',').trim().to_owned())
        .filter(|s| !s.is_empty())
        .collect()
}

/// A part's frames equal those of the whole: its velocities use the frames beyond its ends.
#[test]
fn velocities_of_a_part_are_those_of_the_whole() {
    let f = solved();
    f.done("animate face.safetensors take.csv --device cpu:0 -o whole.usda --velocities");
    f.done("animate face.safetensors take.csv --device cpu:0 -o part.usda --velocities --frames 5..10");
    let (whole, part) = (f.read_text("whole.usda"), f.read_text("part.usda"));
    for attribute in ["points", "velocities"] {
        let (whole, part) = (samples(&whole, attribute), samples(&part, attribute));
        assert_eq!((whole.len(), part.len()), (20, 5), "{attribute}");
        assert!(part == whole[5..10], "{attribute}");
    }
}

/// The JSON chunk of a GLB file.
fn glb_json(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn shapes_are_named_after_examples_and_handles() {
    let f = solved();
    f.done("export-shapes face.safetensors -o shapes.glb --device cpu:0");
    let names = |f: &Fixture| glb_json(&f.read("shapes.glb"))["meshes"][0]["extras"]["targetNames"].clone();
    assert_eq!(names(&f), serde_json::json!(["pinch"]));
    f.done("export-shapes face.safetensors -o shapes.glb --device cpu:0 --handles");
    let names = names(&f);
    let names: Vec<&str> = names.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert_eq!(names.len(), 1 + 3 * 5);
    assert_eq!(names[..4], ["pinch", "left_x", "left_y", "left_z"]);
    f.done("export-shapes face.safetensors -o shapes.usda --device cpu:0 --handles");
    assert!(f.read_text("shapes.usda").contains("def BlendShape \"left_y\""));
}

/// The first `count` vectors of a GLB's accessor of floats.
fn glb_vectors(bytes: &[u8], accessor: &Value, count: usize) -> Vec<[f32; 3]> {
    let json = glb_json(bytes);
    let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
    assert_eq!((&accessor["componentType"], &accessor["type"]), (&5126.into(), &"VEC3".into()));
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let number = |value: &Value| value.as_u64().unwrap_or(0) as usize;
    let stride = view["byteStride"].as_u64().unwrap_or(12) as usize;
    // The header, the JSON and the bytes before the binary part.
    let begin = 28 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let begin = begin + number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
    let coordinate = |v: usize, c: usize| bytes[begin + v * stride + 4 * c..][..4].try_into().unwrap();
    (0..count).map(|v| std::array::from_fn(|c| f32::from_le_bytes(coordinate(v, c)))).collect()
}

/// An example's slider at 1 shows the scan. The handles' sliders together show the linear part of the
/// backend's result.
#[test]
fn shapes_are_the_examples_and_the_large_scale() {
    let f = Fixture::new();
    f.write("linear.toml", format!("{}\n[learned]\nreach = inf\n", f.read_text("face.toml")));
    f.done("solve linear.toml -o face.safetensors");
    let rig = rig_file::read(&f.path("face.safetensors")).unwrap();
    f.done("export-shapes face.safetensors -o shapes.glb --device cpu:0 --handles");
    let glb = f.read("shapes.glb");
    let primitive = &glb_json(&glb)["meshes"][0]["primitives"][0];
    let base = glb_vectors(&glb, &primitive["attributes"]["POSITION"], rig.vertices());
    let targets = primitive["targets"].as_array().unwrap();
    let shape = |k: usize| glb_vectors(&glb, &targets[k]["POSITION"], rig.vertices());
    let close = |found: [f32; 3], expected: [f64; 3], allowed: f64| {
        found.iter().zip(expected).all(|(a, b)| (f64::from(*a) - b).abs() < allowed)
    };

    let pinch = mesh::read(&f.path("poses/pinch.obj")).unwrap();
    let offsets = shape(0);
    for (v, expected) in pinch.positions.iter().enumerate() {
        let found = std::array::from_fn(|c| base[v][c] + offsets[v][c]);
        assert!(close(found, *expected, 1e-4), "vertex {v}: {found:?}, expected {expected:?}");
    }

    let slider = |k: usize| ((k * 7) % 11) as f32 * 0.1 - 0.5;
    let mut found = base.clone();
    for k in 0..3 * rig.handles().len() {
        for (position, offset) in found.iter_mut().zip(shape(1 + k)) {
            (0..3).for_each(|c| position[c] += slider(k) * offset[c]);
        }
    }
    let rest = rig.handles().rest.as_flattened().iter().enumerate();
    let handles: Vec<f32> = rest.map(|(i, x)| x + slider(i)).collect();
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, &rig, UploadOptions::frames(1)).unwrap();
    animator.evaluate(&handles).unwrap();
    let mut expected = Vec::new();
    animator.read(Stage::LargeScale, &mut expected).unwrap();
    for (v, (found, expected)) in found.iter().zip(expected.as_chunks::<3>().0).enumerate() {
        assert!(close(*found, expected.map(f64::from), 1e-5), "vertex {v}: {found:?}, expected {expected:?}");
    }
}

/// Without texture coordinates, no program can show the images of the materials.
#[test]
fn images_without_texture_coordinates_are_a_warning() {
    let f = Fixture::new();
    f.replace("neutral.obj", "# a sheet\n", "mtllib skin.mtl\nusemtl skin\n");
    f.write("skin.mtl", "newmtl skin\nmap_Kd skin.png\n");
    f.write("skin.png", image([90, 60, 50]));
    let solve = || stderr(&f.rhytid("solve face.toml -o face.safetensors").output().unwrap());
    assert!(!solve().contains("texture coordinates"));
    let neutral = f.read_text("neutral.obj");
    let without =
        neutral.lines().filter(|line| !line.starts_with("vt ")).map(|line| match line.starts_with("f ") {
            true => {
                line.split(' ').map(|corner| corner.split('/').next().unwrap()).collect::<Vec<_>>().join(" ")
            }
            false => line.to_owned(),
        });
    f.write("neutral.obj", without.collect::<Vec<_>>().join("\n"));
    let said = solve();
    assert!(said.contains("neutral.obj: has images and no texture coordinates"), "{said}");
}
