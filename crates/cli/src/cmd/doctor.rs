//! `rhytid doctor`

use crate::progress::Ui;
use crate::{args, exit_code, inputs, output};
use rhytid::Result;
use rhytid::core::human;
use rhytid::formats::project;
use rhytid::solve::{Finding, Report, Severity};
use serde::Serialize;

#[derive(Serialize)]
struct Examination<'a> {
    file: String,
    solvable: bool,
    errors: usize,
    warnings: usize,
    notes: usize,
    findings: &'a [Finding],
}

/// Prints what the doctor saw.
///
/// # Errors
/// As [`rhytid::formats::project::read`]: what cannot be read cannot be examined.
pub(super) fn run(args: &args::Doctor, ui: &Ui) -> Result<u8> {
    inputs::project(&args.project, "rhytid doctor FACE.toml")?;
    let (path, reach) = (&args.project, args.elsewhere.reach());
    let face = project::load(&project::read_project(path)?, path, reach)?;
    let report = rhytid::solve::examine(&face);
    let count = |severity| report.findings.iter().filter(|f| f.severity == severity).count();
    let examination = Examination {
        file: args.project.display().to_string(),
        solvable: count(Severity::Error) == 0,
        errors: count(Severity::Error),
        warnings: count(Severity::Warning),
        notes: count(Severity::Note),
        findings: &report.findings,
    };
    if args.json.wanted {
        output::json(&examination)?;
    } else if !(ui.is_quiet() && examination.solvable) {
        output::say(&text(&report, &examination))?;
    }
    Ok(if examination.solvable { exit_code::DONE } else { exit_code::USER })
}

fn text(report: &Report, examination: &Examination<'_>) -> String {
    let mut lines: Vec<String> = report.findings.iter().map(line).collect();
    lines.push(format!(
        "{}: {}, {}, {}; the face {} be solved",
        examination.file,
        human::counted(examination.errors, "error"),
        human::counted(examination.warnings, "warning"),
        human::counted(examination.notes, "note"),
        if examination.solvable { "can" } else { "cannot" }
    ));
    lines.join("\n")
}

/// A finding as one line: `warning: …`.
pub(super) fn line(finding: &Finding) -> String {
    let severity = match finding.severity {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    };
    format!("{severity}: {}", finding.message)
}
