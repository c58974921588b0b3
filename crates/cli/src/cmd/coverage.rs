//! `rhytid coverage`

use crate::drawing::with_pictures;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::capture::coverage as by_strain;
use rhytid::capture::coverage::{Difference, Edge, Expression};
use rhytid::core::{Mesh, human, rig_file};
use rhytid::evaluate::Regions;
use rhytid::evaluate::coverage::{self, Coverage, Scan, TakeSigma};
use rhytid::formats::sequence::Sequence;
use rhytid::formats::{export::OutputStage, mesh, tables};
use rhytid::playback::Playback;
use rhytid::report::Page;
use rhytid::{Error, NoProgress, Result, Rig, Take};
use std::path::Path;

/// The number of regions named for a scan.
const NAMED: usize = 3;

/// Prints the parts of the take that no example shows, and the scans to make.
///
/// # Errors
/// As reading the rig and the take, and as [`coverage::coverage`].
pub(super) fn run(args: &args::Coverage, ui: &Ui) -> Result<()> {
    inputs::rig_and_take(&args.rig, &args.take, "rhytid coverage RIG TAKE")?;
    let rig = ui.timed("read the rig", || rig_file::read(&args.rig)).0?;
    let take = inputs::take(&args.take, &rig, &args.reading, ui)?;
    let take_name = args.take.display().to_string();
    let top = args.top as usize;
    let plans = args.plan.is_some()
        || args.candidates.is_some()
        || args.report.is_some()
        || args.take_examples.is_some();
    if rig.learned().is_none() && !plans {
        let found = ui.timed("compare", || by_strain::coverage(&rig.widened(), &take, top)).0?;
        ui.clear();
        return match args.json.wanted {
            true => output::json(&found),
            false => output::say(&strain_text(&found, &take_name)),
        };
    }
    let candidates =
        args.candidates.as_ref().map(|path| tables::read_frames(path, take.frames())).transpose()?;
    let regions = Regions::by_handles(&rig);
    let scans = args.plan.map_or(top, |scans| scans as usize);
    let found = coverage::coverage(&rig, &take, &regions, candidates.as_deref(), scans, top, ui)?;
    if let Some(dir) = &args.report {
        let poses = poses(&rig, &take, &found, ui)?;
        let title = output::title(&args.rig, &rig.surface().name);
        let page = Page { folder: dir, title: &title };
        let file_name = args.take.file_name().unwrap_or_default().to_string_lossy();
        with_pictures("the plan's pictures are", |painter| {
            rhytid::report::write_plan(page, &file_name, &found, &regions, &poses, &rig, painter)
        })?;
    }
    let lines = match (&args.take_examples, &args.output) {
        (Some(dense), Some(dir)) => cut_out(&rig, args, dense, dir, candidates.as_deref(), &take, &found)?,
        _ => String::new(),
    };
    ui.clear();
    match args.json.wanted {
        true => output::json(&found),
        false => output::say(&(text(&found, &take_name) + &lines)),
    }
}

/// The face in each planned frame, as the rig has it now.
fn poses(rig: &Rig, take: &Take, found: &Coverage, ui: &Ui) -> Result<Vec<Vec<[f32; 3]>>> {
    let positions = take.handle_positions(&rig.handles().labels)?;
    let frames: Vec<&[f32]> = positions.chunks_exact(3 * rig.handles().len()).collect();
    let handles: Vec<f32> = found.scans.iter().flat_map(|scan| frames[scan.frame]).copied().collect();
    let devices = inputs::devices(Some(inputs::processor()?), ui)?;
    let mut playback = Playback::new(rig, &devices, found.scans.len())?;
    let mut poses = Vec::new();
    playback.evaluate(&handles, OutputStage::Full, false, &NoProgress, |pose, _| {
        poses.push(pose.as_chunks().0.to_vec());
        Ok(())
    })?;
    Ok(poses)
}

