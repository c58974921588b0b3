//! The end of the program: its exit code, and errors as one sentence on stderr.

use crate::progress::Ui;
use crate::{exit_code, limits, output, remedy};
use rhytid::{Error, Result};
use std::io::{self, ErrorKind, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether a panic said that the system allows no thread.
static NO_THREAD: AtomicBool = AtomicBool::new(false);

/// A panic becomes one sentence instead of a dump; `RUST_BACKTRACE=1` adds the backtrace for a report.
pub(crate) fn install_panic_hook() {
    std::panic::set_hook(Box::new(|panic| {
        let what = panic.payload_as_str().unwrap_or("unknown reason").lines().next().unwrap_or_default();
        if let Some(sentence) = limits::of_panic(what) {
            // Several threads may meet it.
            if !NO_THREAD.swap(true, Ordering::Relaxed) {
                let _ = writeln!(io::stderr(), "error: {}", output::harmless(&sentence));
            }
            return;
        }
        let place = panic.location().map(|place| format!(" at {}:{}", place.file(), place.line()));
        let place = place.unwrap_or_default();
        let backtrace = std::backtrace::Backtrace::capture();
        let mut stderr = io::stderr().lock();
        let sentence = format!("error: internal error: {what}{place}; please report it");
        let _ = writeln!(stderr, "{}", output::harmless(&sentence));
        if backtrace.status() == std::backtrace::BacktraceStatus::Captured {
            let _ = writeln!(stderr, "{backtrace}");
        }
    }));
}

/// Runs the program, prints its error, if any, and returns the exit code. A panic unwinds to here, so that
/// temporary files are removed on the way.
pub(crate) fn status(ui: &Ui, run: impl FnOnce() -> Result<u8>) -> u8 {
    let result = catch_unwind(AssertUnwindSafe(run));
    ui.clear();
    match result {
        Ok(Ok(code)) => code,
        Ok(Err(error)) => {
            ui.line(&format!("error: {}", sentence(&error)));
            exit_code::from_error(&error)
        }
        Err(_) if NO_THREAD.load(Ordering::Relaxed) => exit_code::USER,
        Err(_) => exit_code::OURS,
    }
}

/// An error as the program says it: a sentence with what to do.
pub fn sentence(error: &Error) -> String {
    match error {
        Error::Io { path, source } => io_sentence(error, path, source),
        other => remedy::of_error(other),
    }
}

fn io_sentence(error: &Error, path: &Path, source: &io::Error) -> String {
    let what = match source.kind() {
        ErrorKind::NotFound => "no such file or folder; check the path".to_owned(),
        ErrorKind::PermissionDenied => {
            "permission denied; check the rights of the file and its folder".to_owned()
        }
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only; choose another folder".to_owned(),
        ErrorKind::IsADirectory => "is a folder, expected a file; check the path".to_owned(),
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder; check the path".to_owned(),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "no space left on the disk; this file was not written".to_owned()
        }
        ErrorKind::FileTooLarge => {
            "no space left: the file would be larger than this system allows; this file was not written"
                .to_owned()
        }
        ErrorKind::UnexpectedEof => {
            "became shorter while it was read; wait until it is written, and try again".to_owned()
        }
        _ => return error.to_string(),
    };
    format!("{}: {what}", path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_our_fault() {
        let ui = Ui::new(true, false);
        let panics = || -> Result<u8> { panic!("on purpose") };
        assert_eq!(status(&ui, panics), 1);
        assert_eq!(status(&ui, || Ok(exit_code::DONE)), 0);
        assert_eq!(status(&ui, || Err(Error::Cancelled)), 2);
    }

    #[test]
    fn a_full_disk_is_said_in_words() {
        let full = io::Error::from(ErrorKind::StorageFull);
        let sentence = sentence(&Error::io(Path::new("out/face.usda"))(full));
        assert_eq!(sentence, "out/face.usda: no space left on the disk; this file was not written");
    }
}
