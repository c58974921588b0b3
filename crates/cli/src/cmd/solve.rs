//! `rhytid solve`

use super::doctor;
use crate::args;
use crate::inputs;
use crate::memory;
use crate::output;
use crate::progress::{Ui, timed};
use crate::remedy;
use rhytid::core::AtomicFile;
use rhytid::core::human;
use rhytid::core::rig_file;
use rhytid::formats::take::{self, Missing};
use rhytid::formats::{Reach, project, refuse_inputs};
use rhytid::playback::{ExampleResiduals, example_residuals, rig_diff};
use rhytid::solve::{Candidate, FreePart, Report, Severity, SolveReport};
use rhytid::{Error, Face, Progress, Result, Rig};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Largest number of frames in which a rig is compared with its earlier version.
const COMPARED: usize = 200;

/// A smaller motion, in metres, cannot be seen.
const SEEN: f64 = 1e-4;

/// The number of parts without a handle that are named. A head has dozens, such as teeth and lashes.
const PARTS_NAMED: usize = 8;

/// The result of a solve.
pub(super) struct Solved {
    /// The rig as it was written.
    pub rig: Rig,
    /// The findings of the solve.
    pub report: SolveReport,
    /// How near the rig is to the scans.
    pub scans: Vec<ExampleResiduals>,
    /// What sculpted examples change, if there are any.
    pub sculpted: Option<String>,
    /// Time to read the project and its meshes; 0 if reading is no part of the solve.
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
    let solved = solve(&args.project, &args.output, args.elsewhere.reach(), ui)?;
    say(&solved, &args.output, ui)
}

/// Says what was done.
///
/// # Errors
/// As [`output::say`].
pub(super) fn say(solved: &Solved, written: &Path, ui: &Ui) -> Result<()> {
    if ui.is_quiet() {
        return Ok(());
    }
    let rig = &solved.rig;
    output::say(&format!(
        "{}: {} vertices, {}, {}, {}, {} per vertex, bending length {} {}; solved in {}, {}",
        written.display(),
        human::count(rig.vertices()),
        human::counted(rig.handles().vertices.len(), "handle"),
        human::counted(rig.handles().strain_edges.len(), "strain edge"),
        human::counted(rig.examples().names.len(), "example"),
        human::counted(rig.influences().per_vertex(), "influence"),
        human::number(rig.bending_length()),
        human::unit(rig.surface().metres_per_unit),
        human::duration(solved.solving),
        human::bytes(solved.bytes)
    ))?;
    for line in report_lines(&solved.report, rig.surface().metres_per_unit) {
        output::say(&line)?;
    }
    output::say(&output::table(&scan_rows(&solved.scans, rig.surface().metres_per_unit)))?;
    if let Some(words) = &solved.sculpted {
        output::say(words)?;
    }
    let steps: Vec<String> =
        ui.finished().iter().map(|(step, time)| format!("{step} {}", human::duration(*time))).collect();
    let peak = memory::peak().map_or(String::new(), |bytes| format!("; peak memory {}", human::bytes(bytes)));
    output::say(&format!("{}{peak}", steps.join(", ")))
}

/// From a project file to a rig file.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading, from the doctor and from writing; [`Error::Cancelled`].
pub(super) fn solve(path: &Path, output: &Path, reach: Reach, ui: &Ui) -> Result<Solved> {
    inputs::project(path, "rhytid solve FACE.toml -o FACE.safetensors")?;
    check_output(output)?;
    let project = project::read_project(path)?;
    let files = project::files(&project, path);
    refuse_inputs(&[output], files.iter().map(PathBuf::as_path))?;
    let (face, reading) = ui.timed("read", || project::read(path, reach));
    let face = face?;
    let of_a_take = project.examples.iter().filter(|example| example.take.is_some());
    let names: Vec<&str> = of_a_take.map(|example| example.name.as_str()).collect();
    let without = (!names.is_empty()).then(|| {
        let mut without = face.clone();
        without.examples.retain(|example| !names.contains(&&*example.name));
        without
    });
    let mut solved = solve_face(face, output, ui)?;
    solved.reading = reading;
    let sculpted = project.examples.iter().find_map(|example| Some((example.take.clone()?, example.frame?)));
    if let (Some(without), Some((take, frame))) = (without, sculpted) {
        let take = rhytid::formats::named_file(path, &take, "[[example]] take", reach)?;
        solved.sculpted = Some(what_is_sculpted(&without, &names, &solved.rig, &take, frame, ui)?);
    }
    Ok(solved)
}

/// From a face to a rig file. [`check_output`] has already accepted its name.
///
/// # Errors
/// As [`solve`].
pub(super) fn solve_face(face: Face, output: &Path, ui: &Ui) -> Result<Solved> {
    let (found, examining) = ui.timed("examine", || rhytid::solve::examine(&face));
    show(&found, ui)?;
    let (solved, solving) = timed(|| rhytid::solve::solve_in_full(&face, false, ui));
    let rhytid::solve::Solved { rig, report, .. } = solved?;
    if ui.cancelled() {
        return Err(Error::Cancelled);
    }
    let (written, writing) = ui.timed("write the rig", || {
        let rounded = rig.rounded()?;
        drop(rig);
        rig_file::write(output, &rounded).map(|()| rounded)
    });
    let rig = written?;
    // A rig that is too large to be held twice is still fine without the comparison.
    let compared = ui.timed("compare with the scans", || {
        let processor = inputs::processor()?;
        example_residuals(&rig, &face, &report.misplaced, &[processor])
    });
    let scans = compared.0.unwrap_or_else(|error| {
        log::warn!("not compared with the scans: {}", remedy::of_error(&error));
        Vec::new()
    });
    drop(face);
    let bytes = std::fs::metadata(output).map_err(Error::io(output))?.len();
    Ok(Solved {
        rig,
        report,
        scans,
        sculpted: None,
        reading: Duration::ZERO,
        examining,
        solving,
        writing,
        bytes,
    })
}

