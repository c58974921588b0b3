//! `animate --fade-detail` and `--head`, and how `verify` treats them.

use crate::common::{self, Fixture, stderr};
use rhytid::conformance::evaluate;
use rhytid::core::HandleId;
use rhytid::core::StrainEdgeId;
use rhytid::core::rig_file;
use rhytid::formats::{animation, take};
use rhytid::{Rig, Take};
use rhytid_kernels::normals;
use rhytid_test_support::python;
use std::process::Command;

/// The frames of the demo's performance to test: strong expressions, and more than a batch has.
const FRAMES: std::ops::Range<usize> = 20..60;

/// The demo's face and a part of its performance, as `take.csv`.
fn demo() -> (Fixture, Take) {
    let f = Fixture::new();
    std::fs::copy(common::demo().join("face.safetensors"), f.path("face.safetensors")).unwrap();
    let whole = take::read(&common::demo().join("performance.csv"), None, take::Missing::Error).unwrap();
    let part = whole.slice(FRAMES);
    take::write(&f.path("take.csv"), &part).unwrap();
    (f, part)
}

/// Writes the take as `name`, with the confidence that `of` gives each frame and marker.
fn with_confidence(f: &Fixture, take: &Take, name: &str, of: impl Fn(usize, usize) -> f32) {
    let m = take.labels.len();
    let confidence = (0..take.frames() * m).map(|i| of(i / m, i % m)).collect();
    take::write(&f.path(name), &Take { confidence: Some(confidence), ..take.clone() }).unwrap();
}

fn animate(f: &Fixture, take: &str, output: &str, options: &str) {
    f.done(&format!("animate face.safetensors {take} --device cpu:0 -o {output} {options}"));
}

fn verify(f: &Fixture, file: &str, take: &str) -> Option<i32> {
    let args = format!("verify {file} --rig face.safetensors --take {take} --device cpu:0");
    f.rhytid(&args).output().unwrap().status.code()
}

/// Positions and normals of every frame.
fn frames(f: &Fixture, file: &str) -> Vec<[Vec<f32>; 2]> {
    let mut reader = animation::open(&f.path(file)).unwrap();
    let frame = |i| {
        let [mut positions, mut normals] = [Vec::new(), Vec::new()];
        reader.positions(i, &mut positions).unwrap();
        reader.channel(&rhytid::core::channel::NORMALS, i, &mut normals).unwrap();
        [positions, normals]
    };
    (0..FRAMES.len()).map(frame).collect()
}

/// Doubt of different size in some markers of some frames.
fn doubt(frame: usize, marker: usize) -> f32 {
    match (frame, marker % 3) {
        (3..=6, 0) => 0.25 * (frame - 3) as f32,
        (5, 1) | (36, 2) => 0.125,
        _ => 1.0,
    }
}

