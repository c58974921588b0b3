//! What goes wrong on machines of a farm: two at once, a full disk, other inputs, parts that are missing.

use super::{Show, list, read, started};
use crate::common::{assert_refused, stderr};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// What a refused task says besides what schedulers read.
fn refused(output: &Output, words: &[&str]) {
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let fails: Vec<&str> = said.lines().filter(|line| line.starts_with("openjd_fail: ")).collect();
    let [fail] = fails[..] else { panic!("{said}") };
    words.iter().for_each(|word| assert!(fail.contains(word), "{word:?} is not in {fail}"));
    let quiet = Output { stdout: Vec::new(), ..output.clone() };
    assert_refused(&quiet, words);
}

/// Two schedulers start the same tasks at once, each without regard for what the other has done.
#[test]
fn two_schedulers_at_once_do_no_damage() {
    let show = Show::new();
    show.three_chunks();
    for round in 0..3 {
        let tasks = ["0", "1", "2", "0", "1", "2"];
        let mut running = tasks.map(|number| {
            let words = ["farm-task", "animate", number, "--job", "JOB/job.json", "--again"];
            started(show.command(&words))
        });
        for task in &mut running {
            assert!(task.wait().unwrap().success(), "round {round}");
        }
        let mut running = ["0", "0"].map(|number| {
            started(show.command(&["farm-task", "stitch", number, "--job", "JOB/job.json", "--again"]))
        });
        for task in &mut running {
            assert!(task.wait().unwrap().success(), "round {round}");
        }
        assert_eq!(show.status(), [("animate".to_owned(), 3, 3), ("stitch".to_owned(), 1, 1)]);
    }
    show.assert_whole();
}

#[test]
fn a_full_disk_costs_the_task_alone() {
    let show = Show::new();
    let out = show.path("JOB");
    fs::create_dir(&out).unwrap();
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=2m", "tmpfs"]).arg(&out).output();
    if !mount.is_ok_and(|output| output.status.success()) {
        rhytid_test_support::skip("this user may not mount a small disk");
        return;
    }
    let _unmount = Unmount(&out);
    show.three_chunks();
    refused(&show.task("animate", "0"), &["speech.000000-000073.usd", "no space left", "not written"]);
    assert_eq!(list(&show.path("JOB/parts")), Vec::<String>::new());
    assert_eq!(show.status()[0].1, 0);
    let larger = Command::new("mount").args(["-o", "remount,size=64m"]).arg(&out).status().unwrap();
    assert!(larger.success());
    for number in ["0", "1", "2"] {
        let output = show.task("animate", number);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    assert!(show.task("stitch", "0").status.success());
    show.assert_whole();
}

/// Four takes of 8 MB do not fit on a disk of 20 MB, and the measurement of one does.
#[test]
fn animations_that_cannot_fit_are_a_warning() {
    let show = Show::new();
    let out = show.path("JOB");
    fs::create_dir(&out).unwrap();
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=20m", "tmpfs"]).arg(&out).output();
    if !mount.is_ok_and(|output| output.status.success()) {
        rhytid_test_support::skip("this user may not mount a small disk");
        return;
    }
    let _unmount = Unmount(&out);
    ["b", "c", "d"].iter().for_each(|name| show.take(&format!("takes/{name}.csv"), 217));
    let takes = ["takes/speech.csv", "takes/b.csv", "takes/c.csv", "takes/d.csv"];
    let words = ["farm", "--rig", "face.safetensors", "-o", "JOB"];
    let warned = |takes: &[&str]| stderr(&show.run(&[&words[..], takes].concat()));
    let said = warned(&takes);
    assert!(
        said.contains("warning: JOB: the animations need about ") && said.contains(" are free there"),
        "{said}"
    );
    assert!(!warned(&takes[..1]).contains("warning: JOB"));
}

struct Unmount<'a>(&'a Path);

impl Drop for Unmount<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}

