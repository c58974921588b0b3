//! The times of frames: the sender's, or those of arrival where the sender's cannot be seconds.

use crate::part::Stamp;
use crate::warnings::{About, Warnings};
use std::ops::Range;

/// A step of the sender's time is odd if it is longer than this, in seconds, …
const LONG: f64 = 0.5;
/// … and so many times longer than the time between the arrivals.
const FASTER: f64 = 20.0;
/// So many odd steps show the unit.
const ENOUGH: u32 = 8;
/// A step without time counts as much as so many steps with time.
const STILL: u32 = 8;
/// Units that are taken for seconds: what they are called, and how many make a second.
const UNITS: [Unit; 3] = [
    Unit { name: "milliseconds", a_second: 1e3 },
    Unit { name: "microseconds", a_second: 1e6 },
    Unit { name: "nanoseconds", a_second: 1e9 },
];
/// Seconds since 1970 are in this range, from 2001 to 2286.
const SINCE_1970: Range<f64> = 1e9..1e10;
/// The least step between two frames, in seconds.
const LEAST_STEP: f64 = 1e-6;
/// A 32-bit float is too coarse if its steps are longer than this, in seconds.
const COARSE: f64 = 0.5e-3;

#[derive(Debug, Clone, Copy)]
struct Unit {
    name: &'static str,
    a_second: f64,
}

/// Whose clock gives the times.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// The sender's, whose times are divided by this number.
    Sender(f64),
    /// This machine's.
    Arrival,
}

/// The last frame.
#[derive(Debug, Clone, Copy)]
struct Last {
    seconds: f64,
    arrived: f64,
    time: f64,
}

/// Makes times in seconds that only rise.
#[derive(Debug)]
pub(crate) struct Clock {
    source: Source,
    /// What is added to the source's time.
    offset: f64,
    last: Option<Last>,
    /// The frame before the first odd step, and the number of odd steps.
    odd: Option<(Last, u32)>,
    /// [`STILL`] for each step without time, less 1 for each step with time.
    still: u32,
}

impl Default for Clock {
    fn default() -> Self {
        Self { source: Source::Sender(1.0), offset: 0.0, last: None, odd: None, still: 0 }
    }
}

impl Clock {
    /// The time of a frame that came at `arrived`. `stamp` is what its sender says, and `is_anew` whether a
    /// sender begins with it.
    pub(crate) fn time(
        &mut self,
        stamp: Option<Stamp>,
        arrived: f64,
        is_anew: bool,
        warnings: &mut Warnings,
    ) -> f64 {
        if is_anew || self.last.is_none() {
            (self.source, self.odd, self.still) = (first_source(stamp, warnings), None, 0);
        }
        let seconds = stamp.map_or(arrived, |stamp| stamp.seconds);
        let Some(last) = self.last else {
            let raw = self.raw(seconds, arrived);
            // A number that cannot be seconds is too large for fractions of seconds.
            self.offset = if raw.abs() < SINCE_1970.end { 0.0 } else { -raw };
            let time = raw + self.offset;
            self.last = Some(Last { seconds, arrived, time });
            return time;
        };
        let elapsed = (arrived - last.arrived).max(LEAST_STEP);
        let mut time = self.raw(seconds, arrived) + self.offset;
        let mut begins_anew = is_anew;
        if is_anew {
            time = last.time + elapsed;
        } else if let Source::Sender(_) = self.source {
            if seconds == last.seconds {
                begins_anew = self.stands_still(seconds, warnings);
                time = last.time + elapsed;
            } else if time - last.time > LONG.max(FASTER * elapsed) {
                begins_anew = true;
                time = self.after_odd_step(last, seconds, arrived, warnings);
            } else {
                self.still = self.still.saturating_sub(1);
            }
        }
        time = time.max(last.time + LEAST_STEP);
        if begins_anew {
            self.offset = time - self.raw(seconds, arrived);
        }
        self.last = Some(Last { seconds, arrived, time });
        time
    }

    /// Counts a step without time. After a few, this machine's clock counts, and the result is true.
    ///
    /// A single such step is no fault: a sender may round its times, or give its first frame twice.
    fn stands_still(&mut self, seconds: f64, warnings: &mut Warnings) -> bool {
        self.still += STILL;
        if self.still < ENOUGH * STILL {
            return false;
        }
        warnings.say(About::StillTimes, || {
            format!(
                "the time of the frames stays {seconds} from one frame to the next, so frames get the times \
                 of their arrival; send each frame's time in seconds in {FRAME_MESSAGE}"
            )
        });
        self.source = Source::Arrival;
        true
    }

