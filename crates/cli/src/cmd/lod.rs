//! `rhytid lod`

use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::{human, rig_file};
use rhytid::formats::refuse_inputs;
use rhytid::playback::{self, LevelOfDetail};
use rhytid::{Error, Result, Rig};
use serde::Serialize;
use std::path::{Path, PathBuf};

const USAGE: &str = "rhytid lod RIG [TAKE] --levels N -o FOLDER";

/// Makes rigs on fewer vertices.
///
/// # Errors
/// As reading and writing. [`Error::Input`] for a rig that has no levels of detail.
pub(super) fn run(args: &args::Lod, ui: &Ui) -> Result<()> {
    let args::Lod { rig: path, take, levels, output: folder, reading, json } = args;
    inputs::rig_and_any_take(path, take.as_deref(), reading, USAGE)?;
    let named: Vec<Files> = (1..=*levels).map(|number| Files::new(path, folder, number)).collect();
    let outputs: Vec<&Path> = named.iter().flat_map(|files| [&*files.rig, &*files.points]).collect();
    let read = [path].into_iter().chain(take).chain(&reading.setup);
    refuse_inputs(&outputs, read.map(PathBuf::as_path))?;
    let rig = ui.timed("read the rig", || rig_file::read(path)).0?;
    let frames = match take {
        Some(take) => inputs::take(take, &rig, reading, ui)?.handle_positions(&rig.handles().labels)?,
        None => Vec::new(),
    };
    let devices = [inputs::processor()?];
    let made = playback::levels(&rig, frames.as_chunks().0, *levels as usize, &devices, ui)?;
    if made.is_empty() {
        return Err(Error::conflict(format!(
            "{}: no level of detail can be made: none has a tenth fewer triangles than the {} of the rig",
            path.display(),
            human::count(rig.surface().triangles.len())
        )));
    }
    if made.len() < *levels as usize {
        log::warn!(
            "{} of {levels} levels were made: the next one has hardly fewer triangles, since vertices of \
             handles, seams and borders stay",
            made.len()
        );
    }
    std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    let mut written = Vec::new();
    for (files, level) in named.iter().zip(&made) {
        let bytes = rig_file::encode(&level.level.rig)?;
        output::file(&files.rig, &bytes)?;
        output::file(&files.points, &rig_file::encode_points(&level.points)?)?;
        written.push(LevelSummary::new(files, level, bytes.len()));
    }
    ui.clear();
    let summary = Summary {
        vertices: rig.vertices(),
        triangles: rig.surface().triangles.len(),
        poses: made[0].poses,
        levels: written,
    };
    output::done(*json, ui, &summary, || summary.text(&rig, path))
}

/// The files of a level.
struct Files {
    rig: PathBuf,
    points: PathBuf,
}

impl Files {
    /// FACE.1.safetensors and FACE.1.points.safetensors in the folder, for the rig FACE.safetensors.
    fn new(rig: &Path, folder: &Path, number: u32) -> Self {
        let name = rig.file_stem().unwrap_or_default().to_string_lossy();
        Self {
            rig: folder.join(format!("{name}.{number}.safetensors")),
            points: folder.join(format!("{name}.{number}.points.safetensors")),
        }
    }
}

/// What was written; docs/cli.md documents every key.
#[derive(Serialize)]
struct Summary<'a> {
    vertices: usize,
    triangles: usize,
    poses: usize,
    levels: Vec<LevelSummary<'a>>,
}

/// A level.
#[derive(Serialize)]
struct LevelSummary<'a> {
    file: &'a Path,
    points: &'a Path,
    bytes: usize,
    vertices: usize,
    triangles: usize,
    worst_mm: f64,
    rms_mm: f64,
}

impl<'a> LevelSummary<'a> {
    fn new(files: &'a Files, made: &LevelOfDetail, bytes: usize) -> Self {
        let rig = &made.level.rig;
        let millimetres = 1e3 * rig.surface().metres_per_unit;
        Self {
            file: &files.rig,
            points: &files.points,
            bytes,
            vertices: rig.vertices(),
            triangles: rig.surface().triangles.len(),
            worst_mm: made.worst * millimetres,
            rms_mm: made.rms * millimetres,
        }
    }
}

impl Summary<'_> {
    /// A table of the levels.
    fn text(&self, rig: &Rig, path: &Path) -> String {
        let header = ["level", "vertices", "triangles", "size", "worst", "RMS"].map(str::to_owned);
        let whole = [
            path.display().to_string(),
            human::count(rig.vertices()),
            human::count(self.triangles),
            String::new(),
            String::new(),
            String::new(),
        ];
        let mut rows = vec![header, whole];
        rows.extend(self.levels.iter().map(|level| {
            [
                level.file.display().to_string(),
                human::count(level.vertices),
                human::count(level.triangles),
                human::bytes(level.bytes as u64),
                format!("{:.3} mm", level.worst_mm),
                format!("{:.4} mm", level.rms_mm),
            ]
        }));
        let next = self.levels.first().map_or(String::new(), |level| {
            output::next(&[format!("rhytid view {}", output::word(level.file))])
        });
        format!(
            "{}\nworst and RMS: how far vertices of the whole rig are from each level, in {}{next}",
            output::table(&rows),
            human::counted(self.poses, "pose")
        )
    }
}
