//! `rhytid prepare`

use crate::drawing::with_pictures;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::capture::{Cleaned, Found, Kind, Match, Report};
use rhytid::core::human;
use rhytid::core::{AtomicFile, rig_file};
use rhytid::formats::tables::{self, MarkerRow};
use rhytid::formats::{FileKind, refuse_inputs, take};
use rhytid::playback::read_raw_take;
use rhytid::report::Page;
use rhytid::{Error, Result};
use std::path::Path;

/// Cleans a raw take, writes it as CSV, and says what was found.
///
/// # Errors
/// As reading, cleaning and writing.
pub(super) fn run(args: &args::Prepare, ui: &Ui) -> Result<()> {
    let usage = "rhytid prepare RAW --rig RIG -o TAKE.csv";
    inputs::expect(&args.raw, &[FileKind::RawTake, FileKind::Take], usage)?;
    inputs::expect(&args.rig, &[FileKind::Rig], usage)?;
    if args.output.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("csv")) {
        return Err(Error::unsupported_format(format!(
            "{}: a clean take is written as CSV; name it .csv",
            args.output.display()
        )));
    }
    let outputs: Vec<&Path> = std::iter::once(&*args.output).chain(args.write_markers.as_deref()).collect();
    let setup = args.known.clone().or(inputs::setup(args.setup.as_deref(), args.elsewhere.reach())?);
    let tables = [&args.setup, &setup.markers].into_iter().filter_map(Option::as_deref);
    refuse_inputs(&outputs, [&*args.raw, &args.rig].into_iter().chain(tables))?;
    drop(AtomicFile::create(&args.output)?);
    if let Some(path) = &args.write_markers {
        drop(AtomicFile::create(path)?);
    }
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let mut clean_up = setup.clean_up()?;
    clean_up.settings.fps = args.fps;
    clean_up.world = args.world;
    let (Cleaned { take, report }, matches) = read_raw_take(&args.raw, &rig, &clean_up, ui)?;
    if let Some(path) = &args.write_markers {
        tables::write_markers(path, &markers(&report, &matches))?;
    }
    ui.timed("write the take", || take::write(&args.output, &take)).0?;
    if let Some(dir) = &args.report {
        let name = args.raw.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let title = output::title(&args.rig, &rig.surface().name);
        let page = Page { folder: dir, title: &title };
        let write = |painter: Option<&_>| rhytid::report::write(page, &name, &report, &take, &rig, painter);
        ui.timed("write the report", || with_pictures("the report's pictures are", write)).0?;
    }
    ui.clear();
    let summary = serde_json::json!({
        "file": args.output,
        "frames": take.frames(),
        "frames_per_second": take.rate(),
        "report": report,
    });
    output::done(args.json, ui, &summary, || {
        let [rig, take_file] = [&args.rig, &args.output].map(|path| output::word(path));
        let usd = output::word(&args.output.with_extension("usd"));
        format!(
            "{}: {} at {} frames per second\n{}{}",
            args.output.display(),
            human::counted(take.frames(), "frame"),
            human::number(take.rate()),
            output::table(&rows(&report, ui)),
            output::next(&[
                format!("rhytid view {rig} {take_file}"),
                format!("rhytid animate {rig} {take_file} -o {usd}"),
            ])
        )
    })
}

/// The marker of each handle, as the clean-up assigned it.
fn markers(report: &Report, matches: &[Match]) -> Vec<MarkerRow> {
    let row = |(i, handle): (usize, &String)| {
        let marker = report.setup.markers[i].clone();
        let by_position = matches.get(i).map(|found| found.sure);
        let sure = by_position.unwrap_or(if marker.is_some() { 1.0 } else { 0.0 });
        MarkerRow { handle: handle.clone(), marker, distance_mm: report.setup.offsets_mm[i], sure }
    };
    report.labels.iter().enumerate().map(row).collect()
}

