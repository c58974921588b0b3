//! `rhytid solve`

use super::doctor;
use crate::progress::{Ui, timed};
use crate::{args, memory, output};
use rhytid::human;
use rhytid::solve::{Report, Severity};
use rhytid::{AtomicFile, Error, Progress, Result, Rig, rig_file};
use std::path::Path;
use std::time::Duration;

/// What a solve came to.
pub(super) struct Solved {
    /// The rig as it was written.
    pub rig: Rig,
    /// Time to read the project and its meshes.
    pub reading: Duration,
    /// Time of the doctor.
    pub examining: Duration,
    /// Time to solve.
    pub solving: Duration,
    /// Time to write the rig file.
    pub writing: Duration,
    /// Size of the rig file.
    pub bytes: u64,
}

/// Solves and says what was done.
///
/// # Errors
/// As [`solve`].
pub(super) fn run(args: &args::Solve, ui: &Ui) -> Result<()> {
    let solved = solve(&args.project, &args.output, ui)?;
    if ui.is_quiet() {
        return Ok(());
    }
    let rig = &solved.rig;
    output::say(&format!(
        "{}: {} vertices, {}, {}, {}, {} per vertex, bending length {} {}; solved in {}, {}",
        args.output.display(),
        human::count(rig.vertices()),
        human::counted(rig.handles.len(), "handle"),
        human::counted(rig.strain_edges.len(), "strain edge"),
        human::counted(rig.example_names.len(), "example"),
        human::counted(rig.influences(), "influence"),
        human::number(rig.bending_length),
        human::unit(rig.metres_per_unit),
        human::duration(solved.solving),
        human::bytes(solved.bytes)
    ))?;
    let steps: Vec<String> =
        ui.finished().iter().map(|(step, time)| format!("{step} {}", human::duration(*time))).collect();
    let peak = memory::peak().map_or(String::new(), |bytes| format!("; peak memory {}", human::bytes(bytes)));
    output::say(&format!("{}{peak}", steps.join(", ")))
}

/// From a project file to a rig file.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading, from the doctor and from writing; [`Error::Cancelled`].
pub(super) fn solve(project: &Path, output: &Path, ui: &Ui) -> Result<Solved> {
    check_output(output)?;
    let (face, reading) = ui.timed("read", || rhytid::formats::project::read(project));
    let face = face?;
    let (report, examining) = ui.timed("examine", || rhytid::solve::examine(&face));
    show(&report, ui)?;
    let (rig, solving) = timed(|| rhytid::solve::solve(&face, ui));
    let rig = rig?;
    drop(face);
    if ui.cancelled() {
        return Err(Error::Cancelled);
    }
    let (written, writing) = ui.timed("write the rig", || {
        let rounded = rig.cast::<f32>();
        drop(rig);
        rig_file::write(output, &rounded).map(|()| rounded)
    });
    let rig = written?;
    let bytes = std::fs::metadata(output).map_err(Error::io(output))?.len();
    Ok(Solved { rig, reading, examining, solving, writing, bytes })
}

/// Whether the rig file can be written: known before the long work rather than after it.
fn check_output(output: &Path) -> Result<()> {
    if output.extension().is_none_or(|ending| ending != "safetensors") {
        return Err(Error::input(format!(
            "{}: expected a name that ends in .safetensors, the format of rig files",
            output.display()
        )));
    }
    AtomicFile::create(output).map(drop)
}

/// Prints what the doctor saw; its errors stop.
fn show(report: &Report, ui: &Ui) -> Result<()> {
    let (errors, others): (Vec<_>, Vec<_>) =
        report.findings.iter().partition(|finding| finding.severity == Severity::Error);
    for finding in others {
        if finding.severity == Severity::Warning || !ui.is_quiet() {
            ui.line(&doctor::line(finding));
        }
    }
    let Some((last, others)) = errors.split_last() else { return Ok(()) };
    for finding in others {
        ui.line(&doctor::line(finding));
    }
    Err(Error::input(last.message.clone()))
}
