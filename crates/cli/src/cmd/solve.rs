//! `rhytid solve`

use super::{doctor, pack};
use crate::args;
use crate::inputs;
use crate::memory;
use crate::output;
use crate::progress::{Ui, timed};
use crate::remedy;
use rhytid::core::AtomicFile;
use rhytid::core::human;
use rhytid::core::rig_file;
use rhytid::evaluate::Faded;
use rhytid::formats::project::{self, ExampleSection};
use rhytid::formats::take::{self, Missing};
use rhytid::formats::{Reach, refuse_inputs};
use rhytid::playback::{ExampleResiduals, example_residuals, rig_diff};
use rhytid::solve::{
    Candidate, FoundEyeball, FreeMotion, FreePart, Report, Severity, SolveReport, TakenPrior,
};
use rhytid::{Error, Face, Progress, Result, Rig};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Largest number of frames in which a rig is compared with its earlier version.
const COMPARED: usize = 200;

/// A smaller motion, in metres, cannot be seen.
const SEEN: f64 = 1e-4;

/// How many other choices of what is learned are named, the best first.
const CANDIDATES_NAMED: usize = 3;

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
    let written = args.output.clone().unwrap_or_else(|| args.project.with_extension("safetensors"));
    let small = args.pack.as_deref();
    let solved = solve(&args.project, &written, small, args.elsewhere.reach(), ui)?;
    let packed = small.map(|small| pack::write(&solved.rig, &[], args.max_error, small, ui)).transpose()?;
    let summary = Summary { packed, ..Summary::new(&solved, &written, ui) };
    output::done(args.json, ui, &summary, || {
        let next = output::next(&[
            format!("rhytid view {}", output::word(&written)),
            format!(
                "rhytid animate {} TAKE.csv -o {}",
                output::word(&written),
                output::word(&written.with_extension("usd"))
            ),
            format!("rhytid evaluate {}{}", output::word(&args.project), args.elsewhere.again()),
        ]);
        let packed =
            summary.packed.as_ref().map_or_else(String::new, |packed| format!("\n{}", packed.text()));
        text(&solved, &written, ui) + &packed + &next
    })
}

/// An eyeball on which lids slide.
#[derive(Serialize)]
struct EyeballSummary {
    first_vertex: u32,
    radius_mm: f64,
    lid_vertices: usize,
}

/// The JSON that is printed.
#[derive(Serialize)]
struct Summary<'a> {
    file: &'a Path,
    bytes: u64,
    vertices: usize,
    handles: usize,
    strain_edges: usize,
    examples: usize,
    influences: usize,
    bending_length_mm: f64,
    pins: usize,
    parts_without_handle: usize,
    /// The eyeballs on which lids slide.
    eyeballs: Vec<EyeballSummary>,
    /// The number of vertices that have others across an opening.
    rim_vertices: usize,
    /// How near the rig is to the rest pose and to each example.
    scans: Vec<ScanSummary<'a>>,
    /// The choice of share and ridge, the chosen pair first.
    candidates: Vec<CandidateSummary>,
    /// Null without a prior.
    prior: Option<PriorSummary>,
    /// Where the linear band is faded to the shell, the least kept first.
    faded: Vec<Faded>,
    seconds: f64,
    steps: Vec<StepSummary>,
    peak_memory_bytes: Option<u64>,
    /// The packed rig; null without `--pack`.
    packed: Option<pack::Summary<'a>>,
}

#[derive(Serialize)]
struct ScanSummary<'a> {
    /// Null for the rest pose.
    example: Option<&'a str>,
    rms_mm: f64,
    worst_mm: f64,
    vertex: usize,
    /// The standard deviation of a vertex's noise per axis; null for the rest pose.
    noise_mm: Option<f64>,
}

#[derive(Serialize)]
struct CandidateSummary {
    share: f64,
    ridge: f64,
    /// Null where there is no limit.
    reach: Option<f64>,
    /// Null with a single example.
    left_out_mm: Option<f64>,
    /// Null with a single example.
    misfit_mm: Option<f64>,
}

