//! `transfer`: a sheet's wrinkles on another sheet, and what is refused.

use crate::common::{Fixture, assert_documented, list, stderr};
use rhytid::formats::{animation, mesh, tables, take};
use serde_json::Value;

/// A sheet with a rig, and one twice as fine with handles at the same places and without examples.
fn two_sheets() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let fine = Fixture::with_side(41);
    f.write("fine.obj", fine.obj(0.0));
    f.write("fine.csv", fine.read("markers.csv"));
    f.write(
        "fine.toml",
        "[mesh]\nneutral = \"fine.obj\"\nunits = \"cm\"\n[handles]\nvertices = \"fine.csv\"\n",
    );
    f.write("fine-pinch.obj", fine.obj(0.3));
    f
}

#[test]
fn a_sheets_expression_is_carried_over_and_its_markers_are_met() {
    let f = two_sheets();
    let command =
        "transfer --from face.safetensors --to fine.toml -o out/fine.safetensors --with-linear-band";
    let output = f.rhytid(&format!("{command} --examples made --report report")).output().unwrap();
    let (said, warned) = (String::from_utf8(output.stdout.clone()).unwrap(), stderr(&output));
    assert!(output.status.success(), "{warned}");
    assert!(warned.contains("warning: only 5 landmarks are shared"), "{warned}");
    for words in [
        "all motion of face on fine: 1 example by 5 landmarks, 100 % of the size",
        "with a counterpart  100 % of the skin",
        "out/fine.safetensors: 1,681 vertices",
        "name = \"pinch\"\nmesh = \"made/pinch.obj\"",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // The made example equals the fine sheet's pinch, except for what the coarse sheet cannot show.
    let [made, expected] =
        ["made/pinch.obj", "fine-pinch.obj"].map(|name| mesh::read(&f.path(name)).unwrap());
    let apart = made.positions.iter().zip(&expected.positions);
    let squares = apart.map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>());
    let rms = (squares.sum::<f64>() / made.positions.len() as f64).sqrt();
    assert!(rms < 0.03, "{rms} cm");
    // Markers are met in every frame.
    f.done("animate out/fine.safetensors take.csv -o fine.usd --device cpu:0");
    let handles = tables::read_handles(&f.path("fine.csv")).unwrap();
    let take = take::read(&f.path("take.csv"), Some(&handles.labels), take::Missing::Error).unwrap();
    let markers = take.handle_positions(&handles.labels).unwrap();
    let mut reader = animation::open(&f.path("fine.usd")).unwrap();
    let mut positions = Vec::new();
    for (frame, markers) in markers.chunks(3 * handles.len()).enumerate() {
        reader.positions(frame, &mut positions).unwrap();
        for (marker, point) in markers.chunks(3).zip(&handles.points) {
            for (x, y) in marker.iter().zip(point.at(positions.as_chunks::<3>().0)) {
                assert!((x - y).abs() < 2e-6, "frame {frame}, {point}: {x} and {y}");
            }
        }
    }
    // The page and the same as JSON.
    let found: Value = serde_json::from_str(&f.read_text("report/transfer.json")).unwrap();
    assert_documented(&found, "transfer");
    assert!(found["covered"].as_f64().unwrap() > 0.999 && found["turned_over"] == 0, "{found}");
    let page = f.read_text("report/transfer.html");
    assert!(page.contains("Distance between the faces") && page.contains("only 5 landmarks"), "{page}");
    assert!(f.done("info report/transfer.json").contains("transfer"));
    // The printed lines make a project that can be solved. After that there is nothing left to transfer.
    let lines = said.split("where the examples are to be kept:").nth(1).unwrap();
    f.write("kept.toml", f.read_text("fine.toml") + lines);
    f.done("solve kept.toml -o kept.safetensors");
    std::fs::remove_file(f.path("out/fine.safetensors")).unwrap();
    f.refused(
        "transfer --from face.safetensors --to kept.toml -o out/again.safetensors",
        &["kept.toml: has each example of the first face already (pinch"],
    );
}

#[test]
fn the_same_mesh_is_copied_and_the_same_again_has_the_same_bytes() {
    let f = two_sheets();
    f.write("same.toml", f.read_text("face.toml").split("[[example]]").next().unwrap());
    for name in ["one", "two"] {
        let command = format!(
            "transfer --from face.safetensors --to same.toml -o {name}.safetensors --with-smooth-band"
        );
        let said = f.done(&format!("{command} --json"));
        let found: Value = serde_json::from_str(&said).unwrap();
        assert!(found["same_topology"] == true && found["warnings"].as_array().unwrap().is_empty(), "{said}");
    }
    assert!(f.read("one.safetensors") == f.read("two.safetensors"));
    for (rig, out) in [("face", "first"), ("one", "second")] {
        f.done(&format!("animate {rig}.safetensors take.csv -o {out}.usd --device cpu:0"));
    }
    let [mut first, mut second] =
        ["first.usd", "second.usd"].map(|name| animation::open(&f.path(name)).unwrap());
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for frame in 0..20 {
        first.positions(frame, &mut a).unwrap();
        second.positions(frame, &mut b).unwrap();
        let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-3, "frame {frame}: {worst} cm");
    }
}

#[test]
fn what_cannot_be_transferred_is_said_and_nothing_is_written() {
    let f = two_sheets();
    let to = |rest: &str| format!("transfer --from face.safetensors --to fine.toml {rest}");
    f.refused(
        "transfer --from fine.toml --to face.safetensors -o out/x.safetensors",
        &["fine.toml: is a project file, expected a rig"],
    );
    f.refused(
        "transfer --from face.safetensors --to fine.obj -o out/x.safetensors",
        &["fine.obj: is a mesh, expected a project file", "rhytid transfer --from"],
    );
    f.refused(&to("-o out/x.usd"), &["x.usd: expected a name that ends in .safetensors"]);
    f.refused(
        &to("-o face.safetensors"),
        &["face.safetensors: is face.safetensors, which this command reads"],
    );
    f.refused(&to("-o out/x.safetensors --landmarks none.csv"), &["none.csv"]);
    f.write("pairs.csv", "from,to\nleft,left\nright,right\ntop,top\n");
    f.refused(&to("-o out/x.safetensors --landmarks pairs.csv"), &["share 3 landmarks, expected at least 4"]);
    f.write("pairs.csv", "from,to\nleft,left\nright,right\ntop,top\nbotom,bottom\n");
    f.refused(&to("-o out/x.safetensors --landmarks pairs.csv"), &["face has no handle called “botom”"]);
    f.write("pairs.csv", "from;to\nleft;left\n");
    f.refused(&to("-o out/x.safetensors --landmarks pairs.csv"), &["pairs.csv, line 1", "semicolons"]);
    f.write("other.csv", f.read_text("fine.csv").replace("left", "links").replace("top", "oben"));
    f.write("other.toml", f.read_text("fine.toml").replace("fine.csv", "other.csv"));
    f.refused(
        "transfer --from face.safetensors --to other.toml -o out/x.safetensors --examples out --report out",
        &["face and other share 3 landmarks", "table of landmarks"],
    );
    // With pairs of names it works.
    f.write("pairs.csv", "from,to\nleft,links\nright,right\ntop,oben\nbottom,bottom\n");
    f.done("transfer --from face.safetensors --to other.toml -o out/x.safetensors --landmarks pairs.csv");
    assert_eq!(list(&f.path("out")), ["x.safetensors"]);
}
