//! The time that each stage takes, also where threads go through several stages block by block.
use rhytid_core::Stage;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;
use web_time::Instant;

/// Nanoseconds of each stage.
#[derive(Debug, Default)]
pub(crate) struct Times([AtomicU64; 6]);

impl Times {
    /// Adds the time since `start` to a stage, and returns the present time.
    pub(crate) fn add(&self, stage: Stage, start: Instant) -> Instant {
        let now = Instant::now();
        self.0[stage as usize].fetch_add((now - start).as_nanos() as u64, Relaxed);
        now
    }

    /// Adds the time that `work` takes. It is divided in proportion to the times that its threads add to
    /// those passed to it.
    pub(crate) fn shared(&self, work: impl FnOnce(&Times)) {
        let (start, of_threads) = (Instant::now(), Times::default());
        work(&of_threads);
        let wall = start.elapsed().as_secs_f64();
        let of_threads = of_threads.durations();
        let sum = of_threads.iter().sum::<Duration>().as_secs_f64();
        for (nanoseconds, of_threads) in self.0.iter().zip(of_threads) {
            let share = if sum > 0.0 { of_threads.as_secs_f64() / sum } else { 0.0 };
            nanoseconds.fetch_add((wall * share * 1e9) as u64, Relaxed);
        }
    }

    /// In the order of [`Stage::ALL`].
    pub(crate) fn durations(&self) -> [Duration; 6] {
        self.0.each_ref().map(|nanoseconds| Duration::from_nanos(nanoseconds.load(Relaxed)))
    }
}
