//! `evaluate`, `coverage`, and what `animate` says about a take beyond the examples.

use crate::common::{Fixture, assert_documented, stderr};
use serde_json::Value;

fn json(f: &Fixture, args: &str) -> Value {
    serde_json::from_str(&f.done(args)).unwrap()
}

/// The fixture's take, with the marker `top` dragged up by 2 cm in frame 12 and by 1.9 cm in the two beside
/// it.
fn wild_take(f: &Fixture) -> String {
    let take = f.read_text("take.csv");
    let mut rows: Vec<Vec<String>> =
        take.lines().map(|row| row.split(',').map(str::to_owned).collect()).collect();
    let column = rows[0].iter().position(|cell| cell == "top_y").unwrap();
    for (frame, pull) in [(11, 1.9), (12, 2.0), (13, 1.9)] {
        let cell = &mut rows[frame + 1][column];
        *cell = (cell.parse::<f64>().unwrap() + pull).to_string();
    }
    rows.iter().map(|row| row.join(",") + "\n").collect()
}

fn solve_by_chapter(f: &Fixture) {
    f.write("chapter.toml", format!("method = \"chapter\"\n{}", f.read_text("face.toml")));
    f.done("solve chapter.toml -o face.safetensors");
}

#[test]
fn coverage_plans_scans_and_cuts_them_out() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.write("wild.csv", wild_take(&f));
    let calm = json(&f, "coverage face.safetensors take.csv --json");
    assert_eq!(calm["sigma"]["far"], serde_json::json!([]), "{calm}");
    let wild = json(&f, "coverage face.safetensors wild.csv --json --plan 2");
    // The frame that no example shows is the most uncertain one, and the one to scan.
    assert_eq!(wild["sigma"]["far"][0]["farthest"], 12, "{wild}");
    assert_eq!(
        (&wild["scans"][0]["frame"], wild["scans"].as_array().unwrap().len()),
        (&12.into(), 2),
        "{wild}"
    );
    assert_eq!(wild["scans"][0]["regions"][0]["region"], "near top", "{wild}");
    let text = f.done("coverage face.safetensors wild.csv --plan 2 --top 1");
    for words in ["far from the examples", "To be scanned next", "0.40 s", "near top", "beyond every example"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }

    // A rig without an example is enough, and the dense frames are cut out.
    let bare: String = f.read_text("face.toml").split("[[example]]").next().unwrap().into();
    f.write("bare.toml", bare);
    f.done("solve bare.toml -o bare.safetensors");
    f.done("animate face.safetensors wild.csv -o dense.usd --device cpu:0");
    let text = f
        .done("coverage bare.safetensors wild.csv --plan 2 --take-examples dense.usd -o scans --report plan");
    assert!(text.starts_with("wild.csv: 20 frames, and no example yet"), "{text}");
    let plan: Value = serde_json::from_str(&f.read_text("plan/plan.json")).unwrap();
    let frames: Vec<u64> =
        plan["scans"].as_array().unwrap().iter().map(|s| s["frame"].as_u64().unwrap()).collect();
    let page = f.read_text("plan/plan.html");
    assert!(frames.iter().any(|frame| (11..=13).contains(frame)), "{frames:?}");
    assert!(frames.iter().all(|frame| page.contains(&format!("frame {frame}, "))), "{frames:?}");
    let mut reader = rhytid::formats::animation::open(&f.path("dense.usd")).unwrap();
    for frame in &frames {
        let name = format!("scans/frame_{frame}.obj");
        assert!(text.contains(&format!("mesh = \"{name}\"")), "{text}");
        let mesh = rhytid::formats::mesh::read(&f.path(&name)).unwrap();
        let mut expected = Vec::new();
        reader.positions(*frame as usize, &mut expected).unwrap();
        let found: Vec<f32> = mesh.positions.as_flattened().iter().map(|&x| x as f32).collect();
        assert!(found == expected, "{name}");
    }
    // The printed lines make a project that can be solved.
    let lines = text.split("To be added to the project file:").nth(1).unwrap();
    f.write("planned.toml", f.read_text("bare.toml") + lines);
    f.done("solve planned.toml -o planned.safetensors");
    let info = json(&f, "info planned.safetensors --json");
    assert_eq!(info["examples"].as_array().unwrap().len(), 2);
    // Frames that can be scanned are listed.
    f.write("some.csv", "frame\n3\n12\n");
    let some = json(&f, "coverage bare.safetensors wild.csv --candidates some.csv --plan 1 --json");
    assert_eq!(some["scans"][0]["frame"], 12, "{some}");
    f.refused(
        "coverage bare.safetensors wild.csv --candidates some.csv --take-examples dense.usd -o out/scans",
        &["dense.usd: has 20 frames", "each of the 2 candidates"],
    );
    f.refused("coverage bare.safetensors wild.csv --take-examples dense.usd", &["required arguments"]);
    f.write("some.csv", "frame\n20\n");
    f.refused("coverage bare.safetensors wild.csv --candidates some.csv", &["some.csv, line 2", "0 to 19"]);
    solve_by_chapter(&f);
    f.refused("coverage face.safetensors wild.csv --plan 2", &["method = \"learned\""]);
}

