//! How far a job is, by the records of its tasks.

use super::job::Job;
use super::record::Target;
use super::template::steps;
use crate::args::StepName;
use crate::output;
use rhytid::core::human;
use serde::Serialize;
use std::path::Path;

/// Whether a task of a job whose animations are in `output` is done.
pub(super) fn is_done(job: &Job, output: &Path, step: StepName, number: usize) -> bool {
    Target::of(job, step, number).done(output).is_some()
}

/// Whether a task has all that it needs.
pub(super) fn can_run(job: &Job, output: &Path, step: StepName, number: usize) -> bool {
    let chunks = if step == StepName::Stitch { job.chunks_of(number) } else { Vec::new() };
    chunks.iter().all(|(number, _)| is_done(job, output, StepName::Animate, *number))
}

/// How far a step is.
#[derive(Debug, Serialize)]
pub(super) struct StepStatus {
    pub step: String,
    pub tasks: usize,
    pub done: usize,
}

/// How far each step is.
pub(super) fn of_steps(job: &Job, output: &Path) -> Vec<StepStatus> {
    let of_step = |(step, tasks): (StepName, usize)| {
        let done = (0..tasks).filter(|number| is_done(job, output, step, *number)).count();
        StepStatus { step: step.word(), tasks, done }
    };
    steps(job).into_iter().map(of_step).collect()
}

/// The steps in words, a line for each.
pub(super) fn words(steps: &[StepStatus]) -> String {
    let row = |status: &StepStatus| {
        let what = match status.step.as_str() {
            "animate" => "chunks written and verified",
            "stitch" => "takes put together",
            _ => "films drawn",
        };
        [what.to_owned(), format!("{} of {}", human::count(status.done), human::count(status.tasks))]
    };
    output::table(&steps.iter().map(row).collect::<Vec<_>>())
}
