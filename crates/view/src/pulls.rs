//! Pulls of markers, and in which frames each of them acts.

use crate::document::TimelineEvent;
use rhytid_core::Rig;
use rhytid_formats::edits::{Curve, Ease, Offset};

/// Offsets are whole numbers of this part of a millimetre, and times of this part of a second. Files have
/// three digits after the point then.
const PARTS: f64 = 1e3;

/// The frames in which a pull acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum When {
    /// In all frames.
    #[default]
    Whole,
    /// From a frame on.
    From,
    /// At a frame, or in a few frames.
    At,
}

impl When {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Whole, Self::From, Self::At];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole take",
            Self::From => "from here",
            Self::At => "at this frame",
        }
    }
}

/// When a pull acts, and how it comes and goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// In which frames.
    pub when: When,
    /// Its first and its last frame, in which it acts fully. [`When::Whole`] has neither, and [`When::From`]
    /// has no last one.
    pub frames: [usize; 2],
    /// Seconds in which it comes before its first frame, and goes after its last one. They are 0 where there
    /// is no such frame.
    pub ease: [f64; 2],
}

impl Span {
    /// A span that begins at `frame`, with seconds of `ease` before and after it.
    pub fn new(when: When, frame: usize, ease: [f64; 2]) -> Self {
        let [before, after] = ease.map(rounded);
        match when {
            When::Whole => Self { when, frames: [0; 2], ease: [0.0; 2] },
            When::From => Self { when, frames: [frame; 2], ease: [before, 0.0] },
            When::At => Self { when, frames: [frame; 2], ease: [before, after] },
        }
    }

    /// The same with seconds as files have them.
    pub(crate) fn rounded(self) -> Self {
        Self { ease: self.ease.map(rounded), ..self }
    }

    /// The factor of the pull over the frames of a take with `rate` frames a second. A pull without an ease
    /// comes from one frame to the next.
    pub fn curve(&self, rate: f64) -> Curve {
        let ramp = self.ease.map(|seconds| rounded(seconds * rate).max(1.0));
        let [first, last] = self.frames.map(|frame| frame as f64);
        let mut keys = vec![(rounded(first - ramp[0]), 0.0), (first, 1.0)];
        match self.when {
            When::Whole => return Curve::constant(1.0),
            When::From => {}
            When::At => {
                keys.extend((last > first).then_some((last, 1.0)));
                keys.push((rounded(last + ramp[1]), 0.0));
            }
        }
        Curve { keys, ease: Ease::default() }
    }

    /// Whether the pull acts fully in a frame.
    pub fn is_full_at(&self, frame: usize) -> bool {
        match self.when {
            When::Whole => true,
            When::From => frame >= self.frames[0],
            When::At => (self.frames[0]..=self.frames[1]).contains(&frame),
        }
    }

    /// The span in words, such as `from 12`.
    pub fn in_words(&self) -> String {
        let [first, last] = self.frames;
        match self.when {
            When::Whole => "whole take".to_owned(),
            When::From => format!("from {first}"),
            When::At if first == last => format!("at {first}"),
            When::At => format!("{first} to {last}"),
        }
    }
}

/// Markers that were pulled together.
#[derive(Debug, Clone, PartialEq)]
pub struct Pull {
    /// In which frames.
    pub span: Span,
    /// H vectors in millimetres along the mesh's axes.
    pub millimetres: Vec<[f64; 3]>,
}

impl Pull {
    /// A pull that moves nothing yet.
    pub(crate) fn still(span: Span, handles: usize) -> Self {
        Self { span, millimetres: vec![[0.0; 3]; handles] }
    }

    /// Adds H vectors in mesh units of `millimetres` each. Sums are rounded to what files have.
    pub(crate) fn add(&mut self, moved: &[[f32; 3]], millimetres: f64) {
        for (sum, by) in self.millimetres.iter_mut().zip(moved) {
            *sum = std::array::from_fn(|c| rounded(sum[c] + millimetres * f64::from(by[c])));
        }
    }

    /// Whether it moves a marker.
    pub fn moves(&self) -> bool {
        self.millimetres.iter().any(|by| *by != [0.0; 3])
    }

    /// The pull as in a file of edits.
    pub fn offset(&self, rig: &Rig, rate: f64) -> Offset {
        let labelled = rig.handles().labels.iter().zip(&self.millimetres);
        let markers = labelled.filter(|(_, by)| **by != [0.0; 3]);
        let amount = self.span.curve(rate);
        Offset {
            region: None,
            millimetres: None,
            markers: markers.map(|(label, by)| (label.clone(), *by)).collect(),
            ease: amount.ease,
            amount,
        }
    }

