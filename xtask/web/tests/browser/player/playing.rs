//! Takes.
use super::faces::GAP;
use super::*;
use rhytid_core::Take;

/// The handle positions of the take at a time after its first frame.
fn at(take: &Take, seconds: f64) -> Vec<f32> {
    let frame = take.slice(0..take.frames()).resample(1.0 / seconds).unwrap().slice(1..2);
    frame.handle_positions(&package().faces.learned.handles().labels).unwrap()
}

#[test]
fn a_take_plays_loops_stands_and_moves_the_head() {
    let found = run(
        "gpu.html",
        "const { face, mesh, draw } = await open('learned.safetensors');
        const take = await player.Take.load('take.csv', face);
        const found = { facts: [take.frames, take.rate, take.duration, take.hasHead, take.warnings], times: [] };
        const time = () => found.times.push(face.time);
        face.play(take);
        time();
        found.first = Array.from(face.positions);
        // The clock begins with the first picture.
        face.update(1000);
        time();
        face.update(1000.4);
        time();
        found.there = Array.from(face.positions);
        face.paused = true;
        face.update(1000.9);
        time();
        face.paused = false;
        face.update(1001);
        time();
        face.seek(1.23);
        found.sought = Array.from(face.positions);
        // Just before the end, and one frame after it.
        face.seek(take.duration);
        found.last = Array.from(face.positions);
        face.update(1001 + 1.5 / take.rate);
        time();
        face.play(take, { loop: false, at: take.duration - 0.1, speed: 2 });
        face.update(5);
        face.update(6);
        time();
        face.stop();
        time();
        found.standing = await refused(() => face.seek(1));
        const turning = await player.Take.load('head.csv', face);
        face.play(turning, { at: 1 });
        found.head = [...mesh.quaternion.toArray(), ...mesh.position.toArray()];
        face.play(turning, { at: 1.5, head: false });
        found.still = [...mesh.quaternion.toArray(), ...mesh.position.toArray()];
        return found;",
    );
    let faces = &package().faces;
    let take = &faces.take;
    let (rate, duration) = (take.rate(), take.times[take.frames() - 1] - take.times[0]);
    let facts = floats(&json!([found["facts"][0], found["facts"][1], found["facts"][2]]));
    assert_eq!(facts, [take.frames() as f32, rate as f32, duration as f32]);
    assert_eq!((&found["facts"][3], &found["facts"][4]), (&json!(false), &json!([])));
    let times: Vec<f64> =
        found["times"].as_array().unwrap().iter().map(|t| t.as_f64().unwrap_or(-1.0)).collect();
    let expected = [0.0, 0.0, 0.4, 0.4, 0.5, 0.5 / rate, duration, -1.0];
    assert_eq!(times.len(), expected.len());
    for (found, expected) in times.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{times:?}, expected {expected:?}");
    }
    assert_eq!(floats(&found["first"]), faces.frame(0));
    assert_eq!(floats(&found["last"]), faces.frame(take.frames() - 1));
    for (name, seconds) in [("there", 0.4), ("sought", 1.23)] {
        let off = off(&floats(&found[name]), &at(take, seconds));
        assert!(off < 1e-5, "{name}: {off}");
    }
    assert_eq!(found["standing"]["kind"], "Empty");
    let head = faces.head.head.as_ref().unwrap();
    let frame = rate.round() as usize;
    let numbers: Vec<f64> = head[frame].rotation.into_iter().chain(head[frame].translation).collect();
    for name in ["head", "still"] {
        let found = found[name].as_array().unwrap();
        let off =
            found.iter().zip(&numbers).map(|(a, b)| (a.as_f64().unwrap() - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{name}: {found:?}, expected {numbers:?}");
    }
}

#[test]
fn missing_markers_are_refused_or_held_as_the_policy_says() {
    let (found, said) = heard(
        "gpu.html",
        "const face = await player.Face.load('learned.safetensors');
        const load = (missing) => player.Take.load('gap.csv', face, { missing });
        const found = { default: await refused(() => player.Take.load('gap.csv', face)), names: player.MISSING };
        found.error = await refused(() => load('error'));
        found.unknown = await refused(() => load('leave'));
        face.play(await load('hold'), { at: 40 / 30 });
        found.held = Array.from(face.positions);
        const far = await player.Take.load('far.csv', face);
        found.warnings = far.warnings;
        return found;",
        json!({}),
    );
    let faces = &package().faces;
    assert_eq!(found["names"], json!(["error", "hold"]));
    for name in ["default", "error"] {
        assert_eq!(found[name]["kind"], "MissingSamples");
        let sentence = found[name]["sentence"].as_str().unwrap();
        assert!(
            sentence.starts_with("gap.csv, line 42: frame 40: marker ") && sentence.contains("is missing"),
            "{sentence}"
        );
    }
    let sentence = found["unknown"]["sentence"].as_str().unwrap();
    assert!(sentence.contains("“leave”, expected one of error, hold"), "{sentence}");
    let held = floats(&found["held"]);
    assert_eq!(held[..3], faces.frame(GAP - 1)[..3], "the marker that is missing");
    assert!(off(&held[3..], &faces.frame(GAP)[3..]) < 1e-4, "the others");
    assert_ne!(faces.frame(GAP)[..3], faces.frame(GAP - 1)[..3]);
    let warning = found["warnings"][0].as_str().unwrap();
    assert!(warning.starts_with("far.csv: in every frame the markers are at least"), "{warning}");
    // The console has it, too.
    assert_eq!(said, json!([format!("rhytid: {warning}")]));
}
