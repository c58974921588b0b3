//! `--edit EDIT.toml` and `correct`: what is applied, what files say about it, and how `verify` treats it.

use crate::common::{Fixture, assert_refused};
use rhytid::formats::animation;

const EDIT: &str = "[[gain]]\nregion = \"top\"\nby = [[2, 1], [6, 2]]\n[[hold]]\nframes = \"12..15\"\n[[detail]]\nby = [[8, 1], [10, 0.5]]\n";

fn positions(f: &Fixture, file: &str) -> Vec<Vec<f32>> {
    let mut reader = animation::open(&f.path(file)).unwrap();
    let frame = |i| {
        let mut positions = Vec::new();
        reader.positions(i, &mut positions).unwrap();
        positions
    };
    (0..20).map(frame).collect()
}

fn solved() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.write("EDIT.toml", EDIT);
    f
}

#[test]
fn edits_are_in_the_file_and_verify_needs_the_same() {
    let f = solved();
    f.done("animate face.safetensors take.csv -o plain.usd --device cpu:0");
    for name in ["edited.usd", "edited.usda", "edited.glb"] {
        f.done(&format!("animate face.safetensors take.csv -o {name} --edit EDIT.toml --device cpu:0"));
        f.done(&format!(
            "verify {name} --rig face.safetensors --take take.csv --edit EDIT.toml --device cpu:0"
        ));
        let verify = format!("verify {name} --rig face.safetensors --take take.csv --device cpu:0");
        f.refused(&verify, &["was made with edits; give the same with --edit EDIT.toml"]);
        f.write("OTHER.toml", format!("{EDIT}\n"));
        f.refused(&format!("{verify} --edit OTHER.toml"), &["was made with other edits"]);
        let info: serde_json::Value = serde_json::from_str(&f.done(&format!("info {name} --json"))).unwrap();
        assert_eq!(info["provenance"]["edit"], EDIT);
    }
    f.refused(
        "verify plain.usd --rig face.safetensors --take take.csv --edit EDIT.toml",
        &["was made without edits; leave --edit out"],
    );
    // Frames before the first key have the same bits. So do frames that no edit concerns any more.
    let [plain, edited] = ["plain.usd", "edited.usd"].map(|name| positions(&f, name));
    assert!(plain[..3] == edited[..3]);
    assert!(plain[3..].iter().zip(&edited[3..]).all(|(a, b)| a != b));
    assert_eq!((&edited[13], &edited[14]), (&edited[12], &edited[12]), "held");
    // Parts with different edits cannot be stitched.
    f.done("animate face.safetensors take.csv -o a.usd --frames ..10 --device cpu:0 --edit EDIT.toml");
    f.done("animate face.safetensors take.csv -o b.usd --frames 10.. --device cpu:0");
    f.refused("stitch a.usd b.usd -o c.usd", &["edit_hash: none and "]);
}

