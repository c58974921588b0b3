//! Jobs by Open Job Description: the template, tasks that are killed, and `--local`.

use super::{Show, command, kill_task, list, processes, read, started, wait_for};
use crate::common::{assert_refused, stderr};
use rhytid_test_support::installed;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// The folder with openjd, in front of the path.
fn path() -> std::ffi::OsString {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH").unwrap()).collect();
    let openjd = installed("venv-farm/bin/openjd").canonicalize().unwrap().parent().unwrap().to_owned();
    std::env::join_paths([openjd].into_iter().chain(folders)).unwrap()
}

/// `openjd run` of a step, as a user types it.
fn openjd_run(show: &Show, step: &str) -> Command {
    let at = |name: &str| show.path(name).canonicalize().unwrap().display().to_string();
    let mut command = Command::new("openjd");
    command.env("PATH", path()).args(["run", "JOB/template.json", "--step", step, "--run-dependencies"]);
    command.args(["-p", &format!("Program={}", env!("CARGO_BIN_EXE_rhytid"))]);
    command.args(["-p", &format!("Rig={}", at("face.safetensors")), "-p", &format!("Takes={}", at("takes"))]);
    command.current_dir(show.dir.path());
    command
}

fn local(show: &Show, words: &[&str]) -> Output {
    show.command(words).env("PATH", path()).output().unwrap()
}

/// A template is valid by the specification's own program. A list has at most 1,024 elements there.
#[test]
fn the_template_is_valid_with_thousands_of_chunks() {
    let show = Show::new();
    let takes: Vec<String> = (0..8).map(|n| format!("takes/{n}.csv")).collect();
    takes.iter().for_each(|take| show.take(take, 217));
    let takes: Vec<&str> = takes.iter().map(String::as_str).collect();
    show.done(&[&["farm", "--rig", "face.safetensors", "-o", "JOB", "--chunk", "1"], &takes[..]].concat());
    let job = show.job();
    assert_eq!(job["chunks"].as_array().unwrap().len(), 8 * 217);
    let template = read(&show.path("JOB/template.json"));
    assert_eq!(template["steps"].as_array().unwrap().len(), 3);
    for parameter in template["parameterDefinitions"].as_array().unwrap() {
        assert!(parameter["description"].as_str().unwrap().ends_with('.'), "{parameter}");
        assert!(parameter["userInterface"]["label"].is_string(), "{parameter}");
    }
    let mut openjd = Command::new("openjd");
    let checked =
        openjd.env("PATH", path()).arg("check").arg(show.path("JOB/template.json")).output().unwrap();
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
    let mut openjd = Command::new("openjd");
    openjd.env("PATH", path()).arg("summary").arg(show.path("JOB/template.json"));
    let summary = openjd.args(["-p", "Rig=r", "-p", "Takes=t"]).output().unwrap();
    let summary = String::from_utf8_lossy(&summary.stdout).into_owned();
    assert!(summary.contains("1736") || summary.contains("Total steps: 3"), "{summary}");
}

/// 217 frames in three chunks. A task is killed while it evaluates, and the same command then ends the job.
#[test]
fn a_killed_task_costs_its_chunk() {
    let show = Show::new();
    show.three_chunks();
    let mut running = started(openjd_run(&show, "Stitch"));
    kill_task(&show, 1);
    assert!(!running.wait().unwrap().success(), "a killed task is a failure");
    assert_eq!(list(&show.path("JOB/parts")), ["speech.000000-000073.usd"], "no half part");
    assert_eq!(show.status(), [("animate".to_owned(), 1, 3), ("stitch".to_owned(), 0, 1)]);
    let time = || fs::metadata(show.path("JOB/parts/speech.000000-000073.usd")).unwrap().modified().unwrap();
    let before = time();
    let again = openjd_run(&show, "Stitch").output().unwrap();
    let said = String::from_utf8_lossy(&again.stdout).into_owned();
    assert!(again.status.success(), "{said}");
    assert_eq!(time(), before, "what is done is left");
    assert!(said.contains("is there already"), "{said}");
    // What schedulers show.
    assert!(said.contains("openjd_progress: 100.0"), "{said}");
    assert!(said.contains("openjd_status: verify"), "{said}");
    show.assert_whole();
}

