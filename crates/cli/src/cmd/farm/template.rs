//! The job template of Open Job Description, version 2023-09, which schedulers such as Deadline Cloud read.
//!
//! A step's tasks are a range of numbers, because a list may have 1,024 elements only. What a number means is
//! in the job's file.

use super::job::{JOB, Job};
use crate::args::StepName;
use serde_json::{Value, json};

/// The template's file in the job's folder.
pub(super) const TEMPLATE: &str = "template.json";
/// The parameter of the tasks, which is their number.
pub(super) const TASK: &str = "Number";
/// Seconds that a task has to stop, before it is killed.
const NOTICE: u32 = 10;

/// The template's name of a step.
pub(super) fn step_name(step: StepName) -> &'static str {
    match step {
        StepName::Animate => "Animate",
        StepName::Stitch => "Stitch",
        StepName::Film => "Film",
    }
}

/// The steps of a job in their order, with their numbers of tasks.
pub(super) fn steps(job: &Job) -> Vec<(StepName, usize)> {
    let mut steps = vec![(StepName::Animate, job.chunks.len())];
    if job.has_parts() {
        steps.push((StepName::Stitch, job.takes.len()));
    }
    if job.film.is_some() {
        steps.push((StepName::Film, job.takes.len()));
    }
    steps
}

/// The template of a job. `name` is for people.
pub(super) fn template(job: &Job, name: &str) -> Value {
    let steps: Vec<Value> = steps(job).into_iter().map(|(name, tasks)| step(name, tasks)).collect();
    // The specification allows 128 characters, and braces have a meaning.
    let is_plain = |c: &char| !c.is_control() && !"{}".contains(*c);
    let name: String = format!("Rhytid {name}").chars().filter(is_plain).take(128).collect();
    json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": name,
        "description": "Plays takes on a rig, frames of a take at a time. `rhytid farm` wrote this file.",
        "parameterDefinitions": parameters(&job.device),
        "steps": steps,
    })
}

fn parameters(device: &str) -> Value {
    json!([
        {
            "name": "Job",
            "type": "PATH",
            "objectType": "FILE",
            "dataFlow": "IN",
            "default": JOB,
            "description": "The list of takes and chunks that `rhytid farm` wrote.",
            "userInterface": {
                "control": "CHOOSE_INPUT_FILE",
                "label": "Job",
                "fileFilters": [{ "label": "Job", "patterns": ["*.json"] }],
            },
        },
        {
            "name": "Rig",
            "type": "PATH",
            "objectType": "FILE",
            "dataFlow": "IN",
            "description": "The rig that plays all takes.",
            "userInterface": {
                "control": "CHOOSE_INPUT_FILE",
                "label": "Rig",
                "fileFilters": [{ "label": "Rigs", "patterns": ["*.safetensors"] }],
            },
        },
        {
            "name": "Takes",
            "type": "PATH",
            "objectType": "DIRECTORY",
            "dataFlow": "IN",
            "description": "The folder that holds all takes of the job.",
            "userInterface": { "control": "CHOOSE_DIRECTORY", "label": "Folder of the takes" },
        },
        {
            "name": "Output",
            "type": "PATH",
            "objectType": "DIRECTORY",
            "dataFlow": "OUT",
            "default": ".",
            "description": "The folder that gets the animations, their parts and the films.",
            "userInterface": { "control": "CHOOSE_DIRECTORY", "label": "Folder of the animations" },
        },
        {
            "name": "Program",
            "type": "STRING",
            "default": "rhytid",
            "minLength": 1,
            "description": "The program on the machines of the farm, of the version that wrote the job.",
            "userInterface": { "control": "LINE_EDIT", "label": "Program" },
        },
        {
            "name": "Device",
            "type": "STRING",
            "default": device,
            "minLength": 1,
            "description": "The device that evaluates frames. With cpu:0, all machines write the same bytes.",
            "userInterface": { "control": "LINE_EDIT", "label": "Device" },
        },
    ])
}

fn step(name: StepName, tasks: usize) -> Value {
    let description = match name {
        StepName::Animate => "Writes a chunk of a take, and compares it with a fresh evaluation.",
        StepName::Stitch => "Puts the parts of a take together.",
        StepName::Film => "Draws a take as a film for review.",
    };
    let mut step = json!({
        "name": step_name(name),
        "description": description,
        "parameterSpace": {
            "taskParameterDefinitions": [
                { "name": TASK, "type": "INT", "range": format!("0-{}", tasks.max(1) - 1) },
            ],
        },
        "script": {
            "actions": {
                "onRun": {
                    "command": "{{Param.Program}}",
                    "args": [
                        "farm-task",
                        name.word(),
                        format!("{{{{Task.Param.{TASK}}}}}"),
                        "--job={{Param.Job}}",
                        "--rig={{Param.Rig}}",
                        "--takes={{Param.Takes}}",
                        "--output={{Param.Output}}",
                        "--device={{Param.Device}}",
                    ],
                    "cancelation": {
                        "mode": "NOTIFY_THEN_TERMINATE",
                        "notifyPeriodInSeconds": NOTICE,
                    },
                },
            },
        },
    });
    // A film is drawn of the rig and the take, so that it waits for nothing.
    if name == StepName::Stitch {
        step["dependencies"] = json!([{ "dependsOn": step_name(StepName::Animate) }]);
    }
    step
}
