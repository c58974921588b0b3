//! `rhytid farm --local N`: runs a job on this machine, by its template, with openjd.

use super::job::{JOB, Job};
use super::record::Target;
use super::status::{can_run, is_done};
use super::template::{TASK, TEMPLATE, step_name, steps};
use crate::args::StepName;
use crate::progress::Ui;
use crate::start;
use rhytid::{Error, Progress, Result};
use std::collections::VecDeque;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The program of Open Job Description.
const OPENJD: &str = "openjd";
/// How often a running task is looked at.
const PAUSE: Duration = Duration::from_millis(50);
/// How long a stopped task has to end.
const PATIENCE: Duration = Duration::from_secs(15);

/// Runs all tasks that are not done, `at_once` at a time. Returns the sentences of those that failed.
///
/// # Errors
/// [`Error::Input`] where there is no openjd; [`Error::Cancelled`]; [`Error::Io`].
pub(super) fn run(job: &Job, folder: &Path, at_once: u16, ui: &Ui) -> Result<Vec<String>> {
    check_openjd()?;
    let folder = folder.canonicalize().map_err(Error::io(folder))?;
    let logs = folder.join("logs");
    fs::create_dir_all(&logs).map_err(Error::io(&logs))?;
    let farm = Farm { job, folder: &folder, logs: &logs, ui };
    let mut failures = Vec::new();
    for (step, tasks) in steps(job) {
        let is_next =
            |number: &usize| !is_done(job, &folder, step, *number) && can_run(job, &folder, step, *number);
        let numbers: VecDeque<usize> = (0..tasks).filter(is_next).collect();
        failures.extend(farm.step(step, numbers, at_once)?);
    }
    Ok(failures)
}

/// An error with what to do where openjd is not installed.
fn check_openjd() -> Result<()> {
    let found = Command::new(OPENJD).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    match found {
        Ok(_) => Ok(()),
        Err(_) => Err(Error::input(
            "--local runs the job with openjd, and there is no openjd in the PATH; install it with \
             `pip install openjd-cli`, or submit the job to a farm",
        )),
    }
}

struct Farm<'a> {
    job: &'a Job,
    folder: &'a Path,
    logs: &'a Path,
    ui: &'a Ui,
}

/// What the threads of a step share.
struct Shared {
    waiting: VecDeque<usize>,
    done: usize,
    failures: Vec<String>,
}

impl Farm<'_> {
    /// Runs tasks of a step. Returns the sentences of those that failed.
    fn step(&self, step: StepName, waiting: VecDeque<usize>, at_once: u16) -> Result<Vec<String>> {
        let total = waiting.len();
        if total == 0 {
            return Ok(Vec::new());
        }
        let threads = usize::from(at_once).min(total);
        let shared = Mutex::new(Shared { waiting, done: 0, failures: Vec::new() });
        let lock = || shared.lock().unwrap_or_else(PoisonError::into_inner);
        self.ui.report(step_name(step), 0, total as u64);
        let work = || -> Result<()> {
            loop {
                let Some(number) = lock().waiting.pop_front() else { return Ok(()) };
                let failure = self.task(step, number)?;
                let mut shared = lock();
                shared.done += 1;
                if let Some(failure) = failure {
                    self.ui.line(&format!("error: {failure}"));
                    shared.failures.push(failure);
                }
                self.ui.report(step_name(step), shared.done as u64, total as u64);
            }
        };
        thread::scope(|scope| {
            let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            threads.into_iter().try_for_each(|thread| match thread.join() {
                Ok(result) => result,
                Err(_) => Err(Error::Internal("a thread that runs tasks ended".into())),
            })
        })?;
        Ok(shared.into_inner().unwrap_or_else(PoisonError::into_inner).failures)
    }

    /// Runs a task to its end. Returns the sentence of one that failed.
    fn task(&self, step: StepName, number: usize) -> Result<Option<String>> {
        let log = self.logs.join(format!("{}-{number}.txt", step.word()));
        let mut child = self.start(step, number, &log)?;
        loop {
            if let Some(status) = child.try_wait().map_err(Error::io(Path::new(OPENJD)))? {
                if self.ui.cancelled() {
                    return Err(Error::Cancelled);
                }
                return Ok((!status.success()).then(|| self.failure(step, number, &log)));
            }
            if self.ui.cancelled() {
                stop(&mut child);
                return Err(Error::Cancelled);
            }
            thread::sleep(PAUSE);
        }
    }

    fn start(&self, step: StepName, number: usize, log: &Path) -> Result<Child> {
        let Self { job, folder, .. } = self;
        let places = job.places(folder);
        let output = File::create(log).map_err(Error::io(log))?;
        let errors = output.try_clone().map_err(Error::io(log))?;
        let mut command = Command::new(OPENJD);
        command.arg("run").arg(folder.join(TEMPLATE)).args(["--step", step_name(step)]);
        command.arg("--tasks").arg(format!("[{{\"{TASK}\": {number}}}]"));
        let values = [
            ("Job", folder.join(JOB)),
            ("Rig", places.rig),
            ("Takes", places.takes),
            ("Output", places.output),
            ("Program", program()),
            ("Device", PathBuf::from(&job.device)),
        ];
        for (name, value) in values {
            let mut word = std::ffi::OsString::from(format!("{name}="));
            word.push(value);
            command.arg("--job-param").arg(word);
        }
        command.stdin(Stdio::null()).stdout(output).stderr(errors);
        command.spawn().map_err(Error::io(Path::new(OPENJD)))
    }

    /// The sentence of a task that failed, from its log.
    fn failure(&self, step: StepName, number: usize, log: &Path) -> String {
        let text = fs::read_to_string(log).unwrap_or_default();
        let said = text.lines().rev().find_map(|line| line.split_once("openjd_fail: ")).map(|(_, said)| said);
        let said = said.unwrap_or("it said nothing; perhaps it was killed");
        let take = Target::of(self.job, step, number).take;
        format!(
            "{} {number} ({}): {said} ({} has all of it)",
            step.word(),
            self.job.takes[take].name,
            log.display()
        )
    }
}

/// The program that tasks start: this one.
fn program() -> PathBuf {
    let again = start::again();
    // In another program's process, such as Python's, the program has its name in the PATH.
    let own = again.filter(|command| command.get_args().len() == 0);
    own.map_or_else(|| PathBuf::from("rhytid"), |command| PathBuf::from(command.get_program()))
}

/// Asks openjd to stop its task, and waits until it has ended.
fn stop(child: &mut Child) {
    #[cfg(unix)]
    if let Some(id) = rustix::process::Pid::from_raw(child.id() as i32) {
        let _ = rustix::process::kill_process(id, rustix::process::Signal::TERM);
        let since = Instant::now();
        while since.elapsed() < PATIENCE {
            if !matches!(child.try_wait(), Ok(None)) {
                return;
            }
            thread::sleep(PAUSE);
        }
    }
    let _ = child.kill();
    let _ = child.wait();
}
