//! Saving. Each file gets the next free number beside the rig.

use crate::app::ViewApp;
use crate::commands::Command;
use crate::document::Document;
use crate::order::Order;
use crate::painter::Job;
use rhytid_core::{AtomicFile, Error, Mesh, Result};
use rhytid_formats::edits::Edits;
use rhytid_formats::{edits, mesh, take};
use rhytid_render::{LEGEND, Picture, letter_scale};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The largest number of files of one kind beside a rig.
const MOST: usize = 10_000;

impl ViewApp {
    /// Saves the file of a command, and shows where it is.
    pub(crate) fn save(&mut self, command: Command) {
        match self.try_save(command) {
            // The painter says so when it has written the file.
            Ok(None) => {}
            Ok(Some(path)) => self.saved(&path),
            Err(error) => self.tell(Err(error)),
        }
    }

    /// Shows where a file is.
    pub(crate) fn saved(&mut self, path: &Path) {
        self.tell(Ok(format!("saved {}", path.display())));
    }

    /// The file, if it is there already.
    fn try_save(&mut self, command: Command) -> Result<Option<PathBuf>> {
        let Some(scene) = &mut self.scene else { return Ok(None) };
        let rig = PathBuf::from(&scene.document.name);
        match command {
            Command::SaveFrame if scene.document.is_mesh() => {
                Err(Error::empty("a mesh has no markers, so there is no take to save"))
            }
            Command::SaveFrame => {
                let path = free(&rig, "pose", "csv")?;
                take::write(&path, &scene.document.frame_as_take())?;
                Ok(Some(path))
            }
            Command::SaveExample => scene.save(|order| Job::SaveMesh(order, rig)).map(|()| None),
            Command::SaveEdits => {
                let document = &mut scene.document;
                if document.pose().pulls.is_empty() {
                    return Err(Error::empty("no marker was pulled, so there is no edit to save"));
                }
                let Some((text, beside)) = edits_of(document)? else { return Ok(None) };
                let path = free(&beside, "edit", "toml")?;
                edits::parse(&text, &path.display().to_string())?;
                let mut file = AtomicFile::create(&path)?;
                file.write_all(text.as_bytes()).map_err(file.error())?;
                file.finish()?;
                document.pulls_are_saved();
                Ok(Some(path))
            }
            _ => scene.save(|order| Job::SavePicture(order, rig)).map(|()| None),
        }
    }
}

/// Writes the legend of the map that is shown, if any, into the lower left corner.
pub(crate) fn write_legend(picture: &mut Picture, order: &Order) {
    let name = order.numbers.get(order.settings.numbers).map_or("", |(name, _)| name);
    let Some(map) = order.settings.map(name) else { return };
    // The picture's legend has the numbers themselves, without the factor of the unit.
    let title = if map.factor == 1.0 { map.title_with_unit() } else { map.title.to_owned() };
    let scale = letter_scale(picture.size);
    let at = [16, picture.size[1].saturating_sub(scale * LEGEND[1] + 16)];
    let is_dark = order.background[..3].iter().map(|x| u32::from(*x)).sum::<u32>() < 3 * 128;
    picture.legend(map.heat, &title, at, if is_dark { [255; 3] } else { [0; 3] }, scale);
}

/// The text of the edits that are shown and of all pulls, and a file beside which it belongs: the paths in it
/// are relative to that file. `None` where there are neither.
pub(crate) fn edits_of(document: &Document) -> Result<Option<(String, PathBuf)>> {
    let offsets = document.pull_edits();
    let pulls = match offsets.is_empty() {
        true => String::new(),
        false => edits::text(&Edits { offsets, ..Edits::default() })?,
    };
    Ok(match document.shown_layers() {
        Some(layers) => Some((join(layers.text(), &pulls), layers.path().to_owned())),
        None => (!pulls.is_empty()).then(|| (pulls, PathBuf::from(&document.name))),
    })
}

/// One file of edits after another.
fn join(first: &str, second: &str) -> String {
    match second {
        "" => first.to_owned(),
        second => format!("{}\n\n{second}", first.trim_end()),
    }
}

/// Writes a frame beside the rig's file.
pub(crate) fn mesh(rig: &Path, mesh: &Mesh) -> Result<PathBuf> {
    let path = free(rig, "pose", "obj")?;
    mesh::write_obj(&path, mesh)?;
    Ok(path)
}

/// Writes a picture beside the rig's file.
pub(crate) fn picture(rig: &Path, picture: &Picture) -> Result<PathBuf> {
    let path = free(rig, "view", "png")?;
    let mut file = AtomicFile::create(&path)?;
    file.write_all(&picture.png()?).map_err(file.error())?;
    file.finish()?;
    Ok(path)
}

/// The first free name, such as `FACE-pose-0001.csv` beside `FACE.safetensors`, which is the `rig`.
pub(crate) fn free(rig: &Path, what: &str, extension: &str) -> Result<PathBuf> {
    let stem = rig.file_stem().unwrap_or_default().to_string_lossy();
    let name = |i: usize| rig.with_file_name(format!("{stem}-{what}-{i:04}.{extension}"));
    let found = (1..MOST).map(name).find(|path| path.symlink_metadata().is_err());
    found.ok_or_else(|| {
        let first = name(1);
        Error::input(format!("{}: there are {MOST} files like it; move some away", first.display()))
    })
}
