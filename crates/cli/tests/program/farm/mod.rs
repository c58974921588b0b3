//! Takes on many machines: jobs, what schedulers do with them, and what goes wrong on the way.
#![cfg(target_os = "linux")]

mod faults;
mod openjd;
mod slurm;
mod written;

use crate::common::{demo, list, stderr};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A folder with a rig and takes of it, as a show has them.
pub(crate) struct Show {
    dir: TempDir,
}

/// The frames of the demo's take.
const FRAMES: usize = 217;

impl Show {
    /// The demo's rig, and in `takes/` the demo's take.
    fn new() -> Self {
        let show = Self { dir: TempDir::new().unwrap() };
        fs::copy(demo().join("face.safetensors"), show.path("face.safetensors")).unwrap();
        show.take("takes/speech.csv", FRAMES);
        show
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// Writes the first frames of the demo's take.
    fn take(&self, name: &str, frames: usize) {
        let text = fs::read_to_string(demo().join("performance.csv")).unwrap();
        let rows: Vec<&str> = text.lines().take(frames + 1).collect();
        assert_eq!(rows.len(), frames + 1);
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, rows.join("\n") + "\n").unwrap();
    }

    /// The program with these words, in this folder.
    fn command(&self, words: &[&str]) -> Command {
        command(self.dir.path(), words)
    }

    fn run(&self, words: &[&str]) -> Output {
        self.command(words).output().unwrap()
    }

    /// Runs a command that must succeed. Returns what it printed.
    fn done(&self, words: &[&str]) -> String {
        done(self.command(words))
    }

    /// Writes a job of the take in three chunks, without films.
    fn three_chunks(&self) -> Value {
        let words = ["farm", "takes/speech.csv", "--rig", "face.safetensors", "-o", "JOB", "--chunk", "73"];
        let said = self.done(&[&words[..], &["--film", "none", "--json"]].concat());
        serde_json::from_str(&said).unwrap()
    }

    /// Does a task of the job.
    fn task(&self, step: &str, number: &str) -> Output {
        self.run(&["farm-task", step, number, "--job", "JOB/job.json"])
    }

    fn job(&self) -> Value {
        read(&self.path("JOB/job.json"))
    }

    /// How many tasks of each step are done.
    fn status(&self) -> Vec<(String, u64, u64)> {
        let said: Value = serde_json::from_str(&self.done(&["farm", "-o", "JOB", "--json"])).unwrap();
        let steps = said["steps"].as_array().unwrap().iter();
        let number = |step: &Value, key: &str| step[key].as_u64().unwrap();
        steps
            .map(|step| {
                (step["step"].as_str().unwrap().to_owned(), number(step, "done"), number(step, "tasks"))
            })
            .collect()
    }

    /// Asserts that the job's parts, its animation and nothing else are there, with the bytes that `animate`
    /// and `stitch` give by hand.
    fn assert_whole(&self) {
        let by_hand = TempDir::new().unwrap();
        let at = |name: &str| by_hand.path().join(name);
        fs::create_dir(at("parts")).unwrap();
        let parts =
            ["000000-000073", "000073-000146", "000146-000217"].map(|n| format!("parts/speech.{n}.usd"));
        for (part, frames) in parts.iter().zip(["0..73", "73..146", "146..217"]) {
            let out = at(part);
            let words = [
                "animate",
                "face.safetensors",
                "takes/speech.csv",
                "--device",
                "cpu:0",
                "--frames",
                frames,
                "-o",
            ];
            self.done(&[&words[..], &[out.to_str().unwrap()]].concat());
            assert!(fs::read(&out).unwrap() == fs::read(self.path("JOB").join(part)).unwrap(), "{part}");
        }
        let names = parts.iter().map(|part| part.strip_prefix("parts/").unwrap()).collect::<Vec<_>>();
        assert_eq!(list(&self.path("JOB/parts")), names);
        done(command(by_hand.path(), &["stitch", &parts[0], &parts[1], &parts[2], "-o", "speech.usd"]));
        assert!(fs::read(at("speech.usd")).unwrap() == fs::read(self.path("JOB/speech.usd")).unwrap());
        // Every number of the whole, compared with a fresh evaluation.
        let words = ["verify", "JOB/speech.usd", "--rig", "face.safetensors", "--take", "takes/speech.csv"];
        let found: Value =
            serde_json::from_str(&self.done(&[&words[..], &["--device", "cpu:0", "--json"]].concat()))
                .unwrap();
        assert_eq!((&found["passed"], &found["frames"]), (&true.into(), &FRAMES.into()));
        let partial = list(&self.path("JOB")).into_iter().find(|name| name.contains("partial"));
        assert_eq!(partial, None);
    }
}

/// The program with these words, without the user's settings.
fn command(folder: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhytid"));
    command.args(words).current_dir(folder).env_remove("RUST_LOG").env_remove("RUST_BACKTRACE");
    command.env("XDG_CACHE_HOME", concat!(env!("CARGO_TARGET_TMPDIR"), "/cache"));
    command
}

fn done(mut command: Command) -> String {
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{command:?}: {}{}",
        stderr(&output),
        String::from_utf8_lossy(&output.stdout)
    );
    String::from_utf8(output.stdout).unwrap()
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Starts a command whose output nobody reads.
fn started(mut command: Command) -> Child {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// The processes whose command line has all of these words.
fn processes(words: &[&str]) -> Vec<u32> {
    let ids = fs::read_dir("/proc").unwrap().flatten();
    let ids = ids.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    ids.filter(|id| {
        let line = fs::read(format!("/proc/{id}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).replace('\0', " ");
        words.iter().all(|word| line.contains(word))
    })
    .collect()
}

/// Waits for something, at most two minutes.
fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let since = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(since.elapsed() < Duration::from_secs(120), "{what} did not come");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Kills the process of a task without a warning, while it evaluates.
fn kill_task(show: &Show, number: usize) {
    let at = format!("farm-task animate {number} ");
    let job = show.dir.path().canonicalize().unwrap();
    let id = wait_for("the task", || {
        let program =
            |id: &u32| fs::read_link(format!("/proc/{id}/exe")).is_ok_and(|exe| exe.ends_with("rhytid"));
        processes(&[&at, job.to_str().unwrap()]).into_iter().find(program)
    });
    let killed = Command::new("kill").args(["-9", &id.to_string()]).status().unwrap();
    assert!(killed.success());
}
