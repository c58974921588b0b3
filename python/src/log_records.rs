//! The library's log as records of `logging.getLogger("rhytid")`.

use log::{Level, LevelFilter, Log, Metadata, Record};
use pyo3::prelude::*;
use std::sync::{Mutex, Once, PoisonError};

/// Records that Python was not told of yet.
static RECORDS: Mutex<Vec<(Level, String)>> = Mutex::new(Vec::new());

/// Keeps records until a thread that has Python's lock delivers them.
struct Kept;

impl Log for Kept {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        // While wgpu looks for devices, it reports every missing API. Our own backend reports what matters.
        metadata.level() <= Level::Info && metadata.target().trim_start_matches('_').starts_with("rhytid")
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let text = record.args().to_string();
            RECORDS.lock().unwrap_or_else(PoisonError::into_inner).push((record.level(), text));
        }
    }

    fn flush(&self) {}
}

/// Keeps the library's records from now on. The program `rhytid`, which has a log of its own, never calls it.
pub(crate) fn install() {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        if log::set_logger(&Kept).is_ok() {
            log::set_max_level(LevelFilter::Info);
        }
    });
}

/// Tells Python of all records.
///
/// # Errors
/// What a handler raises.
pub(crate) fn deliver(py: Python<'_>) -> PyResult<()> {
    let records = std::mem::take(&mut *RECORDS.lock().unwrap_or_else(PoisonError::into_inner));
    if records.is_empty() {
        return Ok(());
    }
    let logger = py.import("logging")?.call_method1("getLogger", ("rhytid",))?;
    for (level, text) in records {
        let method = match level {
            Level::Error => "error",
            Level::Warn => "warning",
            Level::Info => "info",
            Level::Debug | Level::Trace => "debug",
        };
        // The text is no format.
        logger.call_method1(method, ("%s", text))?;
    }
    Ok(())
}