#[test]
fn a_local_run_ends_a_job_and_then_leaves_it() {
    let show = Show::new();
    show.take("takes/short.csv", 12);
    let words = ["farm", "takes/speech.csv", "takes/short.csv", "--rig", "face.safetensors", "-o", "JOB"];
    let words =
        [&words[..], &["--chunk", "73", "--film", "48x64", "--film-fps", "15", "--local", "2"]].concat();
    let output = local(&show, &words);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", stderr(&output));
    assert!(said.contains("chunks written and verified  4 of 4"), "{said}");
    assert!(said.contains("takes put together           2 of 2"), "{said}");
    assert!(said.contains("films drawn                  2 of 2") && !said.contains("Next:"), "{said}");
    assert!(fs::metadata(show.path("JOB/films/speech.mp4")).unwrap().len() > 1000);
    let frames =
        |film: &str| read(&show.path(&format!("JOB/records/films/{film}.mp4.json")))["frames"].clone();
    assert_eq!((frames("speech"), frames("short")), (109.into(), 6.into()), "half of 217 and of 12");
    fs::remove_file(show.path("JOB/parts/short.000000-000012.usd")).unwrap();
    let logs = || list(&show.path("JOB/logs")).len();
    assert_eq!(logs(), 8);
    fs::remove_dir_all(show.path("JOB/logs")).unwrap();
    let again = local(&show, &["farm", "-o", "JOB", "--local", "4"]);
    assert!(again.status.success(), "{}", stderr(&again));
    assert_eq!(logs(), 1, "the chunk that is gone is written again, and nothing else");
    let wrong =
        show.run(&["verify", "JOB/short.usd", "--rig", "face.safetensors", "--take", "takes/short.csv"]);
    assert!(wrong.status.success(), "{}", stderr(&wrong));
    fs::remove_file(show.path("JOB/parts/short.000000-000012.usd")).unwrap();
    show.take("takes/short.csv", 11);
    // A task that fails has its sentence, and the others go on.
    fs::remove_file(show.path("JOB/speech.usd")).unwrap();
    let failed = local(&show, &["farm", "-o", "JOB", "--local", "1"]);
    let said = stderr(&failed);
    assert_eq!(failed.status.code(), Some(2), "{said}");
    assert!(said.contains("error: animate 3 (short): ") && said.contains("is another take than"), "{said}");
    assert!(show.path("JOB/speech.usd").exists());
}

#[test]
fn without_openjd_a_sentence_says_how_to_get_it() {
    let show = Show::new();
    show.three_chunks();
    let output =
        show.command(&["farm", "-o", "JOB", "--local", "2"]).env("PATH", "/nowhere").output().unwrap();
    assert_refused(&output, &["no openjd", "pip install openjd-cli"]);
}

/// Ctrl-C ends what was started. The take is so long that its task would end much later by itself.
#[test]
fn nothing_goes_on_after_ctrl_c() {
    let show = Show::new();
    let text = fs::read_to_string(show.path("takes/speech.csv")).unwrap();
    let (heading, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().map(|row| row.split_once(',').unwrap().1).collect();
    let there_and_back: Vec<&str> = rows.iter().chain(rows.iter().rev()).copied().collect();
    let mut long = format!("{heading}\n");
    for (frame, row) in there_and_back.iter().cycle().take(20_000).enumerate() {
        long += &format!("{:.6},{row}\n", frame as f64 / 30.0);
    }
    fs::write(show.path("takes/speech.csv"), long).unwrap();
    show.done(&["farm", "takes/speech.csv", "--rig", "face.safetensors", "-o", "JOB", "--chunk", "20000"]);
    let mut command = command(show.dir.path(), &["farm", "-o", "JOB", "--local", "2"]);
    command.env("PATH", path());
    let mut running = started(command);
    let job = show.path("JOB/job.json").canonicalize().unwrap().display().to_string();
    let tasks = || processes(&["farm-task animate", &job]);
    wait_for("a task", || (!tasks().is_empty()).then_some(()));
    Command::new("kill").args(["-INT", &running.id().to_string()]).status().unwrap();
    assert_eq!(running.wait().unwrap().code(), Some(2));
    wait_for("the end of all tasks", || tasks().is_empty().then_some(()));
    assert!(!show.path("JOB/parts/speech.000000-020000.usd").exists());
    assert_eq!(show.status()[0].1, 0);
}
