//! Selections: which frames of a take are played, and at which rate.

use crate::EditedTake;
use rhytid_core::{Error, Result, RigidMotion, Take, human};
use std::ops::Range;
use std::str::FromStr;

/// A step may differ from the take's usual step by this part of it. Above it, the take is resampled.
const STEP_TOLERANCE: f64 = 0.01;

/// A range of frames as people type it: `A..B`, `A..` or `..B`. A is part of the range, B is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameRange {
    /// A, counted from 0; `None` is the first frame.
    pub start: Option<usize>,
    /// B; `None` is behind the last frame.
    pub end: Option<usize>,
}

impl FrameRange {
    /// The range, with the ends that were left out filled in.
    ///
    /// # Errors
    /// [`Error::Input`] if the range is not within the take's `frames`.
    pub fn within(self, frames: usize) -> Result<Range<usize>> {
        let start = self.start.unwrap_or(0);
        let end = self.end.unwrap_or(frames);
        if end > frames || start >= end {
            let shown = |n: Option<usize>| n.map(|n| n.to_string()).unwrap_or_default();
            return Err(Error::out_of_range(format!(
                "the frames {}..{}: the take has {}, expected a range within 0..{frames}",
                shown(self.start),
                shown(self.end),
                human::counted(frames, "frame")
            )));
        }
        Ok(start..end)
    }
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected A..B, A.. or ..B with whole numbers, such as 100..200".to_owned();
        let number = |part: &str| match part {
            "" => Ok(None),
            digits => digits.parse().map(Some).map_err(|_| expected()),
        };
        let (start, end) = text.split_once("..").ok_or_else(expected)?;
        let range = FrameRange { start: number(start)?, end: number(end)? };
        match range {
            FrameRange { start, end: Some(end) } if start.unwrap_or(0) >= end => {
                Err(format!("it has no frame: A must be below B, and B = {end} is not part of it"))
            }
            range => Ok(range),
        }
    }
}

/// Evenly spaced frames, ready to be animated.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// The selected frames, and up to one more at each end if neighbours are wanted.
    pub take: EditedTake,
    /// The selected frames within `take`.
    pub inner: Range<usize>,
    /// Frames per second.
    pub rate: f64,
    /// Number of the first inner frame, counted from 0 at the take's start at `rate`.
    pub first: usize,
}

impl Selection {
    /// Selects the frames `range` of `take`, which [`FrameRange::within`] has checked.
    ///
    /// The take is resampled if `fps` says so or if its times are uneven. With `neighbours`, the frames
    /// before and after the range are included, if the take has them at that rate.
    ///
    /// Resampling keeps the clock. The whole take is resampled from its start, and then the frames within the
    /// range's time are kept. So frame numbers at the new rate are whole and stay in step with sound.
    ///
    /// # Errors
    /// [`Error::Input`] if the range holds no frame at the new rate.
    pub fn new(
        take: impl Into<EditedTake>,
        range: Range<usize>,
        fps: Option<f64>,
        neighbours: bool,
    ) -> Result<Self> {
        let edited: EditedTake = take.into();
        let take = &edited.take;
        let own_rate = take.rate();
        let chosen = take.slice(range.clone());
        let uneven = uneven_step(&chosen, own_rate).map(|(frame, step)| (range.start + frame, step));
        if let Some((frame, step)) = uneven {
            log::warn!(
                "the take's times are uneven: frame {frame} comes {step:.4} s after the one before it, {:.4} s is the \
                 usual; it is resampled to {} frames per second",
                1.0 / own_rate,
                human::number(fps.unwrap_or(own_rate))
            );
        }
        let rate = fps.unwrap_or(own_rate);
        if uneven.is_none() && rate == own_rate {
            // After a gap in the take, a frame's number differs from its row.
            let first = match uneven_step(take, own_rate) {
                None => range.start,
                Some(_) => ((take.times[range.start] - take.times[0]) * rate).round() as usize,
            };
            let is_step =
                |frame: usize| neighbours && uneven_step(&take.slice(frame..frame + 2), own_rate).is_none();
            let before = range.start > 0 && is_step(range.start - 1);
            let after = range.end < take.frames() && is_step(range.end - 1);
            let (before, after) = (usize::from(before), usize::from(after));
            let inner = before..before + range.len();
            return Ok(Self {
                take: edited.slice(range.start - before..range.end + after),
                inner,
                rate,
                first,
            });
        }
        // Files have rounded times, so times this close count as equal.
        let slack = STEP_TOLERANCE / rate;
        let from = take.times[range.start] - slack;
        let until = take.times.get(range.end).map_or(f64::INFINITY, |time| time - slack);
        let resampled = edited.resample(rate)?;
        let times = &resampled.take.times;
        let first = times.partition_point(|&time| time < from);
        let end = times.partition_point(|&time| time < until);
        if first >= end {
            return Err(Error::out_of_range(format!(
                "the frames {}..{}: at {} frames per second no frame falls into this range; widen the range \
                 or raise the rate",
                range.start,
                range.end,
                human::number(rate)
            )));
        }
        let before = usize::from(neighbours && first > 0);
        let after = usize::from(neighbours && end < resampled.frames());
        let inner = before..before + (end - first);
        Ok(Self { take: resampled.slice(first - before..end + after), inner, rate, first })
    }

