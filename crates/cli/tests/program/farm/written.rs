//! What a job is of: its takes, its kinds of files, its options.

use super::{FRAMES, Show, list, read};
use crate::common::raw::Raw;
use crate::common::{assert_documented, assert_refused, stderr};
use serde_json::Value;
use std::fs;

#[test]
fn what_is_printed_is_documented() {
    let show = Show::new();
    let said = show.three_chunks();
    assert_documented(&said, "farm");
    assert_eq!((&said["takes"], &said["frames"], &said["chunks"]), (&1.into(), &FRAMES.into(), &3.into()));
    assert_eq!((&said["frames_of_chunk"], &said["speed"]), (&73.into(), &Value::Null));
    assert_eq!(said["steps"][0], serde_json::json!({ "step": "animate", "tasks": 3, "done": 0 }));
}

/// Blanks, umlauts, one name in two folders, and names that no file can have elsewhere.
#[test]
fn any_name_of_a_take_is_a_name_of_a_file() {
    let show = Show::new();
    for name in ["takes/Ännchen 1.csv", "takes/b/Ännchen 1.csv", "takes/b/a:b@2.csv"] {
        show.take(name, 5);
    }
    let takes = ["takes/Ännchen 1.csv", "takes/b/Ännchen 1.csv", "takes/b/a:b@2.csv"];
    let words = ["farm", "--rig", "face.safetensors", "-o", "die Arbeit", "--chunk", "3", "--film", "none"];
    let said = show.done(&[&words[..], &takes[..]].concat());
    assert!(said.contains("die Arbeit: 3 takes, 15 frames, 6 chunks of at most 3 frames"), "{said}");
    assert!(said.contains("rhytid farm -o \"die Arbeit\" --local 2"), "{said}");
    let job = read(&show.path("die Arbeit/job.json"));
    let names: Vec<&str> =
        job["takes"].as_array().unwrap().iter().map(|t| t["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["Ännchen 1", "Ännchen 1 2", "a_b_2"]);
    for number in 0..6 {
        show.done(&["farm-task", "animate", &number.to_string(), "--job", "die Arbeit/job.json"]);
    }
    for (number, name) in names.iter().enumerate() {
        show.done(&["farm-task", "stitch", &number.to_string(), "--job", "die Arbeit/job.json"]);
        let file = format!("die Arbeit/{name}.usd");
        show.done(&[
            "verify",
            &file,
            "--rig",
            "face.safetensors",
            "--take",
            takes[number],
            "--device",
            "cpu:0",
        ]);
    }
}

#[test]
fn a_take_that_cannot_be_played_is_left_out_with_its_sentence() {
    let show = Show::new();
    fs::write(show.path("takes/lacking.csv"), "time,chin_x,chin_y,chin_z\n0,0,0,0\n0.04,0,0,0\n").unwrap();
    let words = ["farm", "--rig", "face.safetensors", "-o", "JOB", "--chunk", "100", "--json"];
    let takes = ["takes/lacking.csv", "takes/speech.csv", "takes/gone.csv"];
    let output = show.run(&[&words[..], &takes[..]].concat());
    assert_eq!(output.status.code(), Some(2));
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&said["takes"], &said["chunks"]), (&1.into(), &3.into()));
    for (failed, take) in
        said["failed"].as_array().unwrap().iter().zip(["takes/lacking.csv", "takes/gone.csv"])
    {
        assert_eq!(failed["take"], take);
        assert!(failed["error"].as_str().unwrap().starts_with(take), "{failed}");
        assert!(stderr(&output).contains(&format!("error: {}", failed["error"].as_str().unwrap())));
    }
    let none =
        show.run(&["farm", "takes/gone.csv", "--rig", "face.safetensors", "-o", "NONE", "--chunk", "9"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(stderr(&none).contains("no take can be played"), "{}", stderr(&none));
    assert!(!show.path("NONE").exists());
    assert_refused(&show.run(&["farm", "-o", "NONE"]), &["NONE: holds no job", "rhytid farm TAKE"]);
}

/// glTF cannot be stitched: a take is one task.
#[test]
fn what_cannot_be_stitched_is_a_task_for_each_take() {
    let show = Show::new();
    let words = ["farm", "takes/speech.csv", "--rig", "face.safetensors", "-o", "JOB", "--kind", "glb"];
    let options = ["--animate", "--compressed --max-error 0.2", "--chunk", "50", "--film", "none"];
    show.done(&[&words[..], &options[..]].concat());
    let template = read(&show.path("JOB/template.json"));
    assert_eq!(template["steps"].as_array().unwrap().len(), 1);
    assert_eq!(show.job()["chunks"].as_array().unwrap().len(), 1);
    assert!(show.task("animate", "0").status.success());
    let animate =
        ["animate", "face.safetensors", "takes/speech.csv", "--device", "cpu:0", "-o", "alone/speech.glb"];
    fs::create_dir(show.path("alone")).unwrap();
    show.done(&[&animate[..], &["--compressed", "--max-error", "0.2"]].concat());
    let [farm, alone] = ["JOB/speech.glb", "alone/speech.glb"].map(|name| fs::read(show.path(name)).unwrap());
    assert!(farm == alone);
}

#[test]
fn options_that_are_for_one_take_are_refused() {
    let show = Show::new();
    let words = ["farm", "takes/speech.csv", "--rig", "face.safetensors", "-o", "JOB"];
    for (options, says) in [
        ("--edit edit.toml", "--edit is for one"),
        ("--nonsense", "--nonsense"),
        ("--setup 'a", "has no end"),
        ("--fps 24 --fps 25", "--fps"),
        ("-o x.usd", "--output"),
        ("--compressed", "--compressed is for glTF"),
    ] {
        let output = show.run(&[&words[..], &["--animate", options]].concat());
        assert_refused(&output, &[says]);
        assert!(!show.path("JOB").exists(), "{options}");
    }
    assert_refused(&show.run(&[&words[..], &["--kind", "pc2"]].concat()), &["--kind pc2", "usd"]);
}

/// Without --chunk, the length of a chunk comes from a measurement of this machine.
#[test]
fn a_chunk_has_the_length_that_was_measured() {
    let show = Show::new();
    let words =
        ["farm", "takes/speech.csv", "--rig", "face.safetensors", "-o", "JOB", "--film", "none", "--json"];
    let said: Value =
        serde_json::from_str(&show.done(&[&words[..], &["--minutes", "0.1"]].concat())).unwrap();
    let speed = |key: &str| said["speed"][key].as_f64().unwrap();
    let frames = (6.0 - speed("start_seconds")) / speed("frame_seconds");
    assert_eq!(said["frames_of_chunk"], (frames as u64).max(1));
    // How much longer a file with so many frames is than one with the first four.
    let bytes = |frames: &str| {
        let out = show.path(&format!("{frames}.usd")).display().to_string();
        show.done(&[
            "animate",
            "face.safetensors",
            "takes/speech.csv",
            "-o",
            &out,
            "--frames",
            &format!("0..{frames}"),
        ]);
        fs::metadata(out).unwrap().len() as f64
    };
    let of_frame = |frames: &str| (bytes(frames) - bytes("4")) / (frames.parse::<f64>().unwrap() - 4.0);
    assert!(["32", "128", "217"].iter().any(|frames| of_frame(frames) == speed("frame_bytes")), "{said}");
    let left = list(&show.path("JOB"));
    assert_eq!(left, ["job.json", "slurm.sh", "template.json"], "nothing of the measurement stays");
}

/// A raw take with its setup, which is found below the takes' folder on any machine.
/// A film has the rate of the animation, if the job says nothing else.
#[test]
fn a_film_has_the_rate_of_the_animation() {
    let show = Show::new();
    show.take("takes/short.csv", 12);
    let words = ["farm", "takes/short.csv", "--rig", "face.safetensors", "-o", "JOB", "--chunk", "99"];
    let words = [&words[..], &["--animate", "--fps 10"]].concat();
    show.done(&[&words[..], &["--film", "48x64"]].concat());
    show.done(&["farm-task", "film", "0", "--job", "JOB/job.json"]);
    let film = read(&show.path("JOB/records/films/short.mp4.json"));
    assert_eq!(film["frames"], 4);
    let output = show.run(&[&words[..], &["--film", "none", "--film-fps", "5"]].concat());
    assert_refused(&output, &["--film-fps", "--film none"]);
}

#[test]
fn a_setup_goes_with_the_takes() {
    let show = Show::new();
    let raw = Raw::new();
    raw.write(&|_, _, place| Some(place));
    fs::copy(raw.path("raw.trc"), show.path("takes/raw.trc")).unwrap();
    fs::write(show.path("takes/anna.toml"), "unit = \"mm\"\n").unwrap();
    let words = ["farm", "takes/raw.trc", "--rig", "face.safetensors", "-o", "JOB", "--chunk", "200"];
    show.done(&[&words[..], &["--animate", "--setup takes/anna.toml", "--film", "none"]].concat());
    assert_eq!(show.job()["options"], serde_json::json!(["--setup", "anna.toml"]));
    fs::rename(show.path("takes"), show.path("t")).unwrap();
    let there = ["--takes", "t"];
    let task = ["farm-task", "animate", "1", "--job", "JOB/job.json"];
    show.done(&[&task[..], &there[..]].concat());
    let animate = ["animate", "face.safetensors", "t/raw.trc", "--setup", "t/anna.toml", "--device", "cpu:0"];
    show.done(&[&animate[..], &["--frames", "200..", "-o", "alone.usd"]].concat());
    let part = fs::read(show.path("JOB/parts/raw.000200-000217.usd")).unwrap();
    assert!(part == fs::read(show.path("alone.usd")).unwrap());
    fs::write(show.path("t/anna.toml"), "unit = \"mm\"\nskip = [\"low-pass\"]\n").unwrap();
    let output = show.run(&[&task[..], &there[..], &["--again"]].concat());
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("a setup or shapes that the options name are others"),
        "{}",
        stderr(&output)
    );
}