#[test]
fn faded_frames_are_those_of_an_independent_computation() {
    let (f, take) = demo();
    with_confidence(&f, &take, "doubt.csv", doubt);
    animate(&f, "take.csv", "plain.usd", "");
    animate(&f, "doubt.csv", "faded.usd", "--fade-detail");
    let (plain, faded) = (frames(&f, "plain.usd"), frames(&f, "faded.usd"));

    let rig: Rig<f64> = rig_file::read(&f.path("face.safetensors")).unwrap().widened();
    let handles = take.handle_positions(&rig.handles().labels).unwrap();
    let handles: Vec<[f64; 3]> = handles.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect();
    let results = evaluate(&rig, &handles);
    let vertices = rig.vertices();
    let triangles = rig.surface().vertex_triangles();
    let mut largest = 0.0_f64;
    for frame in 0..FRAMES.len() {
        let certainty = |label: &str| {
            let marker = take.labels.iter().position(|known| known == label).unwrap();
            f64::from(doubt(frame, marker))
        };
        let mut expected = Vec::new();
        for v in 0..vertices {
            let (edges, alphas) = (rig.influences().edges.row(v), rig.influences().weights.row(v));
            let sum: f64 = alphas.iter().sum();
            let c: f64 = edges
                .iter()
                .zip(alphas)
                .map(|(&e, alpha)| {
                    let [a, b] = rig.handles().strain_edges[e.index()]
                        .map(|h| certainty(&rig.handles().labels[h.index()]));
                    alpha / sum * if a < b { a } else { b }
                })
                .sum();
            let (smooth, full) =
                (results.large_scale[frame * vertices + v], results.positions[frame * vertices + v]);
            let c = if sum == 0.0 { 1.0 } else { c };
            expected.push([0, 1, 2].map(|i| (1.0 - c) * smooth[i] + c * full[i]));
        }
        let mut expected_normals = vec![[0.0; 3]; vertices];
        let params = normals::Params::whole(1, vertices);
        normals::normals(params, &expected, &rig.surface().triangles, &triangles, &mut expected_normals);
        let off = |found: &[f32], expected: &[[f64; 3]]| {
            let pairs = found.iter().zip(expected.as_flattened());
            pairs.map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max)
        };
        // The face is 20 cm high and computed in f32. Devices may differ by a part of that precision.
        let (positions, normals) =
            (off(&faded[frame][0], &expected), off(&faded[frame][1], &expected_normals));
        assert!(positions < 1e-4 && normals < 1e-3, "frame {frame}: {positions} cm, {normals}");
        let moved = faded[frame][0].iter().zip(&plain[frame][0]).map(|(a, b)| f64::from((a - b).abs()));
        let moved = moved.fold(0.0, f64::max);
        assert_eq!(moved > 0.0, matches!(frame, 3..=6 | 36), "frame {frame}");
        if moved == 0.0 {
            assert!(faded[frame] == plain[frame], "frame {frame} has other bits, though nothing fades");
        }
        largest = largest.max(moved);
    }
    assert!(largest > 0.005, "the fading is hardly to be seen: {largest} cm");
}

#[test]
fn all_confidence_changes_nothing_and_none_leaves_the_large_scale() {
    let (f, take) = demo();
    with_confidence(&f, &take, "sure.csv", |_, _| 1.0);
    with_confidence(&f, &take, "guess.csv", |_, _| 0.0);
    with_confidence(&f, &take, "doubt.csv", doubt);
    animate(&f, "take.csv", "plain.usd", "");
    animate(&f, "doubt.csv", "not_asked.usd", "");
    assert!(f.read("plain.usd") == f.read("not_asked.usd"));
    animate(&f, "take.csv", "without.usd", "--fade-detail");
    animate(&f, "sure.csv", "sure.usd", "--fade-detail");
    assert!(f.read("without.usd") == f.read("sure.usd"));
    assert!(frames(&f, "sure.usd") == frames(&f, "plain.usd"));

    animate(&f, "guess.csv", "guess.usd", "--fade-detail");
    animate(&f, "guess.csv", "large.usd", "--stage large-scale");
    assert!(frames(&f, "guess.usd") == frames(&f, "large.usd"));
    assert!(frames(&f, "guess.usd") != frames(&f, "plain.usd"));

    let said =
        f.rhytid("animate face.safetensors take.csv --device cpu:0 -o again.usd --fade-detail -v").output();
    let said = stderr(&said.unwrap());
    let words = "take.csv: has no confidence below 1 and goes nowhere far from the examples, so --fade-detail changes nothing";
    assert!(said.contains(words), "{said}");
    f.refused(
        "animate face.safetensors take.csv -o out/face.usd --fade-detail --stage large-scale",
        &["--fade-detail is for --stage full", "--stage large-scale"],
    );
}