#[derive(Serialize)]
struct PriorSummary {
    expressions: usize,
    /// 0 to 1.
    weight: f64,
}

#[derive(Serialize)]
struct StepSummary {
    step: &'static str,
    seconds: f64,
}

impl<'a> Summary<'a> {
    fn new(solved: &'a Solved, written: &'a Path, ui: &Ui) -> Self {
        let rig = &solved.rig;
        let millimetres = 1e3 * rig.surface().metres_per_unit;
        let noise_of = |example: &str| {
            let p = rig.examples().names.iter().position(|name| name == example)?;
            Some(solved.report.noise.get(p)? * millimetres)
        };
        let scan = |scan: &'a ExampleResiduals| ScanSummary {
            example: scan.example.as_deref(),
            rms_mm: scan.rms * millimetres,
            worst_mm: scan.worst * millimetres,
            vertex: scan.vertex,
            noise_mm: scan.example.as_deref().and_then(noise_of),
        };
        let candidate = |candidate: &Candidate| CandidateSummary {
            share: candidate.share,
            ridge: candidate.ridge,
            reach: Some(candidate.reach).filter(|reach| reach.is_finite()),
            left_out_mm: Some(candidate.leave_one_out * millimetres).filter(|x| x.is_finite()),
            misfit_mm: Some(candidate.misfit * millimetres).filter(|x| x.is_finite()),
        };
        let eyeball = |eyeball: &FoundEyeball| EyeballSummary {
            first_vertex: eyeball.first_vertex.0,
            radius_mm: eyeball.radius * millimetres,
            lid_vertices: eyeball.lid_vertices,
        };
        let finished = ui.finished();
        let step =
            |(step, time): &(&'static str, Duration)| StepSummary { step, seconds: time.as_secs_f64() };
        Self {
            file: written,
            bytes: solved.bytes,
            vertices: rig.vertices(),
            handles: rig.handles().len(),
            strain_edges: rig.handles().strain_edges.len(),
            examples: rig.examples().names.len(),
            influences: rig.influences().per_vertex(),
            bending_length_mm: rig.bending_length() * millimetres,
            pins: solved.report.pins,
            parts_without_handle: solved.report.parts.len(),
            eyeballs: solved.report.eyeballs.iter().map(eyeball).collect(),
            rim_vertices: rim_vertices(rig),
            scans: solved.scans.iter().map(scan).collect(),
            candidates: solved.report.candidates.iter().map(candidate).collect(),
            prior: solved
                .report
                .prior
                .map(|TakenPrior { expressions, weight }| PriorSummary { expressions, weight }),
            faded: faded(solved),
            seconds: solved.solving.as_secs_f64(),
            steps: finished.iter().map(step).collect(),
            peak_memory_bytes: memory::peak(),
            packed: None,
        }
    }
}

/// What was done: what was written and how good it is. Settings, lists and times only with `--verbose`.
pub(super) fn text(solved: &Solved, written: &Path, ui: &Ui) -> String {
    let rig = &solved.rig;
    let metres_per_unit = rig.surface().metres_per_unit;
    let mut lines = vec![format!(
        "{}: {} vertices, {}, {}, {}; solved in {}",
        written.display(),
        human::count(rig.vertices()),
        human::counted(rig.handles().len(), "handle"),
        human::counted(rig.examples().names.len(), "example"),
        human::bytes(solved.bytes),
        human::duration(solved.solving),
    )];
    lines.extend(quality(solved));
    lines.extend(solved.sculpted.clone());
    if ui.is_verbose() {
        lines.push(format!(
            "{}, {} per vertex, bending length {} {}",
            human::counted(rig.handles().strain_edges.len(), "strain edge"),
            human::counted(rig.influences().per_vertex(), "influence"),
            human::number(rig.bending_length()),
            human::unit(metres_per_unit),
        ));
        lines.extend(report_lines(&solved.report, metres_per_unit));
        if rim_vertices(rig) > 0 {
            let rims = human::count(rim_vertices(rig));
            lines.push(format!("lips and lids do not cross: {rims} vertices have others across an opening"));
        }
        lines.push(output::table(&scan_rows(&solved.scans, metres_per_unit)));
        let steps = ui.finished();
        let steps: Vec<String> =
            steps.iter().map(|(step, time)| format!("{step} {}", human::duration(*time))).collect();
        let peak =
            memory::peak().map_or(String::new(), |bytes| format!("; peak memory {}", human::bytes(bytes)));
        lines.push(format!("{}{peak}", steps.join(", ")));
    }
    lines.join("\n")
}