/// Writes the planned frames out of dense meshes, and says what to add to the project file.
fn cut_out(
    rig: &Rig,
    args: &args::Coverage,
    dense: &Path,
    dir: &Path,
    candidates: Option<&[usize]>,
    take: &Take,
    found: &Coverage,
) -> Result<String> {
    let rest = rig.surface().rest.iter().map(|x| x.map(f64::from)).collect();
    let neutral = Mesh {
        positions: rest,
        faces: rig.surface().faces.clone(),
        uvs: rig.surface().uvs.clone(),
        materials: rig.surface().materials.clone(),
    };
    let mut meshes = Sequence::open(dense, &neutral, &args.rig, rig.surface().metres_per_unit)?;
    let expected = candidates.map_or(take.frames(), <[usize]>::len);
    if meshes.frames() != expected {
        return Err(Error::mismatch(format!(
            "{}: has {} frames, expected one for each of the {expected} {}; say with --candidates which frames of the take they are",
            dense.display(),
            meshes.frames(),
            if candidates.is_some() { "candidates" } else { "frames of the take" },
        )));
    }
    std::fs::create_dir_all(dir).map_err(Error::io(dir))?;
    let mut lines = "\n\nTo be added to the project file:".to_owned();
    let mut positions = Vec::new();
    for scan in &found.scans {
        let place = match candidates {
            Some(candidates) => candidates.iter().position(|frame| *frame == scan.frame),
            None => Some(scan.frame),
        };
        let place = place.ok_or_else(|| Error::Internal("a planned frame is no candidate".into()))?;
        meshes.positions(place, &mut positions)?;
        let positions = positions.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect();
        let name = format!("frame_{}", scan.frame);
        let path = dir.join(format!("{name}.obj"));
        mesh::write_obj(&path, &Mesh { positions, ..neutral.clone() })?;
        lines += &format!("\n[[example]]\nname = \"{name}\"\nmesh = {:?}", path.display().to_string());
    }
    Ok(lines)
}

fn text(found: &Coverage, take: &str) -> String {
    let mut text = match &found.sigma {
        None => format!("{take}: {}, and no example yet", human::counted(found.frames, "frame")),
        Some(sigma) => sigma_text(sigma, take, found.frames),
    };
    if found.scans.is_empty() {
        text += &format!("\n\n{}", found.verdict());
    } else {
        let header = ["", "frame", "time", "takes away", "left then", "mostly in", "what is strained most"];
        let rows = found.scans.iter().enumerate().map(|(i, s)| scan(i, s));
        let rows: Vec<[String; 7]> = std::iter::once(header.map(str::to_owned)).chain(rows).collect();
        text += &format!(
            "\n\nTo be scanned next, the most useful first. All parts are of the uncertainty without any example; \
             {} is left now:\n{}\n{}",
            coverage::share(found.left),
            output::table(&rows),
            found.verdict()
        );
    }
    text += &edges_text(&found.edges, found.edges_beyond, found.frames);
    text
}

fn sigma_text(sigma: &TakeSigma, take: &str, frames: usize) -> String {
    let rms = (sigma.frames_mm.iter().map(|x| x * x).sum::<f64>() / frames.max(1) as f64).sqrt();
    let mut text = format!(
        "{take}: σ is {rms:.3} mm RMS, the σ of an expression without a scan {:.3} mm; {} of {} {} covered",
        sigma.left_out_mm,
        share(sigma.covered, frames),
        human::counted(frames, "frame"),
        if frames == 1 { "is" } else { "are" }
    );
    for far in sigma.far.iter().take(NAMED) {
        text += &format!(
            "\nfar from the examples: {} from frame {} on, most at {} in the region {}: {:.1} times as {}",
            human::counted(far.frames, "frame"),
            far.first,
            seconds(far.time),
            far.region,
            far.times,
            far.of
        );
    }
    if sigma.far.len() > NAMED {
        text += &format!("\nand {} more stretches", sigma.far.len() - NAMED);
    }
    text
}

