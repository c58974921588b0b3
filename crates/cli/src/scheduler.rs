//! Lines on standard output that a scheduler of a render farm reads, as Open Job Description has them.

use std::io::Write;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Percentages come at most this often.
const EVERY: Duration = Duration::from_secs(1);

/// The scheduler that started this process.
pub(crate) struct Scheduler {
    /// Each step of the work that has parts, with the share of the work that it is.
    shares: &'static [(&'static str, f64)],
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    step: &'static str,
    percent: f64,
    last: Option<Instant>,
}

impl Scheduler {
    /// `shares` names the steps in their order, as progress reports them. Other steps count as nothing.
    pub(crate) fn new(shares: &'static [(&'static str, f64)]) -> Self {
        Self { shares, state: Mutex::default() }
    }

    /// Says how far the work is.
    pub(crate) fn report(&self, step: &'static str, done: u64, total: u64) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.step != step {
            state.step = step;
            say("status", step);
        }
        let Some(at) = self.shares.iter().position(|(name, _)| *name == step) else { return };
        let share = |shares: &[(&str, f64)]| shares.iter().map(|(_, share)| share).sum::<f64>();
        let part = if total == 0 { 0.0 } else { done as f64 / total as f64 };
        let percent = 100.0 * (share(&self.shares[..at]) + part * self.shares[at].1) / share(self.shares);
        // A step that comes twice does not lead back.
        state.percent = state.percent.max(percent.min(100.0));
        if state.last.is_none_or(|last| last.elapsed() >= EVERY) || done >= total {
            state.last = Some(Instant::now());
            say("progress", &format!("{:.1}", state.percent));
        }
    }

    /// Says why the work failed.
    pub(crate) fn fail(sentence: &str) {
        say("fail", sentence);
    }
}

fn say(what: &str, text: &str) {
    let line: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let mut out = std::io::stdout().lock();
    // Nobody may be listening any more.
    let _ = writeln!(out, "openjd_{what}: {line}").and_then(|()| out.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_percentage_is_of_the_whole_work_and_never_falls() {
        let scheduler = Scheduler::new(&[("animate", 0.75), ("verify", 0.25)]);
        let mut percentages = Vec::new();
        for (step, done) in [
            ("read the rig", 1),
            ("animate", 0),
            ("animate", 2),
            ("animate", 4),
            ("verify", 2),
            ("animate", 1),
            ("verify", 4),
        ] {
            scheduler.report(step, done, 4);
            percentages.push(scheduler.state.lock().unwrap().percent);
        }
        assert_eq!(percentages, [0.0, 0.0, 37.5, 75.0, 87.5, 87.5, 100.0]);
    }
}