/// How near the rig is to its scans, and about how near it would be to one that it has not seen.
fn quality(solved: &Solved) -> Vec<String> {
    let millimetres = 1e3 * solved.rig.surface().metres_per_unit;
    let mut lines = Vec::new();
    let examples = || solved.scans.iter().filter(|scan| scan.example.is_some());
    if let Some(worst) = examples().max_by(|a, b| a.worst.total_cmp(&b.worst)) {
        let squares = examples().map(|scan| scan.rms * scan.rms).sum::<f64>();
        lines.push(format!(
            "examples differ from their scans by {} mm RMS, {} mm at most ({}, vertex {})",
            short(millimetres * (squares / examples().count() as f64).sqrt()),
            short(millimetres * worst.worst),
            worst.example.as_deref().unwrap_or_default(),
            worst.vertex
        ));
    }
    let chosen = solved.report.candidates.first();
    if let Some(error) = chosen.map(|chosen| chosen.leave_one_out).filter(|error| error.is_finite()) {
        lines.push(format!(
            "without its scan an example would differ by about {} mm RMS over the skin, wrinkles apart",
            short(millimetres * error)
        ));
    }
    let noise = solved.report.noise.iter().zip(&solved.rig.examples().names);
    if let Some((most, noisiest)) = noise.max_by(|a, b| a.0.total_cmp(b.0)).filter(|(most, _)| **most > 0.0) {
        lines.push(format!(
            "the scans have noise, which is not learned: up to {} mm per axis ({noisiest})",
            short(millimetres * most)
        ));
    }
    if let Some(TakenPrior { expressions, weight }) = solved.report.prior {
        let expressions = human::counted(expressions, "expression");
        lines.push(match weight {
            0.0 => format!("the prior ({expressions}) is left out: without it examples are predicted better"),
            _ => format!(
                "the prior ({expressions}) has a weight of {}",
                human::number((weight * 100.0).round() / 100.0)
            ),
        });
    }
    lines.extend(super::evaluate::faded_line(&faded(solved)));
    lines
}

/// Where the linear band is faded to the shell.
fn faded(solved: &Solved) -> Vec<Faded> {
    let labels = &solved.rig.handles().labels;
    let faded = solved.report.faded().into_iter();
    faded.map(|(h, kept)| Faded { handle: labels[h.index()].clone(), kept }).collect()
}

/// A length in millimetres with two digits.
fn short(millimetres: f64) -> String {
    match millimetres {
        x if x < 1e-4 => "0".to_owned(),
        x => {
            let scale = 10_f64.powf(x.log10().floor() - 1.0);
            human::number((x / scale).round() * scale)
        }
    }
}