    /// All frames of `take`, at its own rate.
    ///
    /// # Errors
    /// As [`Selection::new`].
    pub fn all(take: impl Into<EditedTake>) -> Result<Self> {
        let take = take.into();
        let frames = take.frames();
        Self::new(take, 0..frames, None, false)
    }

    /// The head pose in each inner frame, if the take has head poses.
    pub fn head(&self) -> Option<&[RigidMotion]> {
        self.take.take.head.as_ref().map(|head| &head[self.inner.clone()])
    }
}

/// The first frame whose step is not 1 / `rate`, with that step.
pub fn uneven_step(take: &Take, rate: f64) -> Option<(usize, f64)> {
    let step = take.times.windows(2).map(|w| w[1] - w[0]);
    step.enumerate()
        .map(|(i, step)| (i + 1, step))
        .find(|(_, step)| (step * rate - 1.0).abs() > STEP_TOLERANCE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One marker that moves along x by 1 unit per second.
    fn take(times: &[f64]) -> Take {
        let positions = times.iter().map(|&t| [t, 0.0, 0.0]).collect();
        Take { labels: vec!["a".into()], times: times.to_vec(), positions, ..Take::default() }
    }

    fn even(frames: usize, rate: f64) -> Take {
        take(&(0..frames).map(|i| i as f64 / rate).collect::<Vec<_>>())
    }

    /// A selection without neighbours.
    fn plain(take: Take, range: Range<usize>, fps: Option<f64>) -> Selection {
        let selection = Selection::new(take, range, fps, false).unwrap();
        assert_eq!(selection.inner, 0..selection.take.frames());
        selection
    }

    /// In every selection, frame number / rate is the time, and x is the time.
    fn check_clock(selection: &Selection) {
        for (i, p) in selection.take.take.positions.iter().enumerate() {
            let time = (selection.first as f64 + i as f64 - selection.inner.start as f64) / selection.rate;
            assert!((p[0] - time).abs() < 1e-9, "frame {i}: x = {}, expected {time}", p[0]);
        }
    }

    #[test]
    fn an_even_take_is_only_sliced() {
        let s = plain(even(100, 30.0), 10..20, None);
        assert_eq!((s.take.frames(), s.first, s.rate), (10, 10, 30.0));
        check_clock(&s);
    }

    #[test]
    fn resampling_keeps_the_clock() {
        for (fps, first, frames) in [(60.0, 20, 20), (24.0, 8, 8), (15.0, 5, 5), (25.0, 9, 8)] {
            let s = plain(even(100, 30.0), 10..20, Some(fps));
            assert_eq!((s.first, s.take.frames()), (first, frames), "{fps}");
            check_clock(&s);
        }
    }

    #[test]
    fn the_own_rate_changes_nothing() {
        let own = plain(even(50, 30.0), 0..50, None);
        let asked = plain(even(50, 30.0), 0..50, Some(30.0));
        assert_eq!(own, asked);
    }

    #[test]
    fn an_uneven_take_is_resampled() {
        let times: Vec<f64> = (0..100).filter(|&i| i != 40).map(|i| f64::from(i) / 30.0).collect();
        let s = plain(take(&times), 0..99, None);
        assert_eq!((s.take.frames(), s.rate), (100, 30.0));
        check_clock(&s);
        // Where the range itself is even, nothing is resampled. Frames after the gap still get their right
        // numbers.
        let s = plain(take(&times), 41..50, None);
        assert_eq!((s.first, s.take.frames(), s.take.take.times[0]), (42, 9, times[41]));
        check_clock(&s);
        // The range counts the take's own frames: its row 39 is at time 39/30, its row 50 at 51/30.
        let s = plain(take(&times), 39..50, None);
        assert_eq!((s.first, s.take.frames()), (39, 12));
        check_clock(&s);
    }

    #[test]
    fn neighbours_are_taken_where_there_are_any() {
        for (range, fps, inner, frames) in [
            (10..20, None, 1..11, 12),
            (0..20, None, 0..20, 21),
            (10..100, None, 1..91, 91),
            (0..100, None, 0..100, 100),
            (10..20, Some(15.0), 1..6, 7),
            (0..100, Some(15.0), 0..50, 50),
        ] {
            let s = Selection::new(even(100, 30.0), range, fps, true).unwrap();
            assert_eq!((s.inner.clone(), s.take.frames()), (inner, frames));
            check_clock(&s);
        }
        // A frame across a gap is no neighbour.
        let times: Vec<f64> = (0..100).filter(|&i| i != 40).map(|i| f64::from(i) / 30.0).collect();
        let s = Selection::new(take(&times), 30..40, None, true).unwrap();
        assert_eq!((s.inner, s.take.frames()), (1..11, 11));
        let s = Selection::new(take(&times), 40..50, None, true).unwrap();
        assert_eq!((s.inner, s.take.frames()), (0..10, 11));
    }

    #[test]
    fn ranges_outside_the_take() {
        let range = |start, end| FrameRange { start, end };
        for bad in [range(Some(0), Some(101)), range(Some(100), Some(101)), range(Some(100), None)] {
            let error = bad.within(100).unwrap_err().to_string();
            assert!(error.contains("100 frames"), "{error}");
        }
        assert_eq!(FrameRange::default().within(100).unwrap(), 0..100);
        let error = Selection::new(even(100, 30.0), 1..2, Some(5.0), false).unwrap_err().to_string();
        assert!(error.contains("no frame falls into this range"), "{error}");
    }

    #[test]
    fn a_gap_of_years() {
        let error = Selection::new(take(&[0.0, 0.1, 0.2, 1e9]), 0..4, None, false).unwrap_err().to_string();
        assert!(error.contains("10000000001 frames") && error.contains("check its times"), "{error}");
    }

    #[test]
    fn one_frame() {
        let s = plain(even(1, 30.0), 0..1, None);
        assert_eq!((s.take.frames(), s.first), (1, 0));
    }

    #[test]
    fn frame_ranges() {
        let range = |start, end| Ok(FrameRange { start, end });
        assert_eq!("3..7".parse::<FrameRange>(), range(Some(3), Some(7)));
        assert_eq!("3..".parse::<FrameRange>(), range(Some(3), None));
        assert_eq!("..7".parse::<FrameRange>(), range(None, Some(7)));
        assert_eq!("..".parse::<FrameRange>(), range(None, None));
        for bad in ["", "3", "3-7", "a..b", "-1..3", "7..3", "3..3", "..0", "3...7", "1..2..3", "1.5..2"] {
            assert!(bad.parse::<FrameRange>().is_err(), "{bad}");
        }
    }
}