/// What the sculpted examples of these names change in other frames of a take. The face `without` them is
/// solved for the comparison.
fn what_is_sculpted(
    without: &Face,
    names: &[&str],
    rig: &Rig,
    path: &Path,
    frame: usize,
    ui: &Ui,
) -> Result<String> {
    let before: Rig = rhytid::solve::solve(without, ui)?.rounded()?;
    let take = take::read(path, Some(&rig.handles().labels), Missing::Error)?;
    let step = take.frames().div_ceil(COMPARED).max(1);
    let mut frames: Vec<usize> = (0..take.frames()).step_by(step).chain([frame]).collect();
    frames.sort_unstable();
    frames.dedup();
    let mut changes = rig_diff([&before, rig], &take, &frames, &[inputs::processor()?])?;
    let millimetres = |x: f64| human::number((x * rig.surface().metres_per_unit * 1e5).round() / 1e2);
    let of_itself = changes.iter().find(|change| change.frame == frame).map_or(0.0, |change| change.worst);
    changes.retain(|change| change.frame != frame);
    changes.sort_by(|a, b| b.worst.total_cmp(&a.worst));
    let seen = changes.iter().filter(|change| change.worst * rig.surface().metres_per_unit > SEEN).count();
    let (most, median) = (changes.first().copied(), changes.get(changes.len() / 2).copied());
    let mut words = format!(
        "sculpted ({}): frame {frame} changes by up to {} mm",
        names.join(", "),
        millimetres(of_itself)
    );
    if let (Some(most), Some(median)) = (most, median) {
        words += &format!(
            "; of {} other frames of {} half by up to {} mm, {} by more than {} mm, the most frame {} by {} mm at vertex {}",
            human::count(changes.len()),
            path.display(),
            millimetres(median.worst),
            human::count(seen),
            SEEN * 1e3,
            most.frame,
            millimetres(most.worst),
            most.vertex
        );
    }
    Ok(words)
}

/// A line for each choice with its basis, and for the fate of parts without a handle.
fn report_lines(report: &SolveReport, metres_per_unit: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for found in &report.misplaced {
        let millimetres = found.moved * metres_per_unit * 1e3;
        lines.push(format!(
            "example {} was put into the neutral's place: turned back by {}°, moved by {} mm",
            found.example,
            human::number((found.degrees * 1e3).round() / 1e3),
            human::number((millimetres * 1e3).round() / 1e3)
        ));
    }
    if report.pins > 0 {
        lines.push(format!(
            "pinned, so that they stay where they are: {} vertices",
            human::count(report.pins)
        ));
    }
    if let Some((chosen, others)) = report.candidates.split_first() {
        let named = |candidate: &Candidate| {
            format!("share {}, ridge {}", human::number(candidate.share), human::number(candidate.ridge))
        };
        let error = |candidate: &Candidate| {
            let millimetres = candidate.leave_one_out * metres_per_unit * 1e3;
            format!("{} mm", human::number((millimetres * 1e3).round() / 1e3))
        };
        let mut line = format!("learned with {}", named(chosen));
        if chosen.leave_one_out.is_finite() {
            line += &format!(": an example that is left out comes back within {} (RMS)", error(chosen));
        }
        if !others.is_empty() {
            let others: Vec<String> =
                others.iter().map(|other| format!("{} within {}", named(other), error(other))).collect();
            line += &format!("; {}", others.join(", "));
        }
        lines.push(line);
    }
    for (what, rigid) in [("move as solids", true), ("follow the closest skin", false)] {
        let parts: Vec<&FreePart> = report.parts.iter().filter(|part| part.rigid == rigid).collect();
        let named = parts
            .iter()
            .take(PARTS_NAMED)
            .map(|part| format!("{} vertices from {} on", human::count(part.vertices), part.first_vertex));
        let named = named.collect::<Vec<_>>().join(", ");
        let more = match parts.len().saturating_sub(PARTS_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        if !parts.is_empty() {
            lines.push(format!("parts without a handle that {what}: {}: {named}{more}", parts.len()));
        }
    }
    lines
}

/// Rows with the errors at which the rig reproduces the rest pose and the examples.
fn scan_rows(scans: &[ExampleResiduals], metres_per_unit: f64) -> Vec<[String; 2]> {
    let millimetres = |x: f64| human::number((x * metres_per_unit * 1e6).round() / 1e3);
    let row = |scan: &ExampleResiduals| {
        let name = scan.example.clone().unwrap_or_else(|| "rest".to_owned());
        let (rms, worst) = (millimetres(scan.rms), millimetres(scan.worst));
        [name, format!("comes back within {rms} mm (RMS), {worst} mm at vertex {}", scan.vertex)]
    };
    scans.iter().map(row).collect()
}

/// Checks that the rig file can be written, before the long work.
pub(super) fn check_output(output: &Path) -> Result<()> {
    if output.extension().is_none_or(|ending| ending != "safetensors") {
        return Err(Error::unsupported_format(format!(
            "{}: expected a name that ends in .safetensors, the format of rig files",
            output.display()
        )));
    }
    AtomicFile::create(output).map(drop)
}

/// Prints the doctor's findings. Errors among them stop the command.
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
    Err(last.error())
}
