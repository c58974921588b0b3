//! Whether a picture is drawn in full, or coarsely while it changes.

use crate::scene::Times;
use web_time::Duration;

/// A picture that takes longer is drawn coarsely while it changes.
const SMOOTH: Duration = Duration::from_millis(50);
/// Coarse pictures have so few pixels that drawing them takes about this long.
const DRAWING: Duration = Duration::from_millis(25);
/// Coarse pictures have at least this part of the width and height.
const MOST_PARTS: u32 = 3;
/// After so many seconds without a change, the picture is drawn in full.
const REST: f64 = 0.15;

/// How well a picture is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fineness {
    /// In full.
    Whole,
    /// Skin keeps the light of the last whole picture. Width and height are divided by `parts`.
    Coarse { parts: u32 },
}

impl Fineness {
    /// By how much the width and the height of the picture are divided.
    pub(crate) fn parts(self) -> u32 {
        match self {
            Self::Whole => 1,
            Self::Coarse { parts } => parts,
        }
    }
}

/// Chooses how well the next picture is drawn.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    /// The times of the last whole picture.
    whole: Times,
    /// The time of the last change, in seconds.
    changed: f64,
    /// Whether all pictures are drawn in full.
    pub always_whole: bool,
}

impl Pace {
    /// Takes note of a change at `now`, in seconds.
    pub(crate) fn change(&mut self, now: f64) {
        self.changed = now;
    }

    /// Takes note of what a whole picture cost.
    pub(crate) fn measured(&mut self, times: Times) {
        self.whole = times;
    }

    /// How well the picture is drawn at `now`.
    pub(crate) fn fineness(&self, now: f64) -> Fineness {
        let Times { evaluation, lighting, drawing } = self.whole;
        let is_slow = evaluation + lighting + drawing > SMOOTH;
        if self.always_whole || !is_slow || self.until_rest(now).is_none() {
            return Fineness::Whole;
        }
        let parts = (drawing.as_secs_f64() / DRAWING.as_secs_f64()).sqrt().ceil() as u32;
        Fineness::Coarse { parts: parts.clamp(1, MOST_PARTS) }
    }

    /// How long nothing may change until the picture is at rest. `None` at rest.
    pub(crate) fn until_rest(&self, now: f64) -> Option<Duration> {
        let left = self.changed + REST - now;
        (left > 0.0).then(|| Duration::from_secs_f64(left))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(lighting: u64, drawing: u64) -> Times {
        let [lighting, drawing] = [lighting, drawing].map(Duration::from_millis);
        Times { evaluation: Duration::from_millis(1), lighting, drawing }
    }

    #[test]
    fn only_what_is_slow_and_changes_is_coarse() {
        let mut pace = Pace::default();
        pace.change(10.0);
        assert_eq!(pace.fineness(10.0), Fineness::Whole, "what it costs is not known yet");
        pace.measured(costs(0, 20));
        assert_eq!(pace.fineness(10.01), Fineness::Whole, "it is fast");
        pace.measured(costs(400, 20));
        assert_eq!(pace.fineness(10.01), Fineness::Coarse { parts: 1 }, "the light is slow");
        pace.measured(costs(0, 60));
        assert_eq!(pace.fineness(10.14), Fineness::Coarse { parts: 2 }, "drawing is slow");
        assert_eq!(pace.fineness(10.16), Fineness::Whole, "it is at rest");
        pace.change(10.2);
        pace.measured(costs(0, 2_000));
        assert_eq!(pace.fineness(10.2), Fineness::Coarse { parts: 3 }, "not less than a third");
        pace.always_whole = true;
        assert_eq!(pace.fineness(10.2), Fineness::Whole);
    }
}
