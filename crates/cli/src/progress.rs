//! Progress while work goes on: bars with an estimate on a terminal, plain lines otherwise, nothing with
//! `--quiet`. All of it goes to stderr.

use crate::call::Caller;
use crate::scheduler::Scheduler;
use crate::{output, remedy};
use clap::builder::styling::AnsiColor;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rhytid::Progress;
use rhytid::core::Warning;
use rhytid::core::human;
use std::collections::BTreeSet;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Plain lines of a running step come at most this often.
const LINE_EVERY: Duration = Duration::from_secs(5);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Silent,
    Lines,
    Bars,
}

/// The user at the other end of stderr.
pub(crate) struct Ui {
    mode: Mode,
    verbose: bool,
    step: Mutex<Option<Step>>,
    finished: Mutex<Vec<(&'static str, Duration)>>,
    /// The warnings that were shown. A file that is read twice gives the same warnings again.
    warnings: Mutex<BTreeSet<String>>,
    /// The warnings since [`Ui::noted`] was called.
    noted: Mutex<Vec<String>>,
    /// Whether the user asked to stop.
    stops: Arc<AtomicBool>,
    /// The program that called the command, in place of a user.
    caller: Option<Caller>,
    /// The scheduler of a render farm, which also wants to know how far the work is.
    scheduler: OnceLock<Scheduler>,
}

#[derive(Debug)]
struct Step {
    name: &'static str,
    started: Instant,
    last_line: Instant,
    /// Hidden unless the mode is [`Mode::Bars`].
    bar: ProgressBar,
}

impl Ui {
    /// Silent if `quiet`, else as stderr allows.
    pub(crate) fn new(quiet: bool, verbose: bool) -> Self {
        let mode = match quiet {
            true => Mode::Silent,
            false if io::stderr().is_terminal() => Mode::Bars,
            false => Mode::Lines,
        };
        Self {
            mode,
            verbose,
            step: Mutex::default(),
            finished: Mutex::default(),
            warnings: Mutex::default(),
            noted: Mutex::default(),
            stops: Arc::default(),
            caller: None,
            scheduler: OnceLock::new(),
        }
    }

    /// Writes nothing: progress and warnings go to the program that called the command.
    pub(crate) fn for_program(caller: Caller) -> Self {
        Self { caller: Some(caller), ..Self::new(true, false) }
    }

    /// The same user, who sees no progress of this part of the work.
    pub(crate) fn muted(&self) -> Self {
        let stops = Arc::clone(&self.stops);
        Self { stops, caller: self.caller.clone(), ..Self::new(true, self.verbose) }
    }

    /// Also tells a scheduler how far the work is. Only the first call counts.
    pub(crate) fn tell(&self, scheduler: Scheduler) {
        let _ = self.scheduler.set(scheduler);
    }

    /// Whether times, settings and whole lists are wanted.
    pub(crate) fn is_verbose(&self) -> bool {
        self.verbose
    }

    /// Whether summaries and notes are wanted.
    pub(crate) fn is_quiet(&self) -> bool {
        self.mode == Mode::Silent
    }

    /// Writes one line to stderr, above the bar if there is one. A warning that was shown is not shown again.
    /// Errors are ignored: they could not be reported.
    pub(crate) fn line(&self, text: &str) {
        if self.caller.is_some() {
            log::info!("{text}");
            return;
        }
        if let Some(warning) = text.strip_prefix("warning: ") {
            self.note(warning);
            let mut shown = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
            if !shown.insert(text.to_owned()) {
                return;
            }
        }
        write_above(self.lock().as_ref(), text);
    }

