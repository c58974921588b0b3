//! Ctrl-C: the first asks the work to stop, the second stops at once.

use crate::progress::Ui;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Whether the user asked to stop.
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// From now on Ctrl-C (and a request to terminate) only asks the work to stop.
pub(crate) fn install(ui: &Arc<Ui>) {
    let ui = Arc::clone(ui);
    let handler = move || {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            remove_unfinished_files();
            std::process::exit(2);
        }
        ui.line("stopping… (Ctrl-C again stops at once)");
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        log::info!("Ctrl-C will stop at once: {error}");
    }
}

/// Removes the temporary files that this process has open, since leaving at once runs no destructors. Other
/// systems than Linux do not tell which files those are: there a hidden `.rhytid-*.partial` stays behind.
fn remove_unfinished_files() {
    #[cfg(target_os = "linux")]
    for entry in std::fs::read_dir("/proc/self/fd").into_iter().flatten().flatten() {
        let Ok(file) = std::fs::read_link(entry.path()) else { continue };
        let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.starts_with(".rhytid-") && name.ends_with(".partial") {
            let _ = std::fs::remove_file(&file);
        }
    }
}
