//! Several takes as clips of one set of shapes, and takes fitted to shapes that are there.

use crate::common::{Fixture, PROJECT, stderr};
use rhytid::formats::animation;
use rhytid::formats::{Reach, curves};
use serde_json::Value;

/// The fixture's sheet with its rig, and two takes beside its own: one with other motion, and one with its
/// name, elsewhere and at another rate.
fn solved() -> Fixture {
    let fixture = Fixture::new();
    fixture.done("solve face.toml -o face.safetensors");
    let take = fixture.take(20);
    let rows: Vec<&str> = take.lines().collect();
    // The take backwards from its 12th frame, and from its 15th at twice the rate. Two handles move in other
    // ways too, so that one shape cannot make all of it.
    let backwards = |last: usize, rate: f64| {
        let row = |(i, row): (usize, &&str)| {
            let numbers = row.split(',').skip(1).map(|x| x.parse().unwrap());
            let mut places: Vec<f64> = numbers.collect();
            places[6] += 0.4 * (0.7 * i as f64).cos();
            places[14] += 0.3 * (1.3 * i as f64).sin();
            let places: Vec<String> = places.iter().map(|x| format!("{x:.6}")).collect();
            format!("{:.9},{}\n", i as f64 / rate, places.join(","))
        };
        let back: String = rows[1..=last].iter().rev().enumerate().map(row).collect();
        format!("{}\n{back}", rows[0])
    };
    fixture.write("other.csv", backwards(12, 30.0));
    fixture.write("more/take.csv", backwards(15, 60.0));
    fixture
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The positions of all frames of a clip.
fn frames(fixture: &Fixture, file: &str, clip: Option<&str>) -> Vec<Vec<f32>> {
    let mut reader = animation::open_clip(&fixture.path(file), Reach::Below, clip).unwrap();
    let frames = reader.summary().frames;
    let mut out = Vec::new();
    let frame = |frame| {
        reader.positions(frame, &mut out).unwrap();
        out.clone()
    };
    (0..frames).map(frame).collect()
}

/// The largest distance of a vertex in two animations, in millimetres; the unit is the centimetre.
fn farthest(a: &[Vec<f32>], b: &[Vec<f32>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    let squares: Vec<f64> = pairs.map(|(a, b)| f64::from(a - b).powi(2)).collect();
    10.0 * squares.as_chunks::<3>().0.iter().map(|x| x.iter().sum::<f64>()).fold(0.0, f64::max).sqrt()
}

const TAKES: [(&str, &str); 3] = [("take.csv", "take"), ("other.csv", "other"), ("more/take.csv", "take 2")];

#[test]
fn one_set_of_shapes_for_many_takes() {
    let fixture = solved();
    for (i, (take, _)) in TAKES.into_iter().enumerate() {
        fixture.done(&format!("animate face.safetensors {take} -o exact{i}.usd"));
        fixture.done(&format!("animate face.safetensors {take} -o even{i}.usd --fps 30"));
    }
    let takes = "take.csv other.csv more/take.csv";
    for (file, options, exact) in [
        ("a.glb", "--shapes 2", "exact"),
        ("b.gltf", "--compressed --max-error 0.2 --quantize", "exact"),
        ("c.usda", "--shapes 2 --fps 30", "even"),
    ] {
        let animate = format!("animate face.safetensors {takes} -o {file} {options}");
        let made = json(&fixture.done(&format!("{animate} --json")));
        assert!(made["morph_targets"].as_u64().unwrap() <= 2 || file == "b.gltf", "{made}");
        let worst = |i: usize| made["clips"][i]["worst_mm"].as_f64().unwrap();
        assert_eq!(made["worst_mm"].as_f64().unwrap(), (0..3).map(worst).fold(0.0, f64::max));
        let info = json(&fixture.done(&format!("info {file} --json")));
        for (i, (take, name)) in TAKES.into_iter().enumerate() {
            let found = frames(&fixture, file, Some(name));
            let off = farthest(&found, &frames(&fixture, &format!("{exact}{i}.usd"), None));
            assert!(off <= worst(i) && off > 0.5 * worst(i), "{file}, {name}: {off}, stated {}", worst(i));
            assert_eq!((&made["clips"][i]["take"], &info["clips"][i]["name"]), (&take.into(), &name.into()));
            assert_eq!(info["clips"][i]["frames"], found.len());
            let mut verify = fixture.rhytid(&format!("verify {file} --rig face.safetensors --take {take}"));
            let output = verify.arg("--clip").arg(name).output().unwrap();
            assert!(output.status.success(), "{}", stderr(&output));
        }
        let said = fixture.done(&animate);
        assert!(said.contains("--take more/take.csv --clip \"take 2\""), "{said}");
    }
}

#[test]
fn a_clip_is_compared_with_its_own_take() {
    let fixture = solved();
    fixture.done("animate face.safetensors take.csv other.csv -o a.glb --shapes 2");
    fixture.done("animate face.safetensors take.csv other.csv -o a.usda --shapes 2");
    for file in ["a.glb", "a.usda"] {
        let verify = format!("verify {file} --rig face.safetensors");
        fixture.done(&format!("{verify} --take other.csv"));
        fixture.refused(
            &format!("{verify} --take other.csv --clip take"),
            &["other.csv: the frames 0..20: the take has 12 frames"],
        );
        fixture.refused(
            &format!("{verify} --take more/take.csv --clip run"),
            &["has no clip \"run\", expected one of \"take\", \"other\"", "see --clip NAME"],
        );
    }
    // Another frame has the largest error of the second clip.
    let text = fixture.read_text("a.usda");
    let stated = text.find("double \"frame\" =").unwrap();
    let stated = stated + text[stated + 1..].find("double \"frame\" =").unwrap() + 1;
    let end = stated + text[stated..].find('\n').unwrap();
    let other = if text[stated..end].ends_with("= 3") { 4 } else { 3 };
    fixture.write("a.usda", format!("{}double \"frame\" = {other}{}", &text[..stated], &text[end..]));
    let verify = "verify a.usda --rig face.safetensors";
    fixture.done(&format!("{verify} --take take.csv"));
    let output = fixture.rhytid(&format!("{verify} --take other.csv")).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("the stated place of the largest error"), "{said}");
    // The box around all clips leaves out what is right of the middle.
    fixture.done("animate face.safetensors take.csv other.csv -o box.usda --shapes 2");
    fixture.done("verify box.usda --rig face.safetensors --take other.csv");
    let text = fixture.read_text("box.usda");
    let corner = text.find("float3[] extent = [(").unwrap();
    let corner = corner + text[corner..].find("), (").unwrap() + 4;
    let end = corner + text[corner..].find(',').unwrap();
    fixture.write("box.usda", format!("{}0{}", &text[..corner], &text[end..]));
    let output = fixture.rhytid("verify box.usda --rig face.safetensors --take other.csv").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("extents: wrong in 12 of 12 frames"), "{said}");
    fixture.done("animate face.safetensors take.csv -o one.glb --shapes 2");
    fixture.refused(
        "verify one.glb --rig face.safetensors --take take.csv --clip take",
        &["one.glb: holds one take, so that --clip changes nothing"],
    );
    let json = fixture.done("info one.glb --json");
    assert_eq!(self::json(&json)["clips"], serde_json::json!([]));
}