    /// Its markers, for people. The one that moves farthest comes first.
    fn names(&self, rig: &Rig) -> String {
        let far = |handle: &usize| self.millimetres[*handle].iter().map(|x| x * x).sum::<f64>();
        let mut moved: Vec<usize> = (0..self.millimetres.len()).filter(|handle| far(handle) > 0.0).collect();
        moved.sort_by(|a, b| far(b).total_cmp(&far(a)));
        let names: Vec<&str> = moved.iter().map(|&handle| &*rig.handles().labels[handle]).collect();
        crate::edits::some_of(&names)
    }

    /// Its frames and its markers, for people.
    pub fn in_words(&self, rig: &Rig) -> String {
        format!("{}: {}", self.span.in_words(), self.names(rig))
    }

    /// Its place on the time line of so many frames.
    pub(crate) fn event(&self, rig: &Rig, rate: f64, frames: usize) -> TimelineEvent {
        let curve = self.span.curve(rate);
        let acts = |frame: &usize| curve.at(*frame as f64) != 0.0;
        let first = (0..frames).find(acts).unwrap_or(0);
        let last = (0..frames).rfind(acts).unwrap_or(first);
        let words = format!("pull: {}", self.names(rig));
        TimelineEvent::new(first, last + 1 - first, words)
    }
}

/// H vectors in millimetres: the sum of all pulls in a frame.
pub(crate) fn sum(pulls: &[&Pull], handles: usize, rate: f64, frame: usize) -> Vec<[f64; 3]> {
    let mut sum = vec![[0.0; 3]; handles];
    for pull in pulls {
        let amount = pull.span.curve(rate).at(frame as f64);
        if amount != 0.0 {
            for (sum, by) in sum.iter_mut().zip(&pull.millimetres) {
                *sum = std::array::from_fn(|c| sum[c] + amount * by[c]);
            }
        }
    }
    sum
}

/// The number with three digits after the point. Zero has no sign.
fn rounded(number: f64) -> f64 {
    (number * PARTS).round() / PARTS + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pull_acts_fully_in_its_frames_and_comes_and_goes_smoothly() {
        // At 25 frames a second, 0.2 s are five frames and 0.08 s are two.
        let mut span = Span::new(When::At, 20, [0.2, 0.08]);
        span.frames[1] = 23;
        let smooth = |s: f64| s * s * (3.0 - 2.0 * s);
        let curve = span.curve(25.0);
        for (frame, expected) in [
            (15, 0.0),
            (16, smooth(0.2)),
            (19, smooth(0.8)),
            (20, 1.0),
            (21, 1.0),
            (23, 1.0),
            (24, smooth(0.5)),
            (25, 0.0),
            (400, 0.0),
        ] {
            let found = curve.at(f64::from(frame));
            assert!((found - expected).abs() < 1e-12, "frame {frame}: {found}, expected {expected}");
            assert_eq!(found == 1.0, span.is_full_at(frame as usize), "frame {frame}");
        }
        // Without an ease, one frame alone, and all frames from one on.
        let at = |when, frame: f64| Span::new(when, 20, [0.0; 2]).curve(25.0).at(frame);
        assert_eq!([19.0, 20.0, 21.0].map(|frame| at(When::At, frame)), [0.0, 1.0, 0.0]);
        assert_eq!([0.0, 19.0, 20.0, 999.0].map(|frame| at(When::From, frame)), [0.0, 0.0, 1.0, 1.0]);
        assert_eq!([0.0, 999.0].map(|frame| at(When::Whole, frame)), [1.0, 1.0]);
        // The ease of a pull at the first frame begins before the take.
        assert_eq!(Span::new(When::From, 0, [0.2, 0.0]).curve(25.0).at(0.0), 1.0);
    }

    #[test]
    fn numbers_have_as_many_digits_as_they_mean() {
        let mut pull = Pull::still(Span::new(When::At, 7, [0.1234567, 0.0]), 2);
        // As of a drag by 0.3 cm: 2.9999998211860657 mm in single precision.
        pull.add(&[[0.3 - 1e-8, -0.125, -1e-9], [0.0; 3]], 10.0);
        assert_eq!(format!("{:?}", pull.millimetres[0]), "[3.0, -1.25, 0.0]");
        assert_eq!(pull.span.ease, [0.123, 0.0]);
        assert_eq!(pull.span.curve(30.0).keys[0], (3.31, 0.0));
    }
}