#[test]
fn a_sculpted_frame_comes_back_as_a_correction_and_as_an_example() {
    let f = solved();
    let said = f.done("correct face.safetensors take.csv --frame 11 -o pose.obj --edit EDIT.toml");
    assert!(said.contains("[[correction]]") && said.contains("frame = 11"), "{said}");
    f.done("animate face.safetensors take.csv -o plain.usd --device cpu:0 --edit EDIT.toml");
    let frame = &positions(&f, "plain.usd")[11];
    let vertices = |text: &str| -> Vec<f32> {
        let rows = text.lines().filter_map(|line| line.strip_prefix("v "));
        rows.flat_map(|row| row.split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f32>>())
            .collect()
    };
    assert_eq!(&vertices(&f.read_text("pose.obj")), frame, "the frame as it is played");
    // A vertex that is no handle, moved by 3 mm.
    let rows: Vec<String> = f.read_text("pose.obj").lines().map(str::to_owned).collect();
    let vertex = (0..).find(|v| !(0..5).any(|h| f.handle(h) == *v)).unwrap();
    let mut number = 0;
    let sculpted: String = rows
        .iter()
        .map(|row| match row.strip_prefix("v ") {
            Some(x) => {
                number += 1;
                let mut x: Vec<f64> = x.split_whitespace().map(|x| x.parse().unwrap()).collect();
                x[2] += if number - 1 == vertex { 0.3 } else { 0.0 };
                format!("v {} {} {}\n", x[0], x[1], x[2])
            }
            None => format!("{row}\n"),
        })
        .collect();
    f.write("sculpted.obj", &sculpted);
    f.write(
        "CORRECT.toml",
        format!("{EDIT}[[correction]]\nmesh = \"sculpted.obj\"\nframe = 11\nreach = 0.01\n"),
    );
    let output = f
        .rhytid("animate face.safetensors take.csv -o c.usd --device cpu:0 --edit CORRECT.toml")
        .output()
        .unwrap();
    let said = crate::common::stderr(&output);
    assert!(said.contains("correction of frame 11: 1 vertices by up to 3 mm"), "{said}");
    let found = &positions(&f, "c.usd")[11];
    let worst = vertices(&sculpted).iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-5, "{worst}");
    f.done("verify c.usd --rig face.safetensors --take take.csv --edit CORRECT.toml --device cpu:0");

    // The files that edits name are inputs, and are not overwritten.
    for (command, words) in [
        ("correct face.safetensors take.csv --frame 3 -o sculpted.obj --edit CORRECT.toml", "sculpted.obj"),
        ("animate face.safetensors take.csv -o x.usd --strain-curves OTHER.csv --edit ADD.toml", "OTHER.csv"),
    ] {
        f.write("OTHER.csv", f.read_text("take.csv"));
        f.write("ADD.toml", "[[add]]\ntake = \"OTHER.csv\"\n");
        let kept = [f.read("sculpted.obj"), f.read("OTHER.csv")];
        f.refused(command, &[words, "read"]);
        assert!(kept == [f.read("sculpted.obj"), f.read("OTHER.csv")], "{command}");
    }
    // A mesh of another frame is probably a mistake.
    f.write("WRONG.toml", "[[correction]]\nmesh = \"neutral.obj\"\nframe = 11\n");
    let wrong = f.rhytid("animate face.safetensors take.csv -o w.usd --device cpu:0 --edit WRONG.toml");
    let said = crate::common::stderr(&{ wrong }.output().unwrap());
    assert!(said.contains("its mesh may be of another frame"), "{said}");

    let project = f.read_text("face.toml");
    f.write("more.toml", format!("{project}\n[[example]]\nname = \"eleven\"\nmesh = \"sculpted.obj\"\ntake = \"take.csv\"\nframe = 11\n"));
    let said = f.done("solve more.toml -o more.safetensors");
    assert!(said.contains("sculpted (eleven): frame 11 changes by up to"), "{said}");
    for (from, to, words) in [
        (
            "frame = 11",
            "frame = 20",
            "has 20 frames, counted from 0, but [[example]] \"eleven\" is its frame 20",
        ),
        ("frame = 11\n", "", "lacks the key frame, expected one beside take"),
        ("take = \"take.csv\"\n", "", "has frame without take"),
    ] {
        f.write("wrong.toml", f.read_text("more.toml").replace(from, to));
        f.refused("solve wrong.toml -o wrong.safetensors", &[words]);
    }
    f.refused(
        "correct face.safetensors take.csv --frame 20 -o x.obj",
        &["--frame 20: take.csv has 20 frames"],
    );
    f.refused("correct face.safetensors take.csv --frame 2 -o x.ply", &["expected a name that ends in .obj"]);
    f.refused("correct face.safetensors take.csv --frame 2 -o take.csv", &["take.csv"]);
}

#[test]
fn what_is_wrong_with_edits_is_one_sentence() {
    let f = solved();
    for (text, words) in [
        (
            "[[gain]]\nregion = \"tail\"\nby = 2\n",
            "EDIT.toml: a region is “tail”, which is no handle of the rig and no region",
        ),
        ("[[gain]]\nby = two\n", "EDIT.toml, line 2: not TOML"),
        ("[[add]]\ntake = \"../take.csv\"\n", "which is not in"),
        (
            "[[correction]]\nmesh = \"neutral.obj\"\nframe = 99\n",
            "[[correction]] of frame 99: the take has 20 frames",
        ),
        (
            "[[hold]]\nframes = \"18..21\"\n",
            "EDIT.toml: [[hold]] of the frames 18..21 at 18: the take has 20",
        ),
    ] {
        f.write("EDIT.toml", text);
        let output = f
            .rhytid("animate face.safetensors take.csv -o out/x.usd --edit EDIT.toml --device cpu:0")
            .output()
            .unwrap();
        assert_refused(&output, &[words]);
        assert!(!f.path("out/x.usd").exists());
    }
}
