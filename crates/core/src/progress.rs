/// How long work reports to its caller, and how the caller stops it.
///
/// Implementations must be cheap: [`Progress::report`] is called up to a few thousand times a second.
pub trait Progress: Sync {
    /// `done` of `total` units of the step `step` are finished. A step begins with `done == 0` and ends with
    /// `done == total`; its units are of about equal cost.
    fn report(&self, step: &'static str, done: u64, total: u64);

    /// Whether to stop. Asked between units; work that sees `true` returns [`crate::Error::Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }
}

/// Reports nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoProgress;

impl Progress for NoProgress {
    fn report(&self, _step: &'static str, _done: u64, _total: u64) {}
}

/// Reports, then fails with [`crate::Error::Cancelled`] if the caller asked to stop.
pub(crate) fn step(progress: &dyn Progress, name: &'static str, done: u64, total: u64) -> crate::Result<()> {
    progress.report(name, done, total);
    if progress.cancelled() { Err(crate::Error::Cancelled) } else { Ok(()) }
}
