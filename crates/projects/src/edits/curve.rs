//! Numbers over time: keys, and what is between them.

use serde::{Serialize, Serializer};

/// A number that changes over a take's frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Frames, counted from 0, and values: at least one pair, with rising frames. Before the first key the
    /// curve has the value of the first key, and behind the last key that of the last.
    pub keys: Vec<(f64, f64)>,
    /// The easing from key to key.
    pub ease: Ease,
}

/// How a curve goes from one key to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ease {
    /// Slowly out of a key and slowly into the next one: 3s² − 2s³.
    #[default]
    Smooth,
    /// Linearly.
    Linear,
    /// The value stays, and jumps at the next key.
    Step,
}

impl Curve {
    /// The same in every frame.
    pub fn constant(value: f64) -> Self {
        Self { keys: vec![(0.0, value)], ease: Ease::default() }
    }

    /// The value at a frame, which may be between two.
    pub fn at(&self, frame: f64) -> f64 {
        let next = self.keys.partition_point(|(at, _)| *at <= frame);
        let Some(&(from, before)) = next.checked_sub(1).and_then(|i| self.keys.get(i)) else {
            return self.keys.first().map_or(0.0, |(_, value)| *value);
        };
        let Some(&(to, after)) = self.keys.get(next) else { return before };
        let s = (frame - from) / (to - from);
        before + self.ease.at(s) * (after - before)
    }

    /// Whether it has this value in every frame.
    pub fn is_constantly(&self, value: f64) -> bool {
        self.keys.iter().all(|(_, found)| *found == value)
    }
}

impl Ease {
    /// The progress at `s` of the way, both from 0 to 1.
    pub fn at(self, s: f64) -> f64 {
        match self {
            Self::Smooth => s * s * (3.0 - 2.0 * s),
            Self::Linear => s,
            Self::Step => 0.0,
        }
    }
}

/// A constant curve is a number, and any other is pairs of frame and value. The easing has a key of its own.
impl Serialize for Curve {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.keys[..] {
            [(_, value)] => value.serialize(serializer),
            keys => keys.serialize(serializer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_met_and_held_beyond_their_ends() {
        let keys = vec![(10.0, 1.0), (20.0, 3.0), (24.0, 0.0)];
        for (ease, between) in [(Ease::Smooth, 1.0 + 2.0 * 0.104), (Ease::Linear, 1.4), (Ease::Step, 1.0)] {
            let curve = Curve { keys: keys.clone(), ease };
            let expected = [(-5.0, 1.0), (10.0, 1.0), (12.0, between), (20.0, 3.0), (24.0, 0.0), (99.0, 0.0)];
            for (frame, value) in expected {
                assert!((curve.at(frame) - value).abs() < 1e-12, "{ease:?} at {frame}: {}", curve.at(frame));
            }
            // Smooth: the middle is the mean, whichever way it goes.
            assert!(ease == Ease::Step || (curve.at(15.0) - 2.0).abs() < 1e-12);
        }
        assert_eq!(Curve::constant(0.25).at(1e9), 0.25);
    }
}
