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
    digits: Option<usize>,
}

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
            if !text.iter().any(|b| matches!(b, b'e' | b'E')) {
                let digits = text.iter().position(|b| *b == b'.').map_or(0, |point| text.len() - point - 1);
                self.digits = Some(self.digits.map_or(digits, |fewest| fewest.min(digits)));
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
        let count = |number: i64| number.saturating_sub(self.zero) as f64;
        let even = |rate: f64| -> Vec<f64> { self.numbers.iter().map(|&n| count(n) / rate).collect() };
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
                // Half of the last digit, and the rounding of the sum.
                let step = 0.5 * 0.1_f64.powi(self.digits.map_or(15, |digits| digits.min(15) as i32));
                let near = |even: &[f64]| {
                    even.iter().zip(times).all(|(a, b)| (a - b).abs() <= 1.001 * step + 1e-12 * b.abs())
                };
                let from_zero = even(rate);
                if near(&from_zero) {
                    return increasing(from_zero);
                }
                // Numbers may continue from another part of the session, while times begin anew.
                let first =
                    (times.first().copied().unwrap_or(0.0), self.numbers.first().copied().unwrap_or(0));
                let from_first: Vec<f64> =
                    self.numbers.iter().map(|&n| first.0 + (n as f64 - first.1 as f64) / rate).collect();
                if near(&from_first) {
                    return increasing(from_first);
                }
                warnings.push(format!(
                    "the times do not match the frames' numbers at {rate} frames per second; the times are \
                     used"
                ));
                Ok(times.clone())
            }
            (None, Some(times)) => {
                warnings.push("there is no frame rate; the column of times is used".into());
                Ok(times.clone())
            }
            (None, None) => Err(no_rate()),
        }
    }
}

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
