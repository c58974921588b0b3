//! Long work: on a thread of its own, without Python's lock. Ctrl-C and a callback that fails stop it.

use crate::command::keyword;
use crate::error::exception;
use crate::log_records;
use pyo3::prelude::*;
use rhytid::core::Warning;
use rhytid::{Error, Progress, Result};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often Python is asked for Ctrl-C, and told of progress.
const PATIENCE: Duration = Duration::from_millis(20);

/// How long work may go on after it is asked to stop. Some work, such as a factorisation, is never asked. It
/// then ends by itself, and its result is dropped.
const GRACE: Duration = Duration::from_millis(800);

/// The stack of the work's thread, as that of a main thread.
const STACK: usize = 8 << 20;

/// What the working thread tells, and whether it has to stop.
#[derive(Default)]
pub(crate) struct Monitor {
    stops: AtomicBool,
    latest: Mutex<Option<Report>>,
}

#[derive(Clone, Copy, PartialEq)]
struct Report {
    step: &'static str,
    done: u64,
    total: u64,
}

impl Progress for Monitor {
    fn report(&self, step: &'static str, done: u64, total: u64) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(Report { step, done, total });
    }

    fn cancelled(&self) -> bool {
        self.stops.load(Ordering::Relaxed)
    }

    fn warn(&self, warning: &Warning) {
        log::warn!("{}", keyword(&rhytid_cli::of_warning(warning)));
    }
}

impl Monitor {
    /// Asks the work to stop.
    pub(crate) fn stop(&self) {
        self.stops.store(true, Ordering::Relaxed);
    }
}

/// Does `job` on a thread of its own and waits for it. `progress` is called with the step's name and the done
/// and total units, at most fifty times a second.
///
/// # Errors
/// The job's, as exceptions. `KeyboardInterrupt` after Ctrl-C, within a second. What `progress` raises.
pub(crate) fn work<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce(Arc<Monitor>) -> Result<T> + Send + 'static,
) -> PyResult<T> {
    log_records::install();
    let monitor = Arc::new(Monitor::default());
    let (sender, mut receiver) = channel();
    let of_thread = Arc::clone(&monitor);
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(move || {
        let _ = sender.send(guarded(|| job(of_thread)));
    });
    thread.map_err(|error| exception(py, &Error::Internal(format!("no thread for the work: {error}"))))?;
    wait(py, progress, &monitor, &mut receiver)
}

/// A panic as an error.
pub(crate) fn guarded<T>(job: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(job)).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<&str>().map(ToString::to_string);
        let said = said.or_else(|| panic.downcast_ref::<String>().cloned());
        Err(Error::Internal(said.unwrap_or_else(|| "a panic".into())))
    })
}

/// Waits for the result of work on another thread, as [`work`].
///
/// # Errors
/// As [`work`].
pub(crate) fn wait<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    monitor: &Monitor,
    receiver: &mut Receiver<Result<T>>,
) -> PyResult<T> {
    let mut told = None;
    loop {
        // A reference that nobody shares may go where the lock is not held.
        let alone = &mut *receiver;
        let received = py.detach(move || alone.recv_timeout(PATIENCE));
        let latest = *monitor.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let tell = || -> PyResult<()> {
            log_records::deliver(py)?;
            if let (Some(progress), Some(report)) = (progress, latest.filter(|_| latest != told)) {
                progress.call1((report.step, report.done, report.total))?;
            }
            py.check_signals()
        };
        let result = tell();
        told = latest;
        if let Err(raised) = result {
            monitor.stop();
            if received.is_err() {
                let _ = py.detach(move || receiver.recv_timeout(GRACE));
            }
            return Err(raised);
        }
        match received {
            Ok(result) => return result.map_err(|error| exception(py, &error)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Err(exception(py, &Error::Internal("the work's thread ended".into())));
            }
        }
    }
}