    /// The time of the source, without the offset.
    fn raw(&self, seconds: f64, arrived: f64) -> f64 {
        match self.source {
            Source::Sender(a_second) => seconds / a_second,
            Source::Arrival => arrived,
        }
    }

    /// The time of a frame that is much later by the sender's clock than by this machine's. Until the unit is
    /// known, this machine's counts.
    fn after_odd_step(&mut self, last: Last, seconds: f64, arrived: f64, warnings: &mut Warnings) -> f64 {
        let (first, steps) = self.odd.map_or((last, 1), |(first, steps)| (first, steps + 1));
        self.odd = Some((first, steps));
        let elapsed = (arrived - last.arrived).max(LEAST_STEP);
        if steps < ENOUGH {
            return last.time + elapsed;
        }
        let ratio = (seconds - first.seconds) / (arrived - first.arrived).max(LEAST_STEP);
        if ratio < FASTER {
            // A few leaps of a sender whose clock keeps pace, such as one that plays a take and skips parts.
            self.odd = None;
            return last.time + elapsed;
        }
        if let Some(unit) = UNITS.iter().find(|unit| (0.5..2.0).contains(&(ratio / unit.a_second))) {
            // A time that looked like one since 1970 may be another.
            let about = if self.source == Source::Sender(1.0) { About::Unit } else { About::OtherUnit };
            say_unit(about, unit, warnings);
            self.source = Source::Sender(unit.a_second);
            return last.time + (seconds - last.seconds) / unit.a_second;
        }
        warnings.say(About::Unit, || {
            format!(
                "the times of the frames run {ratio:.0} times as fast as this machine's clock, so frames get \
                 the times of their arrival; send each frame's time in seconds in {FRAME_MESSAGE}"
            )
        });
        self.source = Source::Arrival;
        last.time + elapsed
    }
}

const FRAME_MESSAGE: &str = "/rhytid/frame NUMBER SECONDS";

fn say_unit(about: About, unit: &Unit, warnings: &mut Warnings) {
    warnings.say(about, || {
        format!(
            "the times of the frames are {}, expected seconds, so they are divided by {}; send seconds in \
             {FRAME_MESSAGE}",
            unit.name, unit.a_second
        )
    });
}