/// From a project file to a rig file. The packed rig is written later; its name is checked.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading, from the doctor and from writing; [`Error::Cancelled`].
pub(super) fn solve(
    path: &Path,
    output: &Path,
    packed: Option<&Path>,
    reach: Reach,
    ui: &Ui,
) -> Result<Solved> {
    inputs::project(path, "rhytid solve FACE.toml")?;
    let outputs: Vec<&Path> = [output].into_iter().chain(packed).collect();
    for output in &outputs {
        check_output(output)?;
    }
    let project = project::read_project(path)?;
    let files = project::files(&project, path);
    refuse_inputs(&outputs, files.iter().map(PathBuf::as_path))?;
    let (face, reading) = ui.timed("read", || inputs::face(path, reach, ui));
    let face = face?;
    let of_a_take = project.examples.iter().filter(|example| example.take.is_some());
    let names: Vec<String> = of_a_take.filter_map(ExampleSection::name_of_one).collect();
    let without = (!names.is_empty()).then(|| {
        let mut without = face.clone();
        without.examples.retain(|example| !names.contains(&example.name));
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
    names: &[String],
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
            let numbers = [candidate.share, candidate.ridge, candidate.reach].map(human::number);
            format!("share {}, ridge {}, reach {}", numbers[0], numbers[1], numbers[2])
        };
        let error = |candidate: &Candidate| {
            let [left_out, misfit] = [candidate.leave_one_out, candidate.misfit].map(|error| {
                let millimetres = error * metres_per_unit * 1e3;
                human::number((millimetres * 1e3).round() / 1e3)
            });
            format!("{left_out} mm left out, {misfit} mm with all")
        };
        let mut line = format!("learned with {}", named(chosen));
        if chosen.leave_one_out.is_finite() {
            line += &format!("; the smooth part of an example differs by {} RMS", error(chosen));
        }
        let mut others: Vec<&Candidate> = others.iter().collect();
        others.sort_by(|a, b| a.expected().total_cmp(&b.expected()));
        for other in others.into_iter().take(CANDIDATES_NAMED) {
            line += &format!("; {}: {}", named(other), error(other));
        }
        lines.push(line);
    }
    lines.extend(free_parts(&report.parts));
    if !report.eyeballs.is_empty() {
        let told = |eyeball: &FoundEyeball| {
            format!(
                "{} vertices on the eyeball from {} on, of {} mm",
                human::count(eyeball.lid_vertices),
                eyeball.first_vertex,
                human::number((eyeball.radius * metres_per_unit * 1e4).round() / 10.0)
            )
        };
        let told: Vec<String> = report.eyeballs.iter().map(told).collect();
        lines.push(format!("lids slide on eyeballs: {}", told.join(", ")));
    }
    lines
}

/// The number of vertices that have others across an opening.
fn rim_vertices(rig: &Rig) -> usize {
    rig.learned().map_or(0, |learned| learned.contact.openings.rims.len())
}

/// A line for each way in which parts without a handle move.
fn free_parts(parts: &[FreePart]) -> Vec<String> {
    let way = |part: &FreePart| match part.motion {
        FreeMotion::Still => "stay",
        FreeMotion::Solid => "move as solids",
        FreeMotion::Skin => "follow the closest skin",
        FreeMotion::Blend { .. } => "follow the closest skin in part",
    };
    let mut by_way: Vec<(&str, Vec<&FreePart>)> = Vec::new();
    for part in parts {
        match by_way.iter_mut().find(|(of_way, _)| *of_way == way(part)) {
            Some((_, parts)) => parts.push(part),
            None => by_way.push((way(part), vec![part])),
        }
    }
    let name = |part: &&FreePart| {
        let skin = match part.motion {
            FreeMotion::Blend { skin } => format!(" ({:.0} %)", 100.0 * skin),
            _ => String::new(),
        };
        format!("{} vertices from {} on{skin}", human::count(part.vertices), part.first_vertex)
    };
    let line = |(way, parts): (&str, Vec<&FreePart>)| {
        let named = parts.iter().take(PARTS_NAMED).map(name).collect::<Vec<_>>().join(", ");
        let more = match parts.len().saturating_sub(PARTS_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        format!("parts without a handle that {way}: {}: {named}{more}", parts.len())
    };
    by_way.into_iter().map(line).collect()
}

/// Rows with the errors at which the rig reproduces the rest pose and the examples.
fn scan_rows(scans: &[ExampleResiduals], metres_per_unit: f64) -> Vec<[String; 2]> {
    let millimetres = |x: f64| human::number((x * metres_per_unit * 1e6).round() / 1e3);
    let row = |scan: &ExampleResiduals| {
        let name = scan.example.clone().unwrap_or_else(|| "rest".to_owned());
        let (rms, worst) = (millimetres(scan.rms), millimetres(scan.worst));
        [name, format!("{rms} mm RMS, {worst} mm at most (vertex {})", scan.vertex)]
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
