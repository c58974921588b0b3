//! `rhytid handles`

use super::placing::{Avatar, at_markers, spread};
use crate::args::{UnitChoice, again as again_of};
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::{AtomicFile, UpAxis, human};
use rhytid::formats::mesh::{self, Selection};
use rhytid::formats::{FileKind, named_file, named_output, project, refuse_inputs};
use rhytid::{Error, InputErrorKind, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};

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
    let reach = args.elsewhere.reach();
    let face = ui.timed("read", || project::load_without_handles(&project, &args.project, reach)).0?;
    let avatar = avatar(args, &project, face.up_axis)?;
    let place = || match &args.take {
        Some(take) => at_markers(face, &avatar, take, args.unit.map(UnitChoice::metres), &args.placement, ui),
        None => spread(face, &avatar, args.count.unwrap_or_default() as usize, &args.placement),
    };
    let placed = ui.timed("place", place).0?;
    placed.write_table(&table)?;
    let is_drawn = placed.draw(&picture)?;
    ui.clear();
    let drawn = is_drawn.then_some(&picture);
    if let Some(take) = &placed.take {
        if let Some(fault) = take.fault(&again(args, &take.path, &table), drawn.map(PathBuf::as_path)) {
            ui.line(&format!("warning: {fault}"));
        }
        take.warn(ui);
    }
    let found = placed.take.as_ref().map(|take| &take.found);
    let count = human::counted(placed.face.handles.labels.len(), "handle");
    let lines = match &placed.take {
        Some(take) => format!("{count}\n{}", output::table(&take.rows(ui))),
        None => format!("{count} spread over the face"),
    };
    let summary = Summary {
        file: &table,
        picture: drawn,
        handles: placed.face.handles.labels.len(),
        frame: found.map(|found| found.frame),
        distances_mm: placed.take.as_ref().map(|take| &take.distances),
        left_out: found.map(|found| &*found.rigid).unwrap_or_default(),
        elsewhere: found.map(|found| &*found.elsewhere).unwrap_or_default(),
        no_label: found.map(|found| &*found.unlabelled).unwrap_or_default(),
        not_seen: found.map(|found| &*found.unseen).unwrap_or_default(),
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

/// What the project's neutral says of its head.
fn avatar(args: &args::Handles, project: &project::Project, up: UpAxis) -> Result<Avatar> {
    let reach = args.elsewhere.reach();
    let neutral = named_file(&args.project, &project.mesh.neutral, "[mesh] neutral", reach)?;
    let selection = Selection { prim: project.mesh.prim.clone(), time: None };
    let shapes = mesh::read_file(&neutral, &selection, false)?;
    Ok(Avatar::new(&neutral, &shapes, args.part.clone())?.with_up(up))
}

/// The command that places the same handles once more.
fn again(args: &args::Handles, take: &Path, table: &Path) -> String {
    let [project, take, table] = [args.project.as_path(), take, table].map(output::word);
    let unit = args.unit.map(UnitChoice::name);
    format!(
        "rhytid handles {project} {take} -o {table}{}{}{}{}",
        again_of("--part", args.part.as_ref()),
        again_of("--unit", unit),
        args.placement.again(),
        args.elsewhere.again()
    )
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
    elsewhere: &'a [String],
    no_label: &'a [String],
    not_seen: &'a [String],
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
