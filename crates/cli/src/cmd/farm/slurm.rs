//! The script that submits a job to Slurm: an array of tasks for each step.

use super::job::Job;
use super::template::steps;
use crate::args::StepName;
use std::fmt::Write;

/// The script's file in the job's folder.
pub(super) const SCRIPT: &str = "slurm.sh";
/// What all jobs share.
const FUNCTIONS: &str = include_str!("slurm.sh");

/// The script of a job.
pub(super) fn script(job: &Job) -> String {
    let mut text = FUNCTIONS.to_owned();
    for (step, tasks) in steps(job) {
        let options = match step {
            // A film waits for nothing, and other tasks go first.
            StepName::Film => " --nice=100",
            // After any end: a chunk that failed costs its own take alone, which stitch then refuses.
            StepName::Stitch => " --dependency=\"afterany$numbers\"",
            StepName::Animate => "",
        };
        // The last option of a kind counts, so that the user's options win.
        let _ = writeln!(text, "submit {} {tasks}{options} \"$@\"", step.word());
    }
    text
}
