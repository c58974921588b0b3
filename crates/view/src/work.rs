//! Work beside the window: its progress, its warnings, and the request to stop it.

use eframe::egui;
use rhytid_core::{Progress, Warning};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use web_time::{Duration, Instant};

/// The window shows progress at most this often.
const SHOWN_EVERY: Duration = Duration::from_millis(100);

/// What work tells the window, and the window tells the work.
#[derive(Debug)]
pub(crate) struct Work {
    context: egui::Context,
    state: Mutex<State>,
    stops: AtomicBool,
}

#[derive(Debug)]
struct State {
    began: Instant,
    /// The step, and how many of its units are done. `None` before the first one.
    step: Option<(&'static str, u64, u64)>,
    shown: Instant,
    warnings: Vec<String>,
    is_finished: bool,
}

impl Work {
    /// Work that begins now. It wakes the window of `context`.
    pub(crate) fn new(context: &egui::Context) -> Arc<Self> {
        let now = Instant::now();
        let state = State { began: now, step: None, shown: now, warnings: Vec::new(), is_finished: false };
        Arc::new(Self { context: context.clone(), state: Mutex::new(state), stops: AtomicBool::new(false) })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks the work to stop.
    pub(crate) fn stop(&self) {
        self.stops.store(true, Ordering::Relaxed);
    }

    /// How long it has been going on.
    pub(crate) fn age(&self) -> Duration {
        self.state().began.elapsed()
    }

    /// The step and its percentage, such as `clean, 50 %`. Empty between two steps.
    pub(crate) fn step_in_words(&self) -> String {
        match self.state().step {
            None => String::new(),
            Some((_, done, total)) if done >= total => String::new(),
            Some((step, _, 0 | 1)) => step.to_owned(),
            Some((step, done, total)) => format!("{step}, {} %", 100 * done / total),
        }
    }

    /// The warnings since the last call.
    pub(crate) fn take_warnings(&self) -> Vec<String> {
        std::mem::take(&mut self.state().warnings)
    }

    /// Wakes the window.
    pub(crate) fn wake(&self) {
        self.context.request_repaint();
    }
}

impl Progress for Work {
    fn report(&self, step: &'static str, done: u64, total: u64) {
        let mut state = self.state();
        state.step = Some((step, done, total));
        if state.shown.elapsed() >= SHOWN_EVERY {
            state.shown = Instant::now();
            drop(state);
            self.wake();
        }
    }

    fn cancelled(&self) -> bool {
        self.stops.load(Ordering::Relaxed)
    }

    fn warn(&self, warning: &Warning) {
        log::warn!("{warning}");
        self.state().warnings.push(warning.to_string());
        self.wake();
    }
}

/// The next result of a task.
#[derive(Debug)]
pub(crate) enum Next<T> {
    Result(T),
    /// It is still at work.
    Waiting,
    /// All results were taken.
    Ended,
    /// It ended by a fault of its own.
    Broken,
}

/// Work on a thread of its own, which gives results one after the other. A browser has no threads: there, a
/// task is done before the window goes on.
#[derive(Debug)]
pub(crate) struct Task<T> {
    /// What it does, such as `reading take.csv`.
    pub words: String,
    pub work: Arc<Work>,
    results: Receiver<T>,
    #[cfg(not(target_arch = "wasm32"))]
    thread: Option<std::thread::JoinHandle<()>>,
}

impl<T: Send + 'static> Task<T> {
    /// Begins to `run`, which hands over its results by the function that it is given.
    pub(crate) fn new(
        words: String,
        context: &egui::Context,
        run: impl FnOnce(&Work, &dyn Fn(T)) + Send + 'static,
    ) -> Self {
        let work = Work::new(context);
        let (sender, results) = channel();
        let mine = work.clone();
        let run = move || {
            let give = |result| {
                // The receiver is gone where nobody waits for the results any longer.
                let _ = sender.send(result);
                mine.wake();
            };
            run(&mine, &give);
            mine.state().is_finished = true;
            drop(sender);
            mine.wake();
        };
        #[cfg(not(target_arch = "wasm32"))]
        let thread = Some(std::thread::spawn(run));
        #[cfg(target_arch = "wasm32")]
        run();
        Self {
            words,
            work,
            results,
            #[cfg(not(target_arch = "wasm32"))]
            thread,
        }
    }

    /// The next result, if it is there.
    pub(crate) fn next(&self) -> Next<T> {
        match self.results.try_recv() {
            Ok(result) => Next::Result(result),
            Err(TryRecvError::Empty) => Next::Waiting,
            Err(TryRecvError::Disconnected) => self.end(),
        }
    }

    /// The next result. Waits for it up to `patience`.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn wait(&self, patience: Duration) -> Next<T> {
        use std::sync::mpsc::RecvTimeoutError;
        match self.results.recv_timeout(patience) {
            Ok(result) => Next::Result(result),
            Err(RecvTimeoutError::Timeout) => Next::Waiting,
            Err(RecvTimeoutError::Disconnected) => self.end(),
        }
    }

    /// In a browser, everything is done already.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn wait(&self, _: Duration) -> Next<T> {
        self.next()
    }

    fn end(&self) -> Next<T> {
        if self.work.state().is_finished { Next::Ended } else { Next::Broken }
    }

    /// What it does, and how far it is.
    pub(crate) fn in_words(&self) -> String {
        match self.work.step_in_words() {
            step if step.is_empty() => self.words.clone(),
            step => format!("{}: {step}", self.words),
        }
    }
}

/// A task that uses a device. Some drivers crash if the program ends while a thread uses them, so its end is
/// waited for.
#[derive(Debug)]
pub(crate) struct DeviceTask<T>(pub Task<T>);

impl<T> Drop for DeviceTask<T> {
    fn drop(&mut self) {
        self.0.work.stop();
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(thread) = self.0.thread.take() {
            // If it panicked, this has been reported.
            let _ = thread.join();
        }
    }
}

/// Nobody waits for the results any longer.
impl<T> Drop for Task<T> {
    fn drop(&mut self) {
        self.work.stop();
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use rhytid_core::{Error, Result};

    const PATIENCE: Duration = Duration::from_secs(60);

    #[test]
    fn results_come_one_by_one_and_warnings_with_them() {
        let task = Task::new("counting".to_owned(), &egui::Context::default(), |work, give| {
            work.report("count", 1, 4);
            work.warn(&Warning::from("odd".to_owned()));
            give(1);
            give(2);
        });
        assert!(matches!(task.wait(PATIENCE), Next::Result(1)));
        assert!(matches!(task.wait(PATIENCE), Next::Result(2)));
        assert!(matches!(task.wait(PATIENCE), Next::Ended));
        assert_eq!(task.in_words(), "counting: count, 25 %");
        assert_eq!(task.work.take_warnings(), ["odd"]);
        assert!(task.work.take_warnings().is_empty(), "each warning is shown once");
    }

    #[test]
    fn work_that_is_stopped_ends_early_and_a_panic_is_no_end() {
        let endless: Task<Result<()>> =
            Task::new("waiting".to_owned(), &egui::Context::default(), |work, give| {
                let ended = loop {
                    if let Err(error) = work.step("wait", 0, 1) {
                        break error;
                    }
                };
                give(Err(ended));
            });
        assert!(matches!(endless.next(), Next::Waiting));
        endless.work.stop();
        assert!(matches!(endless.wait(PATIENCE), Next::Result(Err(Error::Cancelled))));
        let broken: Task<()> =
            Task::new("failing".to_owned(), &egui::Context::default(), |_, _| panic!("as it should"));
        assert!(matches!(broken.wait(PATIENCE), Next::Broken));
    }
}