#[test]
fn verify_and_stitch_know_what_was_faded() {
    let (f, take) = demo();
    with_confidence(&f, &take, "doubt.csv", doubt);
    for export in ["faded.usd --velocities", "faded.usda", "faded.glb"] {
        let file = export.split(' ').next().unwrap();
        animate(&f, "doubt.csv", export, "--fade-detail");
        assert_eq!(verify(&f, file, "doubt.csv"), Some(0), "{export}");
        assert_eq!(verify(&f, file, "take.csv"), Some(1), "{export}");
    }
    // The same frames, marked as not faded: an older program would read them so.
    let text = f.read_text("faded.usda");
    assert!(text.contains("bool \"fade_detail\" = 1"));
    f.write("denied.usda", text.replace("bool \"fade_detail\" = 1", "bool \"fade_detail\" = 0"));
    assert_eq!(verify(&f, "denied.usda", "doubt.csv"), Some(1));
    let older: String =
        text.lines().filter(|l| !l.contains("fade_detail")).map(|l| format!("{l}\n")).collect();
    f.write("older.usda", older);
    assert_eq!(verify(&f, "older.usda", "doubt.csv"), Some(1));

    animate(&f, "doubt.csv", "a.usd", "--fade-detail --frames 0..5");
    animate(&f, "doubt.csv", "b.usd", "--frames 5..12");
    f.refused("stitch a.usd b.usd -o out/face.usd", &["a.usd", "b.usd", "fade_detail: false and true"]);
}

/// Positions, normals and velocities of every time code in world space, as USD's own library computes them:
/// raw doubles.
fn world(f: &Fixture, file: &str) -> Vec<f64> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/program/world_usd.py");
    let dump = f.path("dump.bin");
    let output = Command::new(python()).arg(script).arg(f.path(file)).arg(&dump).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    std::fs::read(dump).unwrap().as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

/// The fixture's take with a head that turns and moves.
fn moving() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let take = f.read_text("take.csv");
    let rows = take.trim_end().lines().enumerate().map(|(i, row)| match i {
        0 => format!("{row},head_qw,head_qx,head_qy,head_qz,head_tx,head_ty,head_tz"),
        _ => {
            let (sine, cosine) = (0.05 * i as f64).sin_cos();
            format!(
                "{row},{cosine},{},{},0,{},15,{}",
                0.6 * sine,
                0.8 * sine,
                0.1 * i as f64,
                -0.2 * i as f64
            )
        }
    });
    f.write("moving.csv", rows.collect::<Vec<_>>().join("\n") + "\n");
    f
}

#[test]
fn baking_is_what_a_reader_makes_of_the_transform() {
    let f = moving();
    for head in ["keep", "bake", "drop"] {
        let options = format!("--head {head} --velocities --frames 3..17");
        animate(&f, "moving.csv", &format!("{head}.usd"), &options);
        assert_eq!(verify(&f, &format!("{head}.usd"), "moving.csv"), Some(0), "{head}");
    }
    let has_transform = |file: &str| animation::open(&f.path(file)).unwrap().summary().head;
    assert_eq!(["keep.usd", "bake.usd", "drop.usd"].map(has_transform), [true, false, false]);

    let (keep, bake, drop) = (world(&f, "keep.usd"), world(&f, "bake.usd"), world(&f, "drop.usd"));
    let numbers = 14 * 21 * 21 * 3;
    assert_eq!((keep.len(), bake.len()), (3 * numbers, 3 * numbers));
    let worst = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Positions of up to 25 and normals of 1, each rounded to f32 once.
    let (positions, normals) = (..numbers, numbers..2 * numbers);
    assert!(
        worst(&keep[positions], &bake[positions]) <= 1e-6,
        "{}",
        worst(&keep[positions], &bake[positions])
    );
    assert!(worst(&keep[normals.clone()], &bake[normals.clone()]) <= 6e-8 * 2.0);
    assert!(worst(&drop[positions], &bake[positions]) > 1.0);
    // Central differences of the other file's world positions. The ends of a part use the frames beyond it.
    let (frame, velocities) = (21 * 21 * 3, &bake[2 * numbers..]);
    for i in 1..13 {
        for j in 0..frame {
            let expected = (keep[(i + 1) * frame + j] - keep[(i - 1) * frame + j]) * 15.0;
            let found = velocities[i * frame + j];
            assert!((found - expected).abs() < 1e-4, "frame {i}: {found}, expected {expected}");
        }
    }

    // `--head drop` gives the same as a take without a head.
    animate(&f, "take.csv", "still.usd", "--velocities --frames 3..17");
    assert!(world(&f, "still.usd") == drop);
}