/// The smallest and the largest size of the rig's regions, compared with the actor's and with the rest of the
/// face.
fn regions(scales: &[f64]) -> String {
    let least = scales.iter().copied().fold(1.0, f64::min);
    let most = scales.iter().copied().fold(1.0, f64::max);
    if most - least < 0.01 {
        return String::new();
    }
    format!("; motions are made {least:.2} to {most:.2} times as large, as the rig's regions are")
}

/// The neutral frames, and how sure they are.
fn neutral(found: &Found) -> String {
    let frames = format!("frames {}..{}", found.neutral.start, found.neutral.end);
    match &found.neutral_rival {
        _ if !found.neutral_is_found => frames,
        None => format!("{frames} (found)"),
        Some(rival) => format!(
            "{frames} (found, not sure: {}..{} may be it as well, {:.1} mm apart)",
            rival.frames.start, rival.frames.end, rival.apart_mm
        ),
    }
}

/// What was found, for a person to check.
fn rows(report: &Report, ui: &Ui) -> Vec<[String; 2]> {
    let row = |name: &str, value: String| [name.to_owned(), value];
    let found = &report.setup;
    let guessed = |is: bool| if is { " (found)" } else { "" };
    let count = |kind: Kind| report.events.iter().filter(|event| event.kind == kind).count();
    let with_marker = found.markers.iter().flatten().count();
    let mut rows = vec![row("handles", format!("{with_marker} of {} have a marker", report.labels.len()))];
    rows.extend(found.subject.iter().map(|subject| row("subject", subject.clone())));
    if !found.in_head_space {
        let rigid = if found.rigid.is_empty() {
            "the face's markers".into()
        } else {
            output::names(&found.rigid, ui)
        };
        let metres = human::unit(found.metres_per_unit);
        rows.extend([
            row("unit", format!("{metres}{}", guessed(found.unit_is_guessed))),
            row("axes", format!("{} are the mesh's x, y, z{}", found.axes, guessed(found.axes_are_guessed))),
            row("actor", format!("{:.3} times the rig's size{}", found.scale, regions(&found.scales))),
            row("head", format!("from {rigid}")),
        ]);
    }
    for pose in &found.poses {
        let likeness = format!("frame {}, likeness {:.2} of 1", pose.frame, pose.likeness);
        rows.push(row(&format!("pose {}", pose.example), likeness));
    }
    rows.push(row("neutral", neutral(found)));
    rows.extend(report.timecode.iter().map(|timecode| row("time code", timecode.clone())));
    let marks: Vec<String> =
        report.marks.iter().map(|mark| format!("{} at frame {}", mark.name, mark.frame)).collect();
    if !marks.is_empty() {
        rows.push(row("marks", output::names(&marks, ui)));
    }
    rows.push(row("noise", format!("{:.3} mm RMS", report.noise_mm)));
    rows.push(row(
        "filter",
        report.low_pass_hz.map_or("none".into(), |hz| format!("low-pass, {} Hz", human::number(hz))),
    ));
    for (kind, name, noun) in [
        (Kind::Swap, "swaps", "pair of labels"),
        (Kind::Shuffled, "shuffled", "stretch of a label that changes places"),
        (Kind::Outlier, "outliers", "dropped"),
        (Kind::Slide, "slides", "label off its marker, cut out"),
        (Kind::Dropped, "dropped", "stretch, by hand"),
        (Kind::Held, "held", "stretch, by hand"),
        (Kind::FilledBefore, "filled before", "gap"),
        (Kind::Spline, "short gaps", "filled by a spline"),
        (Kind::Model, "gaps", "filled by the take's own motion"),
        (Kind::Lost, "lost", "gap that could not be filled soundly"),
        (Kind::NeverSeen, "never seen", "marker, which goes with its neighbours"),
        (Kind::Left, "gaps", "left open"),
        (Kind::Strain, "strains", "stretch that no skin has"),
        (Kind::Step, "steps", "step that no skin makes"),
        (Kind::Head, "head not seen", "stretch"),
    ] {
        if count(kind) > 0 {
            rows.push(row(name, format!("{} × {noun}", human::count(count(kind)))));
        }
    }
    rows
}