/// The source for a sender's first frame.
fn first_source(stamp: Option<Stamp>, warnings: &mut Warnings) -> Source {
    let Some(Stamp { seconds, is_float, .. }) = stamp else { return Source::Arrival };
    let unit = UNITS.iter().find(|unit| SINCE_1970.contains(&(seconds / unit.a_second)));
    let a_second = unit.map_or(1.0, |unit| unit.a_second);
    let float = seconds as f32;
    let step = f64::from(float.abs().next_up() - float.abs()) / a_second;
    if is_float && step > COARSE {
        warnings.say(About::Coarse, || {
            format!(
                "the time of the frames is a 32-bit float, which has steps of {} s at {seconds}, so frames \
                 get the times of their arrival; send the time as a double (d), or from the start of the take",
                rhytid_core::human::number(step)
            )
        });
        return Source::Arrival;
    }
    if let Some(unit) = unit {
        say_unit(About::Unit, unit, warnings);
    }
    Source::Sender(a_second)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(seconds: f64, is_float: bool) -> Option<Stamp> {
        Some(Stamp { number: 0, seconds, is_float })
    }

    /// The times of 40 frames at 100 Hz, and what was said. `seconds` is what the sender says at a time.
    fn times(is_float: bool, seconds: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<String>) {
        let (mut clock, mut warnings) = (Clock::default(), Warnings::default());
        let times = (0..40).map(|i| {
            let t = f64::from(i) * 0.01;
            // Frames come up to 3 ms late.
            let arrived = 5.0 + t + 0.003 * f64::from(i * 7 % 5) / 5.0;
            clock.time(stamp(seconds(t), is_float), arrived, false, &mut warnings)
        });
        (times.collect(), warnings.sentences)
    }

    fn are_even(times: &[f64], within: f64) {
        for pair in times.windows(2) {
            assert!((pair[1] - pair[0] - 0.01).abs() < within, "{pair:?} in {times:?}");
        }
    }

    #[test]
    fn seconds_are_kept_to_the_bit() {
        let (found, said) = times(false, |t| 1.76e9 + t);
        assert_eq!(found, (0..40).map(|i| 1.76e9 + f64::from(i) * 0.01).collect::<Vec<_>>());
        assert!(said.is_empty(), "{said:?}");
    }

    #[test]
    fn other_units_are_named_and_divided() {
        for (unit, a_second) in [("milliseconds", 1e3), ("microseconds", 1e6), ("nanoseconds", 1e9)] {
            for since in [0.0, 86_400.0, 1.76e9] {
                // Ten milliseconds as 10 s are a plausible step, so the rate is higher here.
                let (mut clock, mut warnings) = (Clock::default(), Warnings::default());
                let at = |i: i32| since + f64::from(i) / 100.0;
                let found: Vec<f64> = (0..40)
                    .map(|i| {
                        let arrived = at(i) - since + 0.002 * f64::from(i * 7 % 5) / 5.0;
                        clock.time(stamp(at(i) * a_second, false), arrived, false, &mut warnings)
                    })
                    .collect();
                are_even(&found, 3e-3);
                are_even(&found[10..], 1e-6);
                assert_eq!(warnings.sentences.len(), 1);
                assert!(warnings.sentences[0].contains(unit), "{:?}", warnings.sentences);
            }
        }
    }

    #[test]
    fn times_that_cannot_be_seconds_are_those_of_arrival() {
        let coarse = |t: f64| f64::from((1.76e9 + t) as f32);
        for (is_float, seconds, words) in [
            (true, &coarse as &dyn Fn(f64) -> f64, "32-bit float"),
            (false, &|_| 0.0, "stays 0 from one frame to the next"),
            (false, &|t| 60_000.0 * t, "times as fast as this machine's clock"),
        ] {
            let (found, said) = times(is_float, seconds);
            are_even(&found, 4e-3);
            assert!(said.len() == 1 && said[0].contains(words), "{said:?}");
        }
        // A float is fine from the start of a take, and a gap or a slow sender is no other unit.
        let (found, said) = times(true, |t| t + 3.0);
        assert!(said.is_empty() && (found[39] - 3.39).abs() < 1e-9);
        let (mut clock, mut warnings) = (Clock::default(), Warnings::default());
        for (seconds, arrived) in [(0.0, 0.0), (0.01, 0.01), (2.0, 2.01), (12.0, 12.0), (22.0, 22.5)] {
            assert_eq!(clock.time(stamp(seconds, false), arrived, false, &mut warnings), seconds);
        }
        assert!(warnings.sentences.is_empty());
    }
    /// A first frame that comes twice is no fault. Times that are rounded to hundredths do not run away.
    #[test]
    fn a_time_that_comes_twice_is_no_still_clock() {
        let (found, said) = times(false, |t| (t - 0.01).max(0.0));
        assert!(said.is_empty(), "{said:?}");
        // The arrival of the second frame is its time, and the sender's clock counts again from then on.
        are_even(&found[3..], 1e-9);
        assert!(found[1] > 0.005 && found[39] == 0.38, "{found:?}");
        // 120 frames a second: each fifth step has no time, but the times do not run away.
        let (mut clock, mut warnings) = (Clock::default(), Warnings::default());
        for i in 0..1_000 {
            let t = f64::from(i) / 120.0;
            let time = clock.time(stamp((t * 100.0).round() / 100.0, false), t, false, &mut warnings);
            assert!((time - t).abs() < 0.02, "{i}: {time} at {t}");
        }
    }

    #[test]
    fn a_sender_that_leaps_now_and_then_keeps_its_clock() {
        let (mut clock, mut warnings) = (Clock::default(), Warnings::default());
        let mut last = 0.0;
        for i in 0..2_000 {
            let t = f64::from(i) * 0.01;
            // It skips ten seconds each hundred frames.
            let time = clock.time(stamp(t + 10.0 * (t / 1.0).floor(), false), t, false, &mut warnings);
            assert!(i == 0 || (time - last - 0.01).abs() < 1e-6, "{i}: {last} {time}");
            last = time;
        }
        assert!(warnings.sentences.is_empty(), "{:?}", warnings.sentences);
    }
}
