//! The system's dialog for opening files.

use crate::work::Task;
use eframe::egui;
use rhytid_core::{Error, Result};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Nobody closes a dialog sooner. A system without one answers at once.
const BRIEF: Duration = Duration::from_millis(300);

/// The files that the user chooses. None where the user closes the dialog.
pub(crate) type Choosing = Task<Result<Vec<PathBuf>>>;

/// Shows the dialog. The window goes on in the meantime.
pub(crate) fn begin(context: &egui::Context) -> Choosing {
    Task::new("the system's dialog is open".to_owned(), context, |_, give| {
        let began = Instant::now();
        let dialog = rfd::AsyncFileDialog::new()
            .set_title("Open a rig, a take, edits, numbers or a project")
            .add_filter("Faces and takes", &["safetensors", "csv", "c3d", "trc", "tsv", "toml", "ply"])
            .add_filter("All files", &["*"]);
        let chosen = pollster::block_on(dialog.pick_files());
        give(match chosen {
            Some(files) => Ok(files.iter().map(|file| file.path().to_owned()).collect()),
            None if began.elapsed() < BRIEF => Err(none_here()),
            None => Ok(Vec::new()),
        });
    })
}

fn none_here() -> Error {
    let missing = match cfg!(target_os = "linux") {
        true => " (neither a desktop portal nor zenity answers)",
        false => "",
    };
    Error::unsupported_format(format!(
        "this system shows no dialog for opening files{missing}; drop the files on the window"
    ))
}
