//! Timing several sides in turns.
use rhytid_core::Result;
use serde::{Deserialize, Serialize};

/// The time of an evaluation by part, in milliseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Times {
    pub large_scale: f64,
    pub large_scale_normals: f64,
    /// Strain, detail and tangent frames.
    pub detail: f64,
    pub normals: f64,
    /// Time to put frames one after the other, for peers that compute them side by side.
    #[serde(default)]
    pub rearranging: f64,
    pub whole: f64,
}

impl Times {
    /// The parts in the order of the fields.
    pub(crate) fn parts(&self) -> [f64; 6] {
        let Self { large_scale, large_scale_normals, detail, normals, rearranging, whole } = *self;
        [large_scale, large_scale_normals, detail, normals, rearranging, whole]
    }

    /// A value from the parts in the order of the fields.
    fn from_parts(parts: [f64; 6]) -> Self {
        let [large_scale, large_scale_normals, detail, normals, rearranging, whole] = parts;
        Self { large_scale, large_scale_normals, detail, normals, rearranging, whole }
    }
}

/// The frames to evaluate: the first one, or all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum What {
    Frame,
    Batch,
}

impl What {
    /// The name in requests to peers, and the beginning of their files' names.
    pub(crate) fn name(self) -> &'static str {
        match self {
            What::Frame => "frame",
            What::Batch => "batch",
        }
    }

    pub(crate) fn frames(self) -> usize {
        match self {
            What::Frame => 1,
            What::Batch => crate::FRAMES,
        }
    }
}

/// A program that evaluates frames.
pub(crate) trait Side {
    /// Evaluates once more.
    ///
    /// # Errors
    /// The errors of the side.
    fn evaluate(&mut self, what: What) -> Result<Times>;
}

/// How often each side evaluates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schedule {
    what: What,
    rounds: usize,
    /// Evaluations at the beginning of each turn that are not counted, since other sides had the caches
    /// before.
    uncounted: usize,
    counted: usize,
}

/// One frame.
pub(crate) const FRAME: Schedule = Schedule { what: What::Frame, rounds: 8, uncounted: 1, counted: 5 };
/// A batch. It is long enough that its beginning does not matter.
pub(crate) const BATCH: Schedule = Schedule { what: What::Batch, rounds: 5, uncounted: 0, counted: 1 };

/// The medians of `sides` per frame, for each part by itself.
/// The sides take turns, so that other work on the machine affects all of them.
///
/// # Errors
/// The first error of a side.
pub(crate) fn in_turns<const N: usize>(
    sides: &mut [&mut dyn Side; N],
    schedule: Schedule,
) -> Result<[Times; N]> {
    let mut samples = [(); N].map(|()| Vec::new());
    for _ in 0..schedule.rounds {
        for (side, samples) in sides.iter_mut().zip(&mut samples) {
            for i in 0..schedule.uncounted + schedule.counted {
                let times = side.evaluate(schedule.what)?;
                if i >= schedule.uncounted {
                    samples.push(times.parts());
                }
            }
        }
    }
    let frames = schedule.what.frames() as f64;
    Ok(samples.map(|samples| {
        let median_of = |part| median(samples.iter().map(|parts| parts[part]).collect()) / frames;
        Times::from_parts([0, 1, 2, 3, 4, 5].map(median_of))
    }))
}

/// The median. Of an even number of values it is the lower one in the middle; of none, NaN.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    struct Counting<'a>(char, f64, &'a RefCell<String>);

    impl Side for Counting<'_> {
        fn evaluate(&mut self, _: What) -> Result<Times> {
            self.2.borrow_mut().push(self.0);
            self.1 += 10.0;
            Ok(Times { whole: self.1, ..Times::default() })
        }
    }

    #[test]
    fn sides_take_turns_and_the_first_of_each_turn_does_not_count() {
        let order = RefCell::default();
        let schedule = Schedule { what: What::Frame, rounds: 2, uncounted: 1, counted: 2 };
        let (mut a, mut b) = (Counting('a', 0.0, &order), Counting('b', 1000.0, &order));
        let [a, b] = in_turns(&mut [&mut a, &mut b], schedule).unwrap();
        assert_eq!(order.into_inner(), "aaabbbaaabbb");
        // Turns of a: 10, then 20 and 30; 40, then 50 and 60.
        assert_eq!((a.whole, b.whole), (30.0, 1030.0));
    }

    #[test]
    fn a_batch_is_given_per_frame() {
        let order = RefCell::default();
        let schedule = Schedule { what: What::Batch, rounds: 3, uncounted: 0, counted: 1 };
        let [times] = in_turns(&mut [&mut Counting('a', 0.0, &order)], schedule).unwrap();
        assert_eq!(times.whole, 20.0 / crate::FRAMES as f64);
    }
}
