//! The log, for reading in a test.
use std::sync::{Mutex, PoisonError};
use std::thread::ThreadId;

/// The messages that are logged on this thread, at any level, from [`Logged::start`] on. Other tests log on
/// other threads.
pub struct Logged {
    /// The index of its first message in the list of all.
    start: usize,
}

struct All(Mutex<Vec<(ThreadId, log::Level, String)>>);

static ALL: All = All(Mutex::new(Vec::new()));

impl log::Log for All {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        let entry = (std::thread::current().id(), record.level(), record.args().to_string());
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(entry);
    }

    fn flush(&self) {}
}

impl Logged {
    /// Records messages from now on. No other logger may be set in a process that uses this.
    pub fn start() -> Self {
        // Another test may have been first.
        let _ = log::set_logger(&ALL);
        log::set_max_level(log::LevelFilter::Trace);
        Self { start: ALL.0.lock().unwrap_or_else(PoisonError::into_inner).len() }
    }

    /// The messages since then, as `WARN what`.
    pub fn lines(&self) -> Vec<String> {
        let all = ALL.0.lock().unwrap_or_else(PoisonError::into_inner);
        let here = std::thread::current().id();
        let own = all[self.start..].iter().filter(|(thread, ..)| *thread == here);
        own.map(|(_, level, what)| format!("{level} {what}")).collect()
    }
}