#[test]
fn verify_and_stitch_know_what_became_of_the_head() {
    let f = moving();
    for head in ["keep", "drop", "bake"] {
        for file in ["face.usda", "face.glb", "face.gltf"] {
            animate(&f, "moving.csv", file, &format!("--head {head}"));
            assert_eq!(verify(&f, file, "moving.csv"), Some(0), "{file} {head}");
        }
        let text = f.read_text("face.usda");
        for other in ["keep", "drop", "bake"] {
            let said = text
                .replace(&format!("string \"head\" = \"{head}\""), &format!("string \"head\" = \"{other}\""));
            f.write("said.usda", said);
            let expected = if other == head { 0 } else { 1 };
            assert_eq!(verify(&f, "said.usda", "moving.csv"), Some(expected), "{head}, said to be {other}");
        }
    }
    f.write("odd.usda", f.read_text("face.usda").replace("\"head\" = \"bake\"", "\"head\" = \"spin\""));
    f.refused("verify odd.usda --rig face.safetensors --take moving.csv", &["head = \"spin\""]);

    animate(&f, "moving.csv", "a.usd", "--head drop --frames 0..5");
    animate(&f, "moving.csv", "b.usd", "--head bake --frames 5..20");
    f.refused("stitch a.usd b.usd -o out/face.usd", &["head: bake and drop"]);

    animate(&f, "take.csv", "plain.usd", "");
    let args = "animate face.safetensors take.csv --device cpu:0 -o baked.usd --head bake -v";
    let said = stderr(&f.rhytid(args).output().unwrap());
    assert!(said.contains("does not say how the head moves, so --head bake changes nothing"), "{said}");
    assert!(world(&f, "plain.usd") == world(&f, "baked.usd"));
    assert_eq!(verify(&f, "baked.usd", "take.csv"), Some(0));
}

#[test]
fn detail_is_turned_down_and_up() {
    let (f, _) = demo();
    let mut of = Vec::new();
    for (name, options) in [
        ("full.usd", ""),
        ("smooth.usd", "--stage large-scale"),
        ("none.usd", "--detail 0"),
        ("half.glb", "--detail 0.5"),
        ("twice.usd", "--detail 2"),
        ("once.usd", "--detail 1"),
    ] {
        animate(&f, "take.csv", name, options);
        assert_eq!(verify(&f, name, "take.csv"), Some(0), "{name} says how it was made");
        of.push(frames(&f, name));
    }
    let [full, smooth, none, half, twice, once] = &of[..] else { unreachable!() };
    assert_eq!(
        std::fs::read(f.path("full.usd")).unwrap(),
        std::fs::read(f.path("once.usd")).unwrap(),
        "1 is as it was"
    );
    let rig = rig_file::read(&f.path("face.safetensors")).unwrap();
    let triangles = rig.surface().vertex_triangles();
    let mut wrinkles = 0.0_f32;
    for frame in 0..full.len() {
        for (gained, gain) in [(none, 0.0), (half, 0.5), (twice, 2.0), (once, 1.0)] {
            let pairs = full[frame][0].iter().zip(&smooth[frame][0]).zip(&gained[frame][0]);
            for ((full, smooth), found) in pairs {
                wrinkles = wrinkles.max((full - smooth).abs());
                let expected = smooth + gain * (full - smooth);
                assert!(
                    (found - expected).abs() < 1e-5,
                    "frame {frame}, gain {gain}: {found} instead of {expected}"
                );
            }
        }
        // Its normals are those of the shown shape.
        let mut normals = vec![[0.0; 3]; rig.vertices()];
        let positions = twice[frame][0].as_chunks::<3>().0;
        let whole = normals::Params::whole(1, rig.vertices());
        normals::normals(whole, positions, &rig.surface().triangles, &triangles, &mut normals);
        for (found, expected) in twice[frame][1].iter().zip(normals.as_flattened()) {
            assert!((found - expected).abs() < 1e-3, "frame {frame}: normal {found} instead of {expected}");
        }
    }
    assert!(wrinkles > 0.02, "the demo wrinkles by {wrinkles} cm");
    f.refused("animate face.safetensors take.csv -o x.usd --detail 3", &["expected a number from 0 to 2"]);
    f.refused(
        "animate face.safetensors take.csv -o x.usd --detail 0.5 --stage large-scale",
        &["--detail is for --stage full", "which has no detail"],
    );
}

