//! `rhytid handles`

use crate::args::UnitChoice;
use crate::drawing::with_pictures;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::capture::{HandleSettings, PlacedHandles, place_handles};
use rhytid::core::human;
use rhytid::core::{AtomicFile, Handles};
use rhytid::core::{SurfacePoint, VertexId};
use rhytid::formats::{FileKind, named_output, project, raw_take, refuse_inputs, tables};
use rhytid::report::write_handles;
use rhytid::solve::Skin;
use rhytid::{Error, Face, InputErrorKind, Result};
use serde::Serialize;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// A marker that was laid farther from its vertex than this, in millimetres, is red in the picture.
const DOUBTFUL_MM: f64 = 8.0;

/// Handles named in the summary, the farthest first.
const NAMED: usize = 5;

/// Places handles, writes their table and a picture, and says how far each had to be moved.
///
/// # Errors
/// As reading, placing and writing; [`Error::Input`] if the table is there already.
pub(super) fn run(args: &args::Handles, ui: &Ui) -> Result<()> {
    let usage = "rhytid handles FACE.toml TAKE";
    inputs::project(&args.project, usage)?;
    if let Some(take) = &args.take {
        inputs::expect(take, &[FileKind::RawTake, FileKind::Take], usage)?;
    }
    let project = project::read_project(&args.project)?;
    let table = table(args, &project)?;
    let picture = picture(args, &project, &table)?;
    // The project's own table is not read, and may be made anew.
    let own = args.project.parent().unwrap_or(Path::new("")).join(&project.handles.vertices);
    let files = project::files(&project, &args.project);
    let read = files.iter().filter(|file| **file != own).map(PathBuf::as_path);
    refuse_inputs(&[&table, &picture], read.chain(args.take.as_deref()))?;
    drop(AtomicFile::create(&table)?);
    drop(AtomicFile::create(&picture)?);
    let mut face = ui
        .timed("read", || project::load_without_handles(&project, &args.project, args.elsewhere.reach()))
        .0?;
    let millimetres = face.metres_per_unit * 1e3;
    let is_drawn;
    let mut placed = None;
    let lines = match &args.take {
        Some(take) => {
            let found = ui.timed("place", || from_take(args, take, &face)).0?;
            let distances: Vec<f64> = found.distances.iter().map(|d| d * millimetres).collect();
            face.handles = found.handles.clone();
            tables::write_handles(&table, &face.handles, Some(&distances))?;
            let doubtful: Vec<bool> = distances.iter().map(|distance| *distance > DOUBTFUL_MM).collect();
            is_drawn = draw(&picture, &face, &doubtful, &found.markers)?;
            ui.clear();
            found
                .warnings
                .iter()
                .for_each(|warning| ui.line(&format!("warning: {}: {warning}", take.display())));
            let lines = said(&found, &distances, ui);
            placed = Some((found, distances));
            lines
        }
        None => {
            face.handles = ui.timed("place", || spread(args, &face)).0?;
            tables::write_handles(&table, &face.handles, None)?;
            is_drawn = draw(&picture, &face, &[], &[])?;
            ui.clear();
            format!("{} spread over the face", human::counted(face.handles.labels.len(), "handle"))
        }
    };
    let summary = Summary {
        file: &table,
        picture: is_drawn.then_some(&picture),
        handles: face.handles.labels.len(),
        frame: placed.as_ref().map(|(found, _)| found.frame),
        distances_mm: placed.as_ref().map(|(_, distances)| distances),
        left_out: placed.as_ref().map(|(found, _)| &*found.rigid).unwrap_or_default(),
        not_seen: placed.as_ref().map(|(found, _)| &*found.unseen).unwrap_or_default(),
    };
    output::done(args.json, ui, &summary, || {
        let look = match is_drawn {
            true => format!("\n{}: look at it before you go on", picture.display()),
            false => String::new(),
        };
        let next = output::next(&[format!(
            "rhytid solve {}{}",
            output::word(&args.project),
            args.elsewhere.again()
        )]);
        format!("{}: {lines}{look}{next}", table.display())
    })
}

/// The JSON that is printed.
#[derive(Serialize)]
struct Summary<'a> {
    file: &'a Path,
    /// Null where no device can draw.
    picture: Option<&'a PathBuf>,
    handles: usize,
    /// The frame that was laid over the mesh; null without a take.
    frame: Option<usize>,
    /// The distance of each handle from its marker; null without a take.
    distances_mm: Option<&'a Vec<f64>>,
    left_out: &'a [String],
    not_seen: &'a [String],
}

