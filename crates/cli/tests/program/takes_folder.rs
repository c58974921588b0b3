//! Many takes into a folder: a file for each, one report, and nothing twice.

use crate::common::{Fixture, assert_documented, list, stderr};
use serde_json::Value;

/// A rig and ten takes: eight good ones, one without a marker, and one that is no take. In one of the good
/// ones a marker jumps as no skin does.
fn ten_takes() -> Fixture {
    let fixture = Fixture::new();
    fixture.done("solve face.toml -o face.safetensors");
    let take = fixture.take(20);
    for i in 0..8 {
        // Each is a frame shorter than the one before.
        let rows: Vec<&str> = take.lines().take(21 - i).collect();
        fixture.write(&format!("takes/t{i}.csv"), rows.join("\n") + "\n");
    }
    fixture.write("takes/lacking.csv", "time,chin_x,chin_y,chin_z\n0,0,0,0\n0.04,0,0,0\n");
    fixture.write("takes/noise.csv", [0_u8, 159, 146, 150, 7]);
    fixture
}

const ALL: &str = "takes/t0.csv takes/t1.csv takes/t2.csv takes/t3.csv takes/t4.csv takes/t5.csv takes/t6.csv \
                   takes/t7.csv takes/lacking.csv takes/noise.csv";

/// Animates into a folder. Two takes are bad, so that the exit code is that of a mistake.
fn animate(fixture: &Fixture, takes: &str, options: &str, code: i32) -> Value {
    let line = format!("animate face.safetensors {takes} {options} --device cpu:0 --json");
    let output = fixture.rhytid(&line).output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn counts(report: &Value) -> [u64; 3] {
    ["written", "unchanged", "failed"].map(|key| report[key].as_u64().unwrap())
}

#[test]
fn bad_takes_do_not_stop_the_others_and_nothing_is_done_twice() {
    let fixture = ten_takes();
    let report = animate(&fixture, ALL, "-o out/", 2);
    assert_documented(&report, "animate into a folder");
    assert_eq!(counts(&report), [8, 0, 2]);
    let takes = report["takes"].as_array().unwrap();
    let names: Vec<&str> = takes.iter().map(|take| take["take"].as_str().unwrap()).collect();
    assert_eq!(names[..2], ["takes/lacking.csv", "takes/noise.csv"], "those that failed come first");
    for take in takes {
        let is_bad = take["outcome"] == "failed";
        assert_eq!(take["error"].is_string(), is_bad, "{take}");
        assert!(!is_bad || take["error"].as_str().unwrap().starts_with(take["take"].as_str().unwrap()));
    }
    let mut expected: Vec<String> = (0..8).map(|i| format!("t{i}.usd")).collect();
    expected.extend(["takes.html", "takes.json"].map(str::to_owned));
    expected.sort();
    assert_eq!(list(&fixture.path("out")), expected);
    let stored: Value = serde_json::from_slice(&fixture.read("out/takes.json")).unwrap();
    assert_eq!(stored, report);
    // Each file is the one that its take alone gives.
    fixture.done("animate face.safetensors takes/t3.csv -o alone.usd --device cpu:0");
    assert!(fixture.read("out/t3.usd") == fixture.read("alone.usd"));

    // Nothing is made again. The clock of the file tells.
    let time = |name: &str| std::fs::metadata(fixture.path(name)).unwrap().modified().unwrap();
    let before = time("out/t0.usd");
    let again = animate(&fixture, ALL, "-o out", 2);
    assert_eq!(counts(&again), [0, 8, 2]);
    assert_eq!(time("out/t0.usd"), before);

    // What changed is made again, and so is what is gone or cut short.
    fixture.write("takes/t0.csv", fixture.read_text("takes/t1.csv"));
    std::fs::remove_file(fixture.path("out/t4.usd")).unwrap();
    let part = fixture.read("out/t5.usd");
    fixture.write("out/t5.usd", &part[..part.len() / 2]);
    let good = &ALL[..ALL.find("takes/lacking").unwrap()];
    let changed = animate(&fixture, good, "-o out/", 0);
    assert_eq!(counts(&changed), [3, 5, 0]);
    let written: Vec<&str> = changed["takes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|take| take["outcome"] == "written")
        .map(|take| take["take"].as_str().unwrap())
        .collect();
    assert_eq!(written.len(), 3);
    assert!(["takes/t0.csv", "takes/t4.csv", "takes/t5.csv"].iter().all(|take| written.contains(take)));

    // Another recipe, other options, another rig: all of them again.
    assert_eq!(counts(&animate(&fixture, good, "-o out/ --detail 0.5", 0)), [8, 0, 0]);
    assert_eq!(counts(&animate(&fixture, good, "-o out/ --detail 0.5 --frames ..5", 0)), [8, 0, 0]);
    fixture.replace("face.toml", "bending_length = 3.0", "bending_length = 2.0");
    fixture.done("solve face.toml -o face.safetensors");
    assert_eq!(counts(&animate(&fixture, good, "-o out/ --detail 0.5 --frames ..5", 0)), [8, 0, 0]);
}

#[test]
fn takes_are_ranked_by_what_is_wrong_with_them() {
    let fixture = ten_takes();
    // A marker of the last take jumps by a quarter of the sheet in the middle frames.
    let text = fixture.read_text("takes/t7.csv");
    let jumps = text.lines().enumerate().map(|(i, row)| {
        let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
        if (5..9).contains(&i) {
            let x: f64 = cells[4].parse().unwrap();
            cells[4] = (x + 5.0).to_string();
        }
        cells.join(",") + "\n"
    });
    fixture.write("takes/t7.csv", jumps.collect::<String>());
    let good = &ALL[..ALL.find("takes/lacking").unwrap()];
    let report = animate(&fixture, good, "-o out/{take}/face.glb --shapes 2", 0);
    let first = &report["takes"][0];
    assert_eq!(first["take"], "takes/t7.csv");
    assert_eq!(first["file"], "out/t7/face.glb");
    assert!(first["doubtful_frames"].as_u64().unwrap() >= 4, "{first}");
    assert!(first["events"]["strain"].as_u64().unwrap() >= 1, "{first}");
    assert!(!first["warnings"].as_array().unwrap().is_empty(), "{first}");
    assert_eq!(report["takes"][1]["doubtful_frames"], 0);
    let said = fixture
        .done(&format!("animate face.safetensors {good} -o out/{{take}}/face.glb --shapes 2 --device cpu:0"));
    assert!(
        said.starts_with("out: 0 written, 8 unchanged, 0 failed; out/takes.html shows all of it"),
        "{said}"
    );
    assert!(said.lines().nth(2).unwrap().starts_with("t7 "), "{said}");
}

#[test]
fn what_is_for_one_take_is_refused() {
    let fixture = ten_takes();
    fixture.write("edit.toml", "");
    for option in ["--edit edit.toml", "--masks 64 --wrinkles", "--strain-curves c.csv"] {
        fixture.refused(
            &format!("animate face.safetensors takes/t0.csv -o out/ {option}"),
            &["out/: is a folder for many takes", option.split(' ').next().unwrap()],
        );
    }
    fixture.refused("animate face.safetensors takes/t0.csv -o out/{take}.xyz", &["{take}.xyz"]);
    // The sentence in the report is the one that the take alone gives.
    let report = animate(&fixture, "takes/nowhere.csv", "-o elsewhere/", 2);
    let alone = fixture.refused("animate face.safetensors takes/nowhere.csv -o out/a.usd", &["no such file"]);
    assert!(alone.contains(report["takes"][0]["error"].as_str().unwrap()), "{alone}");
    // A take is never written over.
    fixture.refused("animate face.safetensors takes/t0.csv -o takes/{take}.csv", &["takes/{take}.csv"]);
}