#[test]
fn evaluate_says_how_good_and_where_not() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let text = f.done("evaluate face.toml --device cpu:0 --report report");
    for words in ["face: 441 vertices, 5 handles, 1 example", "left out", "pinch", "0.1 mm of noise"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let page = f.read_text("report/evaluation.html");
    assert!(page.contains("without pinch") && page.contains("data:image/png;base64"), "no maps");
    let written: Value = serde_json::from_str(&f.read_text("report/evaluation.json")).unwrap();
    assert_eq!(written["leave_one_out"]["examples"][0]["example"], "pinch");
    assert_eq!(written["truth"], Value::Null);

    // The rig's own result has no error, in any file format.
    f.done("animate face.safetensors take.csv -o truth.usd --device cpu:0");
    let found = json(&f, "evaluate face.toml --truth truth.usd --take take.csv --device cpu:0 --json");
    assert_documented(&found["truth"][0], "a method beside the truth");
    let rms = |i: usize| found["truth"][i]["rms_mm"].as_f64().unwrap();
    assert_eq!((&found["truth"][0]["method"], rms(0)), (&"learned".into(), 0.0), "{found}");
    assert!((1..5).all(|i| rms(i) > 0.0), "{found}");
    // With groups as regions.
    let mesh = f.obj(0.0);
    let (vertices, faces) = mesh.split_at(mesh.find("\nf ").unwrap() + 1);
    let faces: Vec<&str> = faces.lines().collect();
    let (low, high) = faces.split_at(200);
    f.write("groups.obj", format!("{vertices}g low\n{}\ng high\n{}\n", low.join("\n"), high.join("\n")));
    let found = json(&f, "evaluate face.toml --groups groups.obj --device cpu:0 --json");
    let regions = found["noise"]["regions"].as_array().unwrap();
    let mut names: Vec<&str> = regions.iter().map(|region| region["region"].as_str().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["high", "low"]);

    f.refused("evaluate face.toml --truth truth.usd", &["required arguments"]);
    f.write("some.csv", "frame\n3\n12\n");
    f.refused(
        "evaluate face.toml --truth truth.usd --take take.csv --truth-frames some.csv --device cpu:0",
        &["the truth has 20 frames, but 2 are listed"],
    );
    f.refused("evaluate face.toml --truth markers.csv --take take.csv", &["markers.csv", ".npy"]);
    f.refused("evaluate face.toml --groups neutral.obj", &["neutral.obj: has no group"]);
    f.refused("evaluate take.csv", &["take.csv"]);
}