/// Draws the face with its handles, if a device can draw. Returns whether it did.
///
/// # Errors
/// [`Error::Io`].
pub(super) fn draw(picture: &Path, face: &Face, doubtful: &[bool], markers: &[[f64; 3]]) -> Result<bool> {
    with_pictures(&format!("{} is", picture.display()), |painter| match painter {
        Some(painter) => write_handles(picture, face, doubtful, markers, painter),
        None => Ok(()),
    })
}

/// The table to write: the one that the project names, if it does not exist.
fn table(args: &args::Handles, project: &project::Project) -> Result<PathBuf> {
    if let Some(output) = &args.output {
        return Ok(output.clone());
    }
    let file = &project.handles.vertices;
    let table = named_output(&args.project, file, "[handles] vertices", "csv", args.elsewhere.reach())?;
    match table.exists() {
        false => Ok(table),
        true => Err(Error::input(format!(
            "{}: is there already; name another table with -o, or remove it first",
            table.display()
        ))
        .of_kind(InputErrorKind::WouldOverwrite { file: table })),
    }
}

/// The picture to draw: beside the table, if no other was given.
fn picture(args: &args::Handles, project: &project::Project, table: &Path) -> Result<PathBuf> {
    match (&args.picture, &args.output) {
        (Some(picture), _) => Ok(picture.clone()),
        (None, Some(_)) => Ok(table.with_extension("png")),
        // Its name comes from the project, as the table's does.
        (None, None) => {
            let file = project.handles.vertices.with_extension("png");
            named_output(&args.project, &file, "[handles] vertices", "png", args.elsewhere.reach())
        }
    }
}

fn from_take(args: &args::Handles, take: &Path, face: &Face) -> Result<PlacedHandles> {
    let raw = raw_take::read(take, args.rate)?;
    let settings = HandleSettings {
        frame: args.frame.0,
        metres_per_unit: args.unit.map(UnitChoice::metres),
        rigid: args.rigid.clone(),
        known: args.at.iter().map(|at| (at.label.clone(), VertexId(at.vertex).into())).collect(),
        head: None,
    };
    place_handles(face, &raw, &settings).map_err(|error| error.in_file(take.display()))
}

fn spread(args: &args::Handles, face: &Face) -> Result<Handles> {
    let vertices = face.neutral.positions.len();
    if let Some(at) = args.at.iter().find(|at| at.vertex as usize >= vertices) {
        return Err(Error::out_of_range(format!(
            "--at {}={}: the mesh has {vertices} vertices, expected 0 to {}",
            at.label,
            at.vertex,
            vertices.saturating_sub(1)
        )));
    }
    let skin = Skin::from_face(face)?;
    let kept: Vec<VertexId> = args.at.iter().map(|at| VertexId(at.vertex)).collect();
    let vertices = skin.spread(args.count.unwrap_or_default() as usize, &kept);
    let mut labels = skin.labels(&vertices);
    labels.iter_mut().zip(&args.at).for_each(|(label, at)| label.clone_from(&at.label));
    // A label that was given belongs to its vertex alone.
    let mut taken: HashSet<String> = args.at.iter().map(|at| at.label.clone()).collect();
    for label in labels.iter_mut().skip(args.at.len()) {
        while !taken.insert(label.clone()) {
            label.push('b');
        }
    }
    Ok(Handles { labels, points: vertices.into_iter().map(SurfacePoint::from).collect() })
}

/// What was found, for a person to check.
fn said(found: &PlacedHandles, distances: &[f64], ui: &Ui) -> String {
    let number = |x: f64| human::number((x * 10.0).round() / 10.0);
    let mut sorted: Vec<(f64, &str)> =
        distances.iter().copied().zip(found.handles.labels.iter().map(String::as_str)).collect();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let median = sorted.get(sorted.len() / 2).map_or(0.0, |(distance, _)| *distance);
    let farthest: Vec<String> =
        sorted.iter().take(NAMED).map(|(distance, label)| format!("{label} {}", number(*distance))).collect();
    let mut rows = vec![
        ["frame".to_owned(), found.frame.to_string()],
        [
            "from its marker".to_owned(),
            format!("{} mm (median); the farthest: {} mm", number(median), farthest.join(", ")),
        ],
    ];
    if !found.rigid.is_empty() {
        rows.push([
            "left out".to_owned(),
            format!("{}: off the skin, they keep their distances", output::names(&found.rigid, ui)),
        ]);
    }
    if !found.unseen.is_empty() {
        rows.push([
            "not seen".to_owned(),
            format!("{}: no handle for them", output::names(&found.unseen, ui)),
        ]);
    }
    format!("{}\n{}", human::counted(found.handles.labels.len(), "handle"), output::table(&rows))
}
