//! Progress of long work, and the request to stop it.
use crate::{Error, Result, Warning};

/// How long work reports to its caller, and how the caller stops it.
///
/// Implementations must be cheap: [`Progress::report`] is called up to a few thousand times a second.
pub trait Progress: Sync {
    /// `done` of `total` units of the step `step` are finished. A step begins with `done == 0` and ends with
    /// `done == total`; its units are of about equal cost.
    fn report(&self, step: &'static str, done: u64, total: u64);

    /// Whether to stop. Asked between units; work that sees `true` returns [`Error::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }

    /// Tells a user of a warning and what can be done about it. It goes to the log unless an implementation
    /// shows it.
    fn warn(&self, warning: &Warning) {
        log::warn!("{warning}");
    }

    /// Reports, then asks whether to stop.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if the caller asked to stop.
    fn step(&self, step: &'static str, done: u64, total: u64) -> Result<()> {
        self.report(step, done, total);
        if self.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }
}

/// Reports nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoProgress;

impl Progress for NoProgress {
    fn report(&self, _step: &'static str, _done: u64, _total: u64) {}
}
