//! Ctrl-C. During a recording it ends the recording; in a window it closes the window. Otherwise the first
//! one asks the work to stop, and ends the program after a second. The second one ends it at once.

use crate::exit_code;
use crate::progress::Ui;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
#[cfg(feature = "view")]
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How long work may go on after it is asked to stop. Some work, such as a factorisation in a library, is
/// never asked.
const GRACE: Duration = Duration::from_secs(1);

/// Whether something is recorded.
static RECORDING: AtomicBool = AtomicBool::new(false);
/// Whether the user ended the recording.
static ENDED: AtomicBool = AtomicBool::new(false);

/// Whether the user asked to end the recording.
pub(crate) fn recording_ended() -> bool {
    ENDED.load(Ordering::Relaxed)
}

/// Records. Meanwhile the first Ctrl-C only ends the recording.
pub(crate) fn end_of_recording<T>(record: impl FnOnce() -> T) -> T {
    RECORDING.store(true, Ordering::Relaxed);
    let recorded = record();
    RECORDING.store(false, Ordering::Relaxed);
    recorded
}

/// The action of the next Ctrl-C instead of stopping.
#[cfg(feature = "view")]
static INSTEAD: Mutex<Option<Box<dyn FnOnce() + Send>>> = Mutex::new(None);

/// From now on the first Ctrl-C does only `this`, and later ones stop the program.
#[cfg(feature = "view")]
pub(crate) fn first_does(this: impl FnOnce() + Send + 'static) {
    *INSTEAD.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(this));
}

/// From now on Ctrl-C (and a request to terminate) first asks the work to stop.
pub(crate) fn install(ui: &Arc<Ui>) {
    let ui = Arc::clone(ui);
    let handler = move || {
        if RECORDING.load(Ordering::Relaxed) && !ENDED.swap(true, Ordering::Relaxed) {
            ui.line("the recording ends… (Ctrl-C again stops)");
            return;
        }
        #[cfg(feature = "view")]
        if let Some(this) = INSTEAD.lock().unwrap_or_else(PoisonError::into_inner).take() {
            return this();
        }
        if ui.ask_to_stop() {
            leave(&ui);
        }
        ui.line("stopping… (Ctrl-C again stops at once)");
        let ui = Arc::clone(&ui);
        let late = move || {
            thread::sleep(GRACE);
            leave(&ui);
        };
        let _ = thread::Builder::new().spawn(late);
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        log::info!("Ctrl-C will stop at once: {error}");
    }
}

/// Ends the program at once. Outputs appear whole or not at all, at any moment.
fn leave(ui: &Ui) {
    remove_unfinished_files();
    ui.clear();
    ui.line("error: stopped before the end");
    // What libraries run at the program's exit, above all in drivers' threads, might wait for the work that
    // goes on.
    #[cfg(unix)]
    signal_hook::low_level::exit(exit_code::USER.into());
    #[cfg(not(unix))]
    std::process::exit(exit_code::USER.into())
}

/// Removes the temporary files that this process has open, since leaving at once runs no destructors. Only
/// Linux lists those files: on other systems a hidden `.rhytid-*.partial` stays behind.
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
