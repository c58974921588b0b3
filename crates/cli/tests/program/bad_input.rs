//! Input that cannot be used: each is refused with one clear sentence, exit code 2 and nothing written.

use crate::common::{Fixture, garbage};

// Meshes

#[test]
fn a_truncated_obj() {
    let f = Fixture::new();
    let obj = f.obj(0.0);
    // In the middle of the last vertex, and so before any face.
    let end = obj.find("\nvt").unwrap() - 12;
    f.write("neutral.obj", &obj[..end]);
    f.solve_refused(&["neutral.obj", "line 442"]);
}

#[test]
fn an_obj_truncated_in_its_faces() {
    let f = Fixture::new();
    let obj = f.obj(0.3);
    f.write("poses/pinch.obj", &obj[..obj.len() - 400]);
    f.solve_refused(&["pinch", "face"]);
}

#[test]
fn a_truncated_ply() {
    let f = Fixture::new();
    let ply = f.ply();
    f.replace("face.toml", "neutral.obj", "neutral.ply");
    for len in [ply.len() - 1, ply.len() / 2, 240, 40, 3, 0] {
        f.write("neutral.ply", &ply[..len]);
        f.solve_refused(&["neutral.ply"]);
    }
}

#[test]
fn a_truncated_glb() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.done("animate face.safetensors take.csv -o neutral.glb --frames 0..1");
    let glb = f.read("neutral.glb");
    f.replace("face.toml", "neutral.obj", "neutral.glb");
    for len in [glb.len() - 1, glb.len() / 2, 100, 15, 3, 0] {
        f.write("neutral.glb", &glb[..len]);
        f.solve_refused(&["neutral.glb"]);
    }
}

#[test]
fn binary_garbage() {
    for name in ["neutral.obj", "neutral.ply", "neutral.glb", "neutral.gltf"] {
        let f = Fixture::new();
        f.write("face.toml", f.read_text("face.toml").replace("neutral.obj", name));
        f.write(name, garbage(5000));
        f.solve_refused(&[name]);
        // With the right beginning, then garbage.
        let magic: &[u8] = match name {
            "neutral.ply" => b"ply\nformat binary_little_endian 1.0\nelement vertex 9\n",
            "neutral.glb" => b"glTF\x02\0\0\0\x88\x13\0\0",
            _ => b"v 0 0 0\n",
        };
        f.write(name, [magic, &garbage(5000 - magic.len())].concat());
        f.solve_refused(&[name]);
    }
}

#[test]
fn a_mesh_of_an_unknown_kind() {
    let f = Fixture::new();
    f.replace("face.toml", "neutral.obj", "neutral.fbx");
    f.write("neutral.fbx", "Kaydara");
    f.solve_refused(&["neutral.fbx", "obj", "ply", "glb"]);
}

#[test]
fn an_obj_index_out_of_range() {
    let f = Fixture::new();
    f.replace("neutral.obj", "f 1/1 2/2", "f 1/1 9999/2");
    f.solve_refused(&["neutral.obj", "line 884", "9999", "441"]);
}

