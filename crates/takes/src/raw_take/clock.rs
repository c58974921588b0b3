//! The times of a file's frames: from the frames' numbers and the rate, or from a column of rounded times.
use crate::tables::rows::Rows;
use rhytid_core::text::quoted;
use rhytid_core::{Error, Remedy, Result};

/// The message for a file without a rate, without the file's name.
pub(crate) fn no_rate() -> Error {
    Error::no_frame_rate("gives no frame rate; give it with the file, or as `rate` in the take's TOML file")
        .with_remedies(&[Remedy::GiveRate])
}

/// Whether a number is fit to be frames per second.
pub(super) fn is_rate(rate: f64) -> bool {
    (1e-3..=1e6).contains(&rate)
}

/// Collects the statements about time in the rows of a text file.
#[derive(Default)]
pub(super) struct Clock {
    /// The number that the frame at time 0 has.
    zero: i64,
    /// Each row's number; empty where rows have none.
    numbers: Vec<i64>,
    /// Each row's seconds; empty where rows have none.
    times: Vec<f64>,
    /// The fewest digits behind the point that a time has.
    printed: Option<usize>,
    /// The most digits behind the point that a time needs: without zeros at its end.
    needed: usize,
}

/// With fewer times than these, zeros at the ends of all of them may be chance.
const ENOUGH_TIMES: usize = 10;

impl Clock {
    /// Frames count from `zero`.
    pub(super) fn from_frame(zero: i64) -> Self {
        Self { zero, ..Self::default() }
    }

    /// Takes the frame's number and its seconds from the cells of the current row, if the columns exist. A
    /// column with an empty cell in any row is ignored.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] for cells that hold no numbers.
    pub(super) fn push(&mut self, rows: &Rows<'_>, number: Option<usize>, time: Option<usize>) -> Result<()> {
        if let Some(number) = cell(rows, number, "the frame's number")? {
            // Some programs write whole numbers with digits behind the point.
            self.numbers.push(number as i64);
        }
        if let Some(seconds) = cell(rows, time, "the time")? {
            self.times.push(seconds);
            let text = time.map_or(&b""[..], |time| rows.cell(time));
            // With an exponent, the digits say less. Then the number counts as having all of its digits.
            if text.iter().any(|b| matches!(b, b'e' | b'E')) {
                self.needed = MOST_DIGITS;
            } else {
                let behind =
                    text.iter().position(|b| *b == b'.').map_or(&b""[..], |point| &text[point + 1..]);
                let zeros = behind.iter().rev().take_while(|b| **b == b'0').count();
                self.needed = self.needed.max(behind.len() - zeros);
                self.printed = Some(self.printed.map_or(behind.len(), |fewest| fewest.min(behind.len())));
            }
        }
        Ok(())
    }

    /// Forgets all but the first `frames` frames.
    pub(super) fn truncate(&mut self, frames: usize) {
        self.numbers.truncate(frames);
        self.times.truncate(frames);
    }