    /// The warnings since the last call, of which a report is made.
    pub(crate) fn noted(&self) -> Vec<String> {
        std::mem::take(&mut *self.noted.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn note(&self, warning: &str) {
        self.noted.lock().unwrap_or_else(PoisonError::into_inner).push(warning.to_owned());
    }

    /// Runs a step that has no parts, and returns the time it took.
    pub(crate) fn timed<T>(&self, step: &'static str, work: impl FnOnce() -> T) -> (T, Duration) {
        self.report(step, 0, 1);
        let result = timed(work);
        self.report(step, 1, 1);
        result
    }

    /// The steps finished so far and how long each took; none where the user wants no summary.
    pub(crate) fn finished(&self) -> Vec<(&'static str, Duration)> {
        self.finished.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Asks the work to stop. Returns whether it was asked before.
    pub(crate) fn ask_to_stop(&self) -> bool {
        self.stops.swap(true, Ordering::Relaxed)
    }

    /// Takes the bar away, if any.
    pub(crate) fn clear(&self) {
        if let Some(step) = self.lock().take() {
            step.bar.finish_and_clear();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Option<Step>> {
        // A panic elsewhere must not keep its own sentence from being shown.
        self.step.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn begin(&self, name: &'static str, total: u64) -> Step {
        let target = match self.mode {
            Mode::Bars => ProgressDrawTarget::stderr(),
            _ => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(total), target).with_message(name);
        // A step without parts has no estimate.
        let style = match total {
            0 | 1 => "{msg:28} {elapsed}",
            _ => "{msg:28} [{bar:32}] {percent:>3} %  {elapsed}, about {eta} left",
        };
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style.progress_chars("=> "));
        }
        match self.mode {
            // Redraws while a step's units take long.
            Mode::Bars => bar.enable_steady_tick(Duration::from_millis(250)),
            _ => write_above(None, &format!("{name} …")),
        }
        let now = Instant::now();
        Step { name, started: now, last_line: now, bar }
    }
}

fn write_above(step: Option<&Step>, text: &str) {
    // The stream drops the colours if stderr is no terminal, or if NO_COLOR is set.
    let write = || drop(writeln!(anstream::stderr().lock(), "{}", coloured(&output::harmless(text))));
    match step {
        Some(step) => step.bar.suspend(write),
        None => write(),
    }
}

/// The line with its label, such as `warning:`, in the colour that clap gives it.
fn coloured(line: &str) -> String {
    let labels = [("error", AnsiColor::Red), ("warning", AnsiColor::Yellow), ("note", AnsiColor::Cyan)];
    for (label, colour) in labels {
        if let Some(rest) = line.strip_prefix(label).and_then(|rest| rest.strip_prefix(':')) {
            let style = colour.on_default().bold();
            return format!("{style}{label}:{style:#}{rest}");
        }
    }
    line.to_owned()
}

impl Progress for Ui {
    fn report(&self, name: &'static str, done: u64, total: u64) {
        if let Some(caller) = &self.caller {
            caller.report(name, done, total);
        }
        if let Some(scheduler) = self.scheduler.get() {
            scheduler.report(name, done, total);
        }
        if self.mode == Mode::Silent {
            return;
        }
        let mut current = self.lock();
        if let Some(old) = current.take_if(|step| step.name != name) {
            old.bar.finish_and_clear();
        }
        let step = current.get_or_insert_with(|| self.begin(name, total));
        step.bar.set_position(done);
        if done >= total {
            step.bar.finish_and_clear();
            let taken = step.started.elapsed();
            self.finished.lock().unwrap_or_else(PoisonError::into_inner).push((name, taken));
            if self.mode == Mode::Bars || taken >= Duration::from_secs(1) {
                write_above(None, &format!("{name}: {}", human::duration(taken)));
            }
            *current = None;
        } else if self.mode == Mode::Lines && step.last_line.elapsed() >= LINE_EVERY && done > 0 {
            step.last_line = Instant::now();
            let left = step.started.elapsed().mul_f64((total - done) as f64 / done as f64);
            let percent = 100 * done / total;
            write_above(None, &format!("{name}: {percent} %, about {} left", human::duration(left)));
        }
    }

    fn cancelled(&self) -> bool {
        let stops = || self.stops.load(Ordering::Relaxed);
        self.caller.as_ref().map_or_else(stops, |caller| caller.cancelled())
    }

    fn warn(&self, warning: &Warning) {
        if let Some(caller) = &self.caller {
            self.note(&remedy::of_warning(warning));
            return caller.warn(warning);
        }
        log::warn!("{}", remedy::of_warning(warning));
    }
}

/// Runs `work` and returns the time it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed())
}

/// Sends log records to `ui` as lines such as `warning: …`. Shows warnings, and more with each `verbose`. The
/// environment variable RUST_LOG overrides both.
pub(crate) fn install_logger(ui: &Arc<Ui>, quiet: bool, verbose: u8) {
    let level = match verbose {
        _ if quiet => log::LevelFilter::Warn,
        0 => log::LevelFilter::Warn,
        1 => log::LevelFilter::Info,
        2 => log::LevelFilter::Debug,
        _ => log::LevelFilter::Trace,
    };
    let format = |out: &mut env_logger::fmt::Formatter, record: &log::Record<'_>| {
        let level = match record.level() {
            log::Level::Error => "error",
            log::Level::Warn => "warning",
            log::Level::Info => "info",
            log::Level::Debug => "debug",
            log::Level::Trace => "trace",
        };
        writeln!(out, "{level}: {}", record.args())
    };
    // While it looks for devices, wgpu reports every missing API. Our own backend reports what matters.
    let of_wgpu = if verbose < 2 { log::LevelFilter::Off } else { level };
    let mut builder = env_logger::Builder::new();
    for module in ["egui_wgpu", "wgpu", "wgpu_core", "wgpu_hal", "naga"] {
        builder.filter_module(module, of_wgpu);
    }
    builder
        .filter_level(level)
        .parse_default_env()
        .format(format)
        .target(env_logger::Target::Pipe(Box::new(LogLines(Arc::clone(ui)))))
        .init();
}

/// One record comes as one write.
struct LogLines(Arc<Ui>);

impl Write for LogLines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.line(String::from_utf8_lossy(bytes).trim_end_matches('\n'));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_coloured_and_nothing_else() {
        assert_eq!(coloured("warning: a note: b"), "\u{1b}[1m\u{1b}[33mwarning:\u{1b}[0m a note: b");
        assert_eq!(coloured("read: 1.2 s"), "read: 1.2 s");
    }
}