#[test]
fn coordinates_that_are_not_finite() {
    for bad in ["nan", "inf", "-inf", "1e999"] {
        let f = Fixture::new();
        f.replace("neutral.obj", "v -5.000000", &format!("v {bad}"));
        f.solve_refused(&["neutral.obj", "line 2"]);
    }
    let f = Fixture::new();
    let mut ply = f.ply();
    let start = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    ply[start..start + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    f.write("neutral.ply", ply);
    f.replace("face.toml", "neutral.obj", "neutral.ply");
    f.solve_refused(&["neutral.ply"]);
}

#[test]
fn a_mesh_of_zero_faces() {
    let f = Fixture::new();
    let obj = f.obj(0.0);
    f.write("neutral.obj", &obj[..obj.find("f 1/1").unwrap()]);
    f.solve_refused(&["neutral.obj", "face"]);
}

#[test]
fn an_example_with_another_vertex_count() {
    let f = Fixture::new();
    f.write("poses/pinch.obj", Fixture::with_side(20).obj(0.3));
    f.solve_refused(&["pinch", "400", "441"]);
}

#[test]
fn an_example_with_other_faces() {
    let f = Fixture::new();
    f.replace("poses/pinch.obj", "f 1/1 2/2 23/23 22/22", "f 1/1 2/2 24/24 22/22");
    f.solve_refused(&["pinch", "face"]);
}

#[test]
fn a_mesh_that_is_not_there() {
    let f = Fixture::new();
    std::fs::remove_file(f.path("poses/pinch.obj")).unwrap();
    f.solve_refused(&["pinch.obj", "does not exist"]);
}

// Handles, strain edges and the project

#[test]
fn duplicate_labels() {
    let f = Fixture::new();
    f.replace("markers.csv", "right,", "left,");
    f.solve_refused(&["markers.csv", "left"]);
}

#[test]
fn two_handles_at_one_vertex() {
    let f = Fixture::new();
    f.replace("markers.csv", &format!("right,{}", f.handle(1)), &format!("right,{}", f.handle(0)));
    f.solve_refused(&["right", "left"]);
}

#[test]
fn an_unknown_label_in_the_strain_edges() {
    let f = Fixture::new();
    f.write("edges.csv", "a,b\nleft,middle\nleft,rihgt\n");
    f.replace("face.toml", "\"auto\"", "\"edges.csv\"");
    f.solve_refused(&["edges.csv", "line 3", "rihgt"]);
}

#[test]
fn a_handle_past_the_end() {
    let f = Fixture::new();
    f.replace("markers.csv", &format!("right,{}", f.handle(1)), "right,441");
    f.solve_refused(&["markers.csv", "right", "441", "440"]);
}

#[test]
fn a_handle_that_is_no_number() {
    for bad in ["-1", "1.5", "x", "", "99999999999999999999"] {
        let f = Fixture::new();
        f.replace("markers.csv", &format!("right,{}", f.handle(1)), &format!("right,{bad}"));
        f.solve_refused(&["markers.csv", "line 3"]);
    }
}

#[test]
fn zero_handles() {
    let f = Fixture::new();
    f.write("markers.csv", "label,vertex\n");
    f.solve_refused(&["markers.csv", "no handles"]);
    f.write("markers.csv", "");
    f.solve_refused(&["markers.csv"]);
}

#[test]
fn no_examples_give_the_large_scale_alone() {
    let f = Fixture::new();
    f.replace("face.toml", "[[example]]\nname = \"pinch\"\nmesh = \"poses/pinch.obj\"\n", "");
    f.done("solve face.toml -o out/face.safetensors");
    f.done("animate out/face.safetensors take.csv -o out/face.usda");
    f.done("animate out/face.safetensors take.csv -o out/coarse.usda --stage large-scale");
    let coarse = f
        .read_text("out/coarse.usda")
        .replace("string \"stage\" = \"large-scale\"", "string \"stage\" = \"full\"");
    assert!(f.read_text("out/face.usda") == coarse);
}

#[test]
fn an_unknown_key_suggests_the_nearest() {
    let f = Fixture::new();
    f.replace("face.toml", "bending_length", "bending_lenght");
    f.solve_refused(&["face.toml", "bending_lenght", "bending_length"]);
}

#[test]
fn a_project_that_is_not_toml() {
    let f = Fixture::new();
    for bad in [garbage(300), b"[mesh\n".to_vec(), b"".to_vec()] {
        f.write("face.toml", bad);
        f.solve_refused(&["face.toml"]);
    }
}

#[test]
fn a_project_that_is_not_there() {
    let f = Fixture::new();
    f.refused("solve missing.toml -o out/face.safetensors", &["missing.toml", "no such file"]);
    f.refused("doctor missing.toml", &["missing.toml", "no such file"]);
    f.refused("info missing.toml", &["missing.toml", "no such file"]);
    f.refused("info poses", &["poses"]);
}

// Takes

fn solved() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f
}

