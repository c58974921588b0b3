//! The steps of a chore: each with its name and its time.
use crate::programs::{Spent, timed};
use crate::run::Result;

/// Steps done so far.
#[derive(Default)]
pub(crate) struct Steps(Vec<(&'static str, Spent)>);

impl Steps {
    /// Does a step, and keeps its time in success and failure.
    pub(crate) fn step<T>(&mut self, name: &'static str, work: impl FnOnce() -> Result<T>) -> Result<T> {
        eprintln!("\n── {name}");
        let (outcome, spent) = timed(work);
        self.0.push((name, spent));
        outcome
    }

    pub(crate) fn print(&self) {
        println!();
        for (name, spent) in &self.0 {
            println!("{name:>15} {spent}");
        }
    }
}