#[test]
fn what_several_takes_cannot_have_is_one_sentence() {
    let fixture = solved();
    let animate = "animate face.safetensors take.csv other.csv";
    for file in ["a.usd", "a.glb", "a.pc2"] {
        fixture.refused(&format!("{animate} -o out/{file}"), &[&format!("out/{file}"), "see --shapes N"]);
    }
    fixture.refused(
        "animate face.safetensors take.csv more/take.csv -o out/a.usd --shapes 2",
        &["the takes have 30 and 60 frames per second", "see --fps N"],
    );
    fixture.write("edit.toml", "");
    for option in ["--edit edit.toml", "--strain-curves out/curves.csv", "--masks 64 --wrinkles"] {
        let name = option.split(' ').next().unwrap();
        fixture.refused(
            &format!("{animate} -o out/a.glb --shapes 2 {option}"),
            &[name, "is for one take, found 2"],
        );
    }
    fixture.refused(&format!("{animate} --listen --frames 3 -o out/a.glb"), &["cannot be used with"]);
}

/// The fixture's face, whose example has one of ARKit's names, and curves for it.
fn arkit() -> Fixture {
    let fixture = Fixture::new();
    fixture.write("face.toml", PROJECT.replace("name = \"pinch\"", "name = \"jawOpen\""));
    fixture.write("known.csv", KNOWN);
    fixture.done("solve face.toml -o face.safetensors");
    fixture
}

/// Weights of the only example, a second and a half of them at 24 frames per second.
const KNOWN: &str = "time,jawOpen\n0,0\n0.041666667,0.25\n0.083333333,0.5\n0.125,0.75\n0.166666667,1\n";