#[test]
fn a_take_far_outside_the_examples_is_warned_of_once() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.write("wild.csv", wild_take(&f));
    let said = |options: &str| {
        let output =
            f.rhytid(&format!("animate face.safetensors {options} --device cpu:0")).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        let said = stderr(&output);
        said.lines().filter(|line| line.starts_with("warning: ")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(said("take.csv -o calm.usd"), [""; 0]);
    let [warning] = &said("wild.csv -o wild.usd --sigma")[..] else { panic!("not one warning") };
    for words in
        ["far outside what the examples show in 3 frames (11..14)", "in frame 12 (0.40 s)", "near top"]
    {
        assert!(warning.contains(words), "{words}: {warning}");
    }
    assert_eq!(said("wild.csv -o part.usd --frames 0..11"), [""; 0], "of frames that are not asked for");
    assert!(said("wild.csv -o part.usd --frames 10..13")[0].contains("in 2 frames (11..13)"));
    assert_eq!(said("wild.csv -o shell.usd --stage shell"), [""; 0]);
    f.refused("animate face.safetensors wild.csv -o out/face.glb --sigma", &["--sigma is for USD"]);
}

#[test]
fn coverage_by_the_chapters_method_names_the_frame_to_scan() {
    let f = Fixture::new();
    solve_by_chapter(&f);
    f.write("wild.csv", wild_take(&f));
    let calm = json(&f, "coverage face.safetensors take.csv --json");
    assert_eq!((&calm["covered"], &calm["frames"]), (&20.into(), &20.into()), "{calm}");
    let text = f.done("coverage face.safetensors take.csv");
    assert!(text.starts_with("take.csv: 100.0 % of 20 frames are covered"), "{text}");
    assert!(text.contains("No expression is worth") && text.contains("No strain edge goes beyond"), "{text}");

    let wild = json(&f, "coverage face.safetensors wild.csv --json");
    assert_eq!((&wild["covered"], wild["distances"].as_array().unwrap().len()), (&17.into(), 20), "{wild}");
    let [expression] = &wild["expressions"].as_array().unwrap()[..] else { panic!("{wild}") };
    assert_eq!((&expression["frame"], &expression["covered"]), (&12.into(), &20.into()), "{wild}");
    assert_eq!(wild["edges"][0]["frame"], 12, "{wild}");
    // The marker moves nearly along this edge, and no example strains the edge.
    assert_eq!(wild["edges"][0]["handles"], serde_json::json!(["top", "middle"]), "{wild}");
    let millimetres = wild["edges"][0]["beyond_mm"].as_f64().unwrap();
    assert!((19.0..20.0).contains(&millimetres), "{wild}");
    let text = f.done("coverage face.safetensors wild.csv --top 1");
    for words in ["85.0 % of 20 frames", "0.40 s", "top", "longer", "beyond every example"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    f.refused(
        "coverage face.safetensors markers.csv",
        &["markers.csv", "is a table of handles, expected a take"],
    );
    f.refused("coverage take.csv take.csv", &["take.csv"]);
}

#[test]
fn their_json_has_the_documented_keys() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.write("wild.csv", wild_take(&f));
    let coverage = json(&f, "coverage face.safetensors wild.csv --json --top 1");
    assert_documented(&coverage, "coverage");
    assert_documented(&coverage["sigma"], "sigma");
    assert_documented(&coverage["sigma"]["far"][0], "a stretch that is far");
    assert_documented(&coverage["scans"][0], "a scan");
    assert_documented(&coverage["scans"][0]["regions"][0], "a region of a scan");
    assert_documented(&coverage["scans"][0]["edges"][0], "an edge of an expression");
    assert_documented(&coverage["edges"][0], "an edge beyond the examples");
    let evaluation = json(&f, "evaluate face.toml --json --device cpu:0");
    assert_documented(&evaluation, "evaluation");
    assert_documented(&evaluation["noise"], "noise");
    assert_documented(&evaluation["leave_one_out"], "leave one out");
    assert_documented(&evaluation["leave_one_out"]["examples"][0], "an example that is left out");
    assert_documented(&evaluation["noise"]["regions"][0], "a region");
    solve_by_chapter(&f);
    let coverage = json(&f, "coverage face.safetensors wild.csv --json --top 1");
    assert_documented(&coverage, "coverage by the chapter's method");
    assert_documented(&coverage["expressions"][0], "an expression");
    assert_documented(&coverage["expressions"][0]["edges"][0], "an edge of an expression");
    assert_documented(&coverage["edges"][0], "an edge beyond the examples");
}

/// The reported wrinkles of a vertex are what `animate` adds to the large scale there.
#[test]
fn explain_accounts_for_the_wrinkles() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for stage in ["full", "large-scale"] {
        f.done(&format!("animate face.safetensors take.csv -o {stage}.usd --stage {stage} --device cpu:0"));
    }
    let [full, smooth] = ["full.usd", "large-scale.usd"].map(|file| {
        let mut positions = Vec::new();
        rhytid::formats::animation::open(&f.path(file)).unwrap().positions(7, &mut positions).unwrap();
        positions
    });
    let found = json(&f, "explain face.safetensors take.csv --frame 7 --vertex 3,40,11 --json");
    assert_documented(&found, "explain");
    assert_eq!((&found["frame"], &found["folds_along"]), (&7.into(), &"mesh axes".into()));
    let millimetres = 1e3 * json(&f, "info face.safetensors --json")["metres_per_unit"].as_f64().unwrap();
    let vertices = found["vertices"].as_array().unwrap();
    let mut largest = 0_f64;
    for (vertex, found) in [3, 40, 11].into_iter().zip(vertices) {
        assert_documented(found, "explained vertex");
        assert_eq!(found["vertex"], vertex);
        for axis in 0..3 {
            let at = 3 * vertex + axis;
            let expected = f64::from(full[at] - smooth[at]) * millimetres;
            let of = |of: &Value| of["folds_mm"][axis].as_f64().unwrap();
            let parts: f64 = found["examples"].as_array().unwrap().iter().map(of).sum();
            assert!((of(found) - expected).abs() < 1e-4, "vertex {vertex}: {} for {expected}", of(found));
            assert!((parts - expected).abs() < 1e-4, "vertex {vertex}: {parts} for {expected}");
            largest = largest.max(expected.abs());
        }
    }
    assert!(largest > 1e-3, "no wrinkles there");
    let text = f.done("explain face.safetensors take.csv --frame 7 --vertex 3");
    for words in ["vertex 3 in frame 7", "strain edge", "of the wrinkles", "from rest"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    f.refused(
        "explain face.safetensors take.csv --frame 20 --vertex 3",
        &["--frame 20: take.csv has 20 frames, counted from 0"],
    );
    f.refused(
        "explain face.safetensors take.csv --frame 2 --vertex 3000000",
        &["vertex 3000000: the rig's vertices are 0 to"],
    );
}