fn scan(i: usize, s: &Scan) -> [String; 7] {
    let regions = s.regions.iter().take(NAMED);
    let regions: Vec<String> =
        regions.map(|r| format!("{} {}", r.region, coverage::share(r.taken))).collect();
    [
        (i + 1).to_string(),
        s.frame.to_string(),
        seconds(s.time),
        coverage::share(s.taken),
        coverage::share(s.left),
        regions.join(", "),
        s.edges.iter().map(difference).collect::<Vec<_>>().join(", "),
    ]
}

fn share(frames: usize, of: usize) -> String {
    format!("{:.1} %", frames as f64 / of.max(1) as f64 * 100.0)
}

fn strain_text(found: &by_strain::Coverage, take: &str) -> String {
    let share = |frames: usize| share(frames, found.frames);
    let mut text = format!(
        "{take}: {} of {} {} covered by the examples",
        share(found.covered),
        human::counted(found.frames, "frame"),
        if found.frames == 1 { "is" } else { "are" }
    );
    if let Some(spacing) = found.spacing {
        text += &format!(", which are typically {} RMS strain apart", percent(spacing));
    }
    if found.expressions.is_empty() {
        text += "\n\nNo expression is worth a scan of its own.";
    } else {
        let header = ["", "frame", "time", "distance", "from", "covered then", "what differs most"];
        let rows = found.expressions.iter().enumerate().map(|(i, e)| expression(i, e, &share));
        let rows: Vec<[String; 7]> = std::iter::once(header.map(str::to_owned)).chain(rows).collect();
        text += &format!(
            "\n\nTo be scanned next, the farthest from all examples first:\n{}",
            output::table(&rows)
        );
    }
    text + &edges_text(&found.edges, found.edges_beyond, found.frames)
}

/// The strain edges that go beyond the examples, of which there are `count` in all.
fn edges_text(edges: &[Edge], count: usize, frames: usize) -> String {
    if edges.is_empty() {
        return "\n\nNo strain edge goes beyond the examples.".into();
    }
    let header = ["edge", "beyond", "in the examples", "at frame", "time", "frames beyond"];
    let rows = edges.iter().map(|e| edge(e, &|beyond| share(beyond, frames)));
    let rows: Vec<[String; 6]> = std::iter::once(header.map(str::to_owned)).chain(rows).collect();
    format!(
        "\n\n{} {} beyond every example, the farthest first:\n{}",
        human::counted(count, "strain edge"),
        if count == 1 { "goes" } else { "go" },
        output::table(&rows)
    )
}

fn expression(i: usize, e: &Expression, share: &dyn Fn(usize) -> String) -> [String; 7] {
    [
        (i + 1).to_string(),
        e.frame.to_string(),
        seconds(e.time),
        e.relative.map_or_else(|| percent(e.distance), |relative| format!("{relative:.2}")),
        e.nearest.clone(),
        share(e.covered),
        e.edges.iter().map(difference).collect::<Vec<_>>().join(", "),
    ]
}

fn difference(d: &Difference) -> String {
    format!("{} {}", names(&d.handles), change(d.difference, d.difference_mm))
}

fn edge(e: &Edge, share: &dyn Fn(usize) -> String) -> [String; 6] {
    // Both ends of the range in the unit of what is beyond.
    let millimetres = if e.beyond == 0.0 { 0.0 } else { e.beyond_mm / e.beyond };
    let [low, high] = e.examples.map(|strain| {
        let text = format!("{:+.1}", strain * millimetres).replace('-', "−");
        if matches!(&*text, "+0.0" | "−0.0") { "0".to_owned() } else { text }
    });
    [
        names(&e.handles),
        change(e.beyond, e.beyond_mm),
        if low == high { format!("{low} mm") } else { format!("{low} to {high} mm") },
        e.frame.to_string(),
        seconds(e.time),
        share(e.frames_beyond),
    ]
}

fn names([a, b]: &[String; 2]) -> String {
    format!("{a}–{b}")
}

fn change(strain: f64, millimetres: f64) -> String {
    format!("{:.1} mm {}", millimetres.abs(), if strain > 0.0 { "longer" } else { "shorter" })
}

fn percent(strain: f64) -> String {
    human::percent(strain, 1)
}

fn seconds(time: f64) -> String {
    format!("{time:.2} s")
}