#[test]
fn a_take_of_known_weights_gives_them_back_from_shapes_of_every_kind() {
    let fixture = arkit();
    // In metres, and split as glTF splits vertices.
    fixture.done("export-shapes face.safetensors -o shapes.glb");
    fixture.done("export-shapes face.safetensors -o shapes.usdc");
    std::fs::create_dir(fixture.path("folder")).unwrap();
    std::fs::copy(fixture.path("poses/pinch.obj"), fixture.path("folder/jawOpen.obj")).unwrap();
    let animate = "animate face.safetensors known.csv";
    fixture.done(&format!("{animate} -o exact.usd"));
    let exact = frames(&fixture, "exact.usd", None);
    for (i, shapes) in
        ["face.safetensors", "shapes.glb", "shapes.usdc", "folder", "face.toml"].into_iter().enumerate()
    {
        let made = json(&fixture.done(&format!("{animate} -o weights{i}.csv --onto {shapes} --json")));
        let found = curves::read(&fixture.path(format!("weights{i}.csv")), None).unwrap();
        assert_eq!(found.names[..2], ["EyeBlinkLeft", "EyeLookDownLeft"], "{shapes}");
        let jaw = found.names.iter().position(|name| name == "JawOpen").unwrap();
        for (frame, weights) in found.weights.chunks(52).enumerate() {
            let known = frame as f32 / 4.0;
            assert!((weights[jaw] - known).abs() < 1e-3, "{shapes}: {} {known}", weights[jaw]);
            assert!(weights.iter().enumerate().all(|(k, w)| k == jaw || *w == 0.0), "{shapes}");
        }
        let stated = made["worst_mm"].as_f64().unwrap();
        fixture.done(&format!("{animate} -o onto{i}.glb --onto {shapes}"));
        let off = farthest(&frames(&fixture, &format!("onto{i}.glb"), None), &exact);
        let is_stated = |off: f64| off <= 1.001 * stated + 1e-4 && off > 0.5 * stated - 1e-3 && off < 0.01;
        assert!(is_stated(off), "{shapes}: {off} mm, stated {stated}");
        fixture.done(&format!("verify onto{i}.glb --rig face.safetensors --take known.csv"));
        fixture.done(&format!("{animate} -o onto{i}.usda --onto {shapes}"));
        let off = farthest(&frames(&fixture, &format!("onto{i}.usda"), None), &exact);
        assert!(is_stated(off), "{shapes}: {off} mm, stated {stated}");
        fixture.done(&format!("verify onto{i}.usda --rig face.safetensors --take known.csv"));
    }
    // The weights play the take again. A table of less than a second does not tell its rate.
    fixture.done("animate face.safetensors weights0.csv -o again.usd --take-rate 24");
    let off = farthest(&frames(&fixture, "again.usd", None), &exact);
    assert!(off < 0.01, "{off} mm");
}

#[test]
fn shapes_that_were_made_before_take_another_take() {
    let fixture = solved();
    fixture.done("animate face.safetensors take.csv other.csv -o before.glb --shapes 3");
    let again =
        json(&fixture.done("animate face.safetensors other.csv -o again.glb --onto before.glb --json"));
    assert_eq!(again["morph_targets"], 3);
    // The shapes were made for this take too, and least squares has a larger worst error and a smaller RMS.
    let exact = "animate face.safetensors other.csv -o exact.usd";
    fixture.done(exact);
    let exact = frames(&fixture, "exact.usd", None);
    let rms = |found: &[Vec<f32>]| {
        let squares = found.iter().flatten().zip(exact.iter().flatten());
        squares.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
    };
    let [before, after] = [("before.glb", Some("other")), ("again.glb", None)]
        .map(|(file, clip)| rms(&frames(&fixture, file, clip)));
    assert!(after <= 1.001 * before && after > 0.2 * before, "{before} {after}");
    fixture.done("animate face.safetensors take.csv other.csv -o both.glb --onto before.glb");
    fixture.done("verify both.glb --rig face.safetensors --take other.csv");
}

#[test]
fn shapes_of_another_mesh_are_refused() {
    let fixture = arkit();
    let other = Fixture::with_side(15);
    fixture.write("others/pinch.obj", other.obj(0.3));
    let animate = "animate face.safetensors known.csv";
    fixture.refused(
        &format!("{animate} -o out/a.csv --onto others"),
        &["others/pinch.obj: has 225 vertices, expected the 441 of the rig's mesh"],
    );
    // As many vertices, but joined in another way.
    let text = other_faces(&fixture.obj(0.3));
    fixture.write("turned/pinch.obj", text);
    fixture.refused(
        &format!("{animate} -o out/a.glb --onto turned"),
        &["turned/pinch.obj: its 441 vertices are joined to other faces than the rig's"],
    );
    fixture.refused(&format!("{animate} -o out/a.csv"), &["out/a.csv", "--onto SHAPES"]);
    fixture.refused(&format!("{animate} -o out/a.pc2 --onto poses"), &["--onto is for USD, glTF and .csv"]);
    fixture.refused(&format!("{animate} -o out/a.glb --onto poses --shapes 3"), &["give one"]);
    fixture.refused(&format!("{animate} -o out/a.glb --onto poses --compressed"), &["cannot be used with"]);
    fixture.refused(&format!("{animate} -o out/a.glb --onto out"), &["out: has no shapes"]);
    fixture.refused(
        &format!("{animate} -o out/a.glb --onto poses --strain"),
        &["shapes that are given say nothing of strain"],
    );
}

/// The mesh with each quad turned into one with its second and third corner exchanged.
fn other_faces(obj: &str) -> String {
    let line = |line: &str| match line.split(' ').collect::<Vec<_>>()[..] {
        ["f", a, b, c, d] => format!("f {a} {c} {b} {d}\n"),
        _ => format!("{line}\n"),
    };
    let mut lines: Vec<String> = obj.lines().map(line).collect();
    // A face that joins the first vertex with the last.
    if let Some(last) = lines.iter_mut().rev().find(|line| line.starts_with("f ")) {
        *last = "f 1/1 22/22 441/441 440/440\n".into();
    }
    lines.concat()
}