    /// The time of each of `frames` frames, in seconds, strictly increasing. Times come from the frames'
    /// numbers and the rate, which have no rounding, unless the file's own times contradict them. If a rate
    /// is `given`, times come from that rate alone.
    ///
    /// # Errors
    /// [`Error::Input`], without the file's name, if neither a rate nor times are known.
    pub(super) fn times(
        mut self,
        frames: usize,
        given: Option<f64>,
        said: Option<f64>,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<f64>> {
        let rising = self.numbers.windows(2).all(|pair| pair[0] < pair[1]);
        if self.numbers.len() != frames || !rising {
            if !self.numbers.is_empty() {
                warnings.push(
                    "the frames' numbers do not increase from row to row; rows are counted instead".into(),
                );
            }
            self.numbers = (self.zero..).take(frames).collect();
        }
        let first = self.numbers.first().copied().unwrap_or(self.zero);
        // A format that counts from 1 has no frame 0, unless the file counts from 0.
        let zero = self.zero.min(first.max(0));
        let even = |rate: f64| self.even(zero, 0.0, rate);
        if let Some(rate) = given {
            return increasing(even(rate));
        }
        let rate = said.filter(|&rate| is_rate(rate));
        let times = (self.times.len() == frames).then_some(&self.times);
        let times = times.filter(|times| times.windows(2).all(|pair| pair[0] < pair[1]));
        match (rate, times) {
            (Some(rate), None) => {
                if !self.times.is_empty() {
                    warnings.push(format!(
                        "the times do not increase from row to row; the frame rate of {rate} is used instead"
                    ));
                }
                increasing(even(rate))
            }
            (Some(rate), Some(times)) => {
                if let Some(even) = self.agreeing(zero, rate, times) {
                    return increasing(even);
                }
                warnings.push(format!(
                    "the times do not match the frames' numbers at {rate} frames per second; the times are used, \
                     {}",
                    self.rate_of(times)
                ));
                Ok(self.without_rounding(times))
            }
            (None, Some(times)) => {
                warnings.push(format!("there is no frame rate; the times are used, {}", self.rate_of(times)));
                Ok(self.without_rounding(times))
            }
            (None, None) => Err(no_rate()),
        }
    }

    /// The times of the frames' numbers at a rate, if the frame `zero` comes at `start`.
    fn even(&self, zero: i64, start: f64, rate: f64) -> Vec<f64> {
        self.numbers.iter().map(|&number| start + number.saturating_sub(zero) as f64 / rate).collect()
    }

    /// The most that rounding moves a time. Zeros at the ends of all times say that they were rounded before
    /// they were printed.
    fn rounding(&self) -> f64 {
        let printed = self.printed.unwrap_or(MOST_DIGITS);
        let digits = if self.times.len() < ENOUGH_TIMES { printed } else { printed.min(self.needed) };
        0.5 * 0.1_f64.powi(digits.min(MOST_DIGITS) as i32)
    }

    /// The times of the frames' numbers at `rate`, unless the column of times contradicts them. Numbers may
    /// continue from another part of the session, and times begin anew, or the other way round.
    fn agreeing(&self, zero: i64, rate: f64, times: &[f64]) -> Option<Vec<f64>> {
        let rounding = self.rounding();
        // Programs that compute in single precision print its error.
        let near = |even: &[f64], most: f64| {
            let mut pairs = even.iter().zip(times);
            pairs.all(|(a, b)| (a - b).abs() <= 1.001 * most + f64::from(f32::EPSILON) * b.abs())
        };
        for zero in [zero, 0, 1] {
            let even = self.even(zero, 0.0, rate);
            if near(&even, rounding) {
                return Some(even);
            }
        }
        let (&first, &number) = times.first().zip(self.numbers.first())?;
        let from_first = self.even(number, first, rate);
        // The first time is rounded too.
        if near(&from_first, 2.0 * rounding) {
            return Some(from_first);
        }
        // A system's clock trembles. Only what it adds up to, or a step of another length, contradicts.
        let (&last, &end) = times.last().zip(from_first.last())?;
        let steps = times.windows(2).zip(from_first.windows(2));
        let is_even = steps
            .map(|(found, even)| (found[1] - found[0]) - (even[1] - even[0]))
            .all(|difference| difference.abs() <= 0.5 / rate + 2.0 * rounding);
        let drift = (last - end).abs();
        (is_even && drift <= 1.0 / rate && drift <= MOST_DRIFT * (end - first)).then_some(from_first)
    }

    /// Even times instead of rounded ones, if they are even but for the rounding.
    fn without_rounding(&self, times: &[f64]) -> Vec<f64> {
        let Some(rate) = self.fitted(times) else { return times.to_vec() };
        let even = self.even(self.numbers[0], times[0], rate);
        increasing(even).unwrap_or_else(|_| times.to_vec())
    }

    /// The rate of even times, with as few digits as their rounding allows.
    fn fitted(&self, times: &[f64]) -> Option<f64> {
        let (&first, &last) = times.first().zip(times.last())?;
        let (&from, &to) = self.numbers.first().zip(self.numbers.last())?;
        let (frames, rounding) = (to.saturating_sub(from) as f64, self.rounding());
        let rate = frames / (last - first);
        if times.len() < ENOUGH_TIMES || !is_rate(rate) || last - first <= 4.0 * rounding {
            return None;
        }
        let fits = |rate: f64| {
            let even = self.even(from, first, rate);
            even.iter().zip(times).all(|(a, b)| (a - b).abs() <= 2.002 * rounding)
        };
        let shorter = (0..=3).map(|digits| 10f64.powi(digits)).map(|tens| (rate * tens).round() / tens);
        shorter.chain([rate]).find(|&rate| is_rate(rate) && fits(rate))
    }

    /// What the times say of the rate, in words.
    fn rate_of(&self, times: &[f64]) -> String {
        match self.fitted(times) {
            Some(rate) => format!("which give {} frames per second", (rate * 1e3).round() / 1e3),
            None => "as they are; if that is wrong, give the rate".into(),
        }
    }
}

/// The digits behind the point of a number that is not rounded.
const MOST_DIGITS: usize = 15;

/// The largest part of the take's length by which a rate may be wrong, in times too short to show a frame.
const MOST_DRIFT: f64 = 0.01;

/// Frame numbers too large for floats to tell apart give equal times.
fn increasing(times: Vec<f64>) -> Result<Vec<f64>> {
    if times.windows(2).all(|pair| pair[0] < pair[1]) {
        Ok(times)
    } else {
        Err(Error::out_of_range(
            "has frame numbers too large to tell their times apart; export the file anew",
        ))
    }
}

/// The number of a cell; `None` where there is no such column or the cell is empty.
fn cell(rows: &Rows<'_>, column: Option<usize>, what: &str) -> Result<Option<f64>> {
    let text = column.map_or(&b""[..], |column| rows.cell(column));
    if text.is_empty() {
        return Ok(None);
    }
    let number = std::str::from_utf8(text).ok().and_then(|text| text.parse::<f64>().ok());
    number.filter(|number| number.is_finite()).map(Some).ok_or_else(|| {
        let found = quoted(&String::from_utf8_lossy(text));
        rows.error(&format!("{what} is {found}, expected a number with a decimal point"))
    })
}