const ANIMATE: &str = "animate face.safetensors take.csv -o out/face.usda";

#[test]
fn a_take_that_lacks_a_handle() {
    let f = solved();
    f.write("take.csv", f.take(3).replace("middle_", "centre_"));
    f.refused(ANIMATE, &["middle"]);
}

#[test]
fn a_take_with_unknown_labels_is_a_warning() {
    let f = solved();
    let take = f.take(1).trim_end().replace("middle_z", "middle_z,nose_x,nose_y,nose_z") + ",1,2,3\n";
    f.write("take.csv", take);
    let output = f.rhytid(ANIMATE).output().unwrap();
    assert!(output.status.success());
    let stderr = crate::common::stderr(&output);
    assert!(stderr.lines().any(|l| l.starts_with("warning: ") && l.contains("nose")), "{stderr}");
}

/// The take with the x of `left` in frame 2 replaced.
fn with_cell(f: &Fixture, cell: &str) -> String {
    let take = f.take(5);
    let lines = take.lines().enumerate().map(|(i, line)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if i == 3 {
            cells[1] = cell;
        }
        cells.join(",") + "\n"
    });
    lines.collect()
}

#[test]
fn a_marker_that_is_missing_from_a_frame() {
    let f = solved();
    for cell in ["", "NaN", "inf"] {
        f.write("take.csv", with_cell(&f, cell));
        f.refused(ANIMATE, &["take.csv", "left", "frame 2", "--missing hold"]);
    }
    f.done(&format!("{ANIMATE} --missing hold"));
}

#[test]
fn a_take_that_is_no_take() {
    let f = solved();
    f.write("take.csv", with_cell(&f, "abc"));
    f.refused(ANIMATE, &["take.csv", "line 4", "abc"]);
    let take = f.take(5);
    for bad in [garbage(3000), b"".to_vec(), take.as_bytes()[..take.len() - 30].to_vec()] {
        f.write("take.csv", bad);
        f.refused(ANIMATE, &["take.csv"]);
    }
    f.write("take.csv", f.take(0));
    f.refused(ANIMATE, &["take.csv", "no frames"]);
}

// Options

#[test]
fn frames_outside_the_take() {
    let f = solved();
    f.refused(&format!("{ANIMATE} --frames 10..21"), &["10..21", "20 frames"]);
    f.refused(&format!("{ANIMATE} --frames 20.."), &["20..", "20 frames"]);
    f.refused(&format!("{ANIMATE} --frames 7..3"), &["7..3"]);
    f.refused(&format!("{ANIMATE} --frames x"), &["A..B"]);
}

#[test]
fn a_device_that_is_absent() {
    let f = solved();
    f.refused(&format!("{ANIMATE} --device vulkan:7"), &["vulkan:7", "cpu:0"]);
    f.refused(&format!("{ANIMATE} --device cpu:99"), &["cpu:99", "cpu:0"]);
    f.done(&format!("{ANIMATE} --device cpu:0"));
}

#[test]
fn rates_that_make_no_sense() {
    let f = solved();
    for bad in ["0", "-30", "nan", "inf", "x"] {
        f.refused(&format!("{ANIMATE} --fps={bad}"), &["--fps"]);
    }
}

#[test]
fn an_unknown_output_format() {
    let f = solved();
    f.refused("animate face.safetensors take.csv -o out/face.fbx", &["face.fbx", ".usda", ".glb"]);
    f.refused("animate face.safetensors take.csv -o out/face", &["out/face", ".usda", ".glb"]);
    f.refused("solve face.toml -o out/face.rig", &["face.rig", ".safetensors"]);
    f.refused("info out", &["out", ".obj"]);
}

#[test]
fn a_mistyped_command_line() {
    let f = Fixture::new();
    f.refused("slove face.toml -o out/face.safetensors", &["slove"]);
    f.refused("animate face.safetensors take.csv", &["required"]);
    for vertices in ["3", "1999", "4000001"] {
        f.refused(&format!("demo out --vertices {vertices}"), &[vertices, "2000", "4000000"]);
    }
}
