//! Saving. Each file gets the next free number beside the rig.

use crate::app::ViewApp;
use crate::commands::Command;
use rhytid_core::{AtomicFile, Error, Result};
use rhytid_formats::edits::{Curve, Ease, Edits, Offset};
use rhytid_formats::{edits, mesh, take};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The largest number of files of one kind beside a rig.
const MOST: usize = 10_000;

impl ViewApp {
    /// Saves the file of a command, and shows where it is.
    pub(crate) fn save(&mut self, command: Command) {
        if self.scene.is_some() {
            let saved = self.try_save(command).map(|path| format!("saved {}", path.display()));
            self.tell(saved);
        }
    }

    fn try_save(&mut self, command: Command) -> Result<PathBuf> {
        let gain = self.settings.gain;
        let scene = self.scene.as_mut().ok_or_else(|| Error::empty("no rig is open"))?;
        let rig = PathBuf::from(&scene.document.name);
        match command {
            Command::SaveFrame => {
                let path = free(&rig, "pose", "csv")?;
                take::write(&path, &scene.document.frame_as_take())?;
                Ok(path)
            }
            Command::SaveExample => {
                let path = free(&rig, "pose", "obj")?;
                let positions = scene.on_host(gain)?[0].to_vec();
                mesh::write_obj(&path, &scene.document.frame_as_mesh(&positions))?;
                Ok(path)
            }
            Command::SaveEdits => {
                let markers = scene.document.drags();
                if markers.is_empty() {
                    return Err(Error::empty("no marker was dragged, so there is no edit to save"));
                }
                let path = free(&rig, "edit", "toml")?;
                let (amount, ease) = (Curve::constant(1.0), Ease::default());
                let offset = Offset { region: None, millimetres: None, markers, amount, ease };
                edits::write(&path, &Edits { offsets: vec![offset], ..Edits::default() })?;
                Ok(path)
            }
            _ => {
                let path = free(&rig, "view", "png")?;
                let picture = scene.picture()?.ok_or_else(|| Error::empty("nothing was drawn yet"))?;
                let mut file = AtomicFile::create(&path)?;
                file.write_all(&picture.png()?).map_err(file.error())?;
                file.finish()?;
                Ok(path)
            }
        }
    }
}

/// The first free name, such as `FACE-pose-0001.csv` beside `FACE.safetensors`.
fn free(rig: &Path, what: &str, extension: &str) -> Result<PathBuf> {
    let stem = rig.file_stem().unwrap_or_default().to_string_lossy();
    let name = |i: usize| rig.with_file_name(format!("{stem}-{what}-{i:04}.{extension}"));
    let found = (1..MOST).map(name).find(|path| path.symlink_metadata().is_err());
    found.ok_or_else(|| {
        let first = name(1);
        Error::input(format!("{}: there are {MOST} files like it; move some away", first.display()))
    })
}