#[test]
fn detail_is_turned_down_by_region() {
    let (f, _) = demo();
    f.write("anna.toml", "[detail]\nlids = 0\nchin = 2\n");
    let region = "--detail-of lids=0 --detail-of chin=2";
    for (name, options) in [
        ("full.usd", ""),
        ("smooth.usd", "--stage large-scale"),
        ("region.usd", region),
        ("region.glb", region),
        ("setup.usd", "--setup anna.toml"),
        ("setup2.usd", "--setup anna.toml --detail-of chin=1"),
    ] {
        animate(&f, "take.csv", name, options);
        assert_eq!(verify(&f, name, "take.csv"), Some(0), "{name} says how it was made");
    }
    let is_same = std::fs::read(f.path("region.usd")).unwrap() == std::fs::read(f.path("setup.usd")).unwrap();
    assert!(is_same, "the line and the setup say the same");
    let [full, smooth, found] = ["full.usd", "smooth.usd", "region.usd"].map(|name| frames(&f, name));
    let rig = rig_file::read(&f.path("face.safetensors")).unwrap();
    // The gain of a vertex is the mean over the handles that its influences join, so that there is no seam.
    let gain_of_handle = |h: HandleId| match rhytid::playback::region_of(&rig.handles().labels[h.index()]) {
        Some("lids") => 0.0,
        Some("chin") => 2.0,
        _ => 1.0,
    };
    let gain = |v: usize| {
        let of_edge = |e: StrainEdgeId| {
            rig.handles().strain_edges[e.index()].map(gain_of_handle).iter().sum::<f32>() / 2.0
        };
        let influences = rig.influences().at(v);
        let (sum, all) = influences.fold((0.0, 0.0), |(sum, all), (e, w)| (sum + w * of_edge(e), all + w));
        if all > 0.0 { sum / all } else { 1.0 }
    };
    let gains: Vec<f32> = (0..rig.vertices()).map(gain).collect();
    assert!(gains.iter().any(|g| *g < 0.2) && gains.iter().any(|g| *g > 1.5) && gains.contains(&1.0));
    for frame in 0..full.len() {
        for (i, found) in found[frame][0].iter().enumerate() {
            let (full, smooth) = (full[frame][0][i], smooth[frame][0][i]);
            let expected = smooth + gains[i / 3] * (full - smooth);
            assert!((found - expected).abs() < 1e-5, "frame {frame}: {found} instead of {expected}");
        }
    }
    f.refused(
        "animate face.safetensors take.csv -o out/face.usd --detail-of tail=0.5",
        &["“tail” is neither a handle of the rig nor a region", "brows", "lids"],
    );
    f.refused(
        "animate face.safetensors take.csv -o out/face.usd --stage large-scale --detail-of lids=0.5",
        &["--detail-of is for --stage full"],
    );
    let picture = |name: &str, options: &str| {
        f.done(&format!("render face.safetensors take.csv -o {name} --frames 4..5 --size 200x200 {options}"));
        std::fs::read(f.path(name)).unwrap()
    };
    let drawn = picture("region.png", region);
    assert_eq!(picture("setup.png", "--setup anna.toml"), drawn, "pictures too");
    assert_ne!(picture("full.png", ""), drawn);
    f.refused(
        "render face.safetensors take.csv -o out/x.png --frames 4..5 --stage large-scale --fade-detail",
        &["--fade-detail is for --stage full"],
    );
    animate(&f, "take.csv", "a.usd", &format!("{region} --frames 0..5"));
    animate(&f, "take.csv", "b.usd", "--frames 5..9");
    f.refused("stitch a.usd b.usd -o out/face.usd", &["detail_of: none and chin=2;lids=0"]);
}
