//! `must-pass.txt`: every name that must report. A missing case is a failure, and so is one that is not
//! listed.
use crate::Suite;
use crate::outcome::{Outcome, Verdict};
use std::collections::{BTreeMap, BTreeSet};

/// The names, such as `normals/holes`, that must report in a suite.
pub fn must_pass(suite: Suite) -> BTreeSet<&'static str> {
    let lines = include_str!("../must-pass.txt").lines().filter(|line| !line.starts_with('#'));
    lines
        .filter_map(|line| line.split_once(' '))
        .filter(|(of, _)| *of == "quick" || suite == Suite::Full)
        .map(|(_, name)| name)
        .collect()
}

/// Compares what a device reported with the list: one outcome, named `must-pass`.
pub fn check_must_pass(device: &str, suite: Suite, reported: &[Outcome]) -> Outcome {
    let listed = must_pass(suite);
    let mut reports: BTreeMap<&str, usize> = BTreeMap::new();
    let reported = reported.iter().filter(|outcome| outcome.verdict != Verdict::NoDevice);
    for outcome in reported {
        *reports.entry(&outcome.name).or_default() += 1;
    }
    let mut problems = Vec::new();
    let mut list = |what: &str, names: Vec<&str>| {
        if !names.is_empty() {
            problems.push(format!("{what}: {}", names.join(", ")));
        }
    };
    list("did not report", listed.iter().copied().filter(|name| !reports.contains_key(name)).collect());
    list(
        "reported but not in must-pass.txt",
        reports.keys().copied().filter(|name| !listed.contains(name)).collect(),
    );
    list("reported twice", reports.iter().filter(|(_, n)| **n > 1).map(|(name, _)| *name).collect());
    let verdict = if problems.is_empty() { Verdict::Pass } else { Verdict::Fail };
    Outcome::new(device, "must-pass".into(), verdict, problems.join("; "))
}