#[test]
fn stitch_names_missing_parts_and_what_makes_them() {
    let show = Show::new();
    show.three_chunks();
    assert!(show.task("animate", "1").status.success());
    let words =
        ["JOB/speech.usd: 2 of 3 parts are missing", "speech.000146-000217.usd", "farm-task animate 0 --job"];
    refused(&show.task("stitch", "0"), &words);
    assert!(!show.path("JOB/speech.usd").exists());
    // A part that became shorter is a missing one.
    for number in ["0", "2"] {
        assert!(show.task("animate", number).status.success());
    }
    let part = show.path("JOB/parts/speech.000073-000146.usd");
    let bytes = fs::read(&part).unwrap();
    fs::write(&part, &bytes[..bytes.len() / 2]).unwrap();
    refused(&show.task("stitch", "0"), &["1 of 3 parts", "farm-task animate 1 "]);
    let output = show.task("animate", "1");
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(fs::read(&part).unwrap() == bytes);
}

#[test]
fn other_inputs_than_the_jobs_are_refused() {
    let show = Show::new();
    show.three_chunks();
    let take = fs::read(show.path("takes/speech.csv")).unwrap();
    show.take("takes/speech.csv", 216);
    refused(&show.task("animate", "0"), &["takes/speech.csv: is another take", "rhytid farm"]);
    fs::write(show.path("takes/speech.csv"), take).unwrap();
    let rig = show.path("face.safetensors");
    show.done(&["pack", "face.safetensors", "-o", "small.safetensors"]);
    fs::copy(show.path("small.safetensors"), &rig).unwrap();
    refused(&show.task("animate", "0"), &["face.safetensors: is another rig", "rhytid farm"]);
    refused(&show.task("animate", "3"), &["has 3 tasks of the step animate", "the number 3"]);
    let text = fs::read_to_string(show.path("JOB/job.json")).unwrap();
    let version = concat!("\"version\": \"", env!("CARGO_PKG_VERSION"), "\"");
    assert!(text.contains(version));
    fs::write(show.path("JOB/job.json"), text.replace(version, "\"version\": \"0.0.7\"")).unwrap();
    refused(&show.task("animate", "0"), &["is of Rhytid 0.0.7", "one version on all machines"]);
    fs::write(show.path("JOB/job.json"), &text[..text.len() / 2]).unwrap();
    refused(&show.task("animate", "0"), &["JOB/job.json: is no job"]);
}

/// Other options make other files, and records of the former ones do not stand for them.
#[test]
fn a_job_that_is_written_again_is_done_again() {
    let show = Show::new();
    show.three_chunks();
    assert!(show.task("animate", "0").status.success());
    let before = fs::read(show.path("JOB/parts/speech.000000-000073.usd")).unwrap();
    let words = ["farm", "takes/speech.csv", "--rig", "face.safetensors", "-o", "JOB", "--chunk", "73"];
    show.done(&[&words[..], &["--animate", "--detail 0.5"]].concat());
    assert_eq!(show.status()[0].1, 0);
    assert!(show.task("animate", "0").status.success());
    let after = fs::read(show.path("JOB/parts/speech.000000-000073.usd")).unwrap();
    assert!(before != after);
    show.three_chunks();
    assert_eq!(show.status()[0].1, 0, "the record is of the other options");
}

/// All of it moves to another place, as another machine sees it. With paths of its own, a task needs no place
/// of the job at all.
#[test]
fn a_job_can_move() {
    let show = Show::new();
    show.three_chunks();
    let moved = Show { dir: tempfile::tempdir().unwrap() };
    for name in ["face.safetensors", "takes", "JOB"] {
        fs::rename(show.path(name), moved.path(name)).unwrap();
    }
    assert!(moved.task("animate", "0").status.success());
    fs::create_dir(moved.path("elsewhere")).unwrap();
    fs::rename(moved.path("takes"), moved.path("elsewhere/t")).unwrap();
    fs::rename(moved.path("face.safetensors"), moved.path("elsewhere/r.safetensors")).unwrap();
    let here = ["--rig", "elsewhere/r.safetensors", "--takes", "elsewhere/t", "-o", "out"];
    fs::create_dir(moved.path("out")).unwrap();
    let words = ["farm-task", "animate", "1", "--job", "JOB/job.json"];
    moved.done(&[&words[..], &here[..]].concat());
    assert_eq!(list(&moved.path("out/parts")), ["speech.000073-000146.usd"]);
    let record = read(&moved.path("out/records/parts/speech.000073-000146.usd.json"));
    assert_eq!((&record["frames"], &record["verified"]["passed"]), (&73.into(), &true.into()));
}
