//! When the rows of a table are: columns of frames, times or time codes.
use crate::raw_take::clock::no_rate;
use crate::tables::rows::Rows;
use crate::timecode::{self, Timecode};
use rhytid_core::text::quoted;
use rhytid_core::{Error, Result, Take};

/// No frame and no time is beyond this. Nanoseconds since 1970 are within it.
const LARGEST: f64 = 1e19;

/// Which columns say when a row is.
#[derive(Debug, Clone, Default)]
pub(crate) struct StampColumns {
    /// The frame's number.
    pub(crate) frame: Option<usize>,
    time: Option<usize>,
    code: Option<usize>,
    /// The length of a unit of the times in seconds.
    unit: f64,
}

impl StampColumns {
    /// Finds the columns by their names in any spelling. The first of a kind counts.
    pub(crate) fn of(header: &[String]) -> Self {
        let mut found = Self { unit: 1.0, ..Self::default() };
        for (column, cell) in header.iter().enumerate() {
            let name: String = cell.chars().filter(|c| c.is_alphanumeric()).collect();
            match name.to_lowercase().as_str() {
                "frame" | "frames" | "framenumber" | "frameno" | "framenum" | "frameindex" | "frameidx"
                | "frameid" => {
                    found.frame = found.frame.or(Some(column));
                }
                "timecode" => found.code = found.code.or(Some(column)),
                name => {
                    if let Some(unit) = time_unit(name).filter(|_| found.time.is_none()) {
                        (found.time, found.unit) = (Some(column), unit);
                    }
                }
            }
        }
        found
    }

    /// Whether `column` is one of them.
    pub(crate) fn has(&self, column: usize) -> bool {
        [self.frame, self.time, self.code].contains(&Some(column))
    }

    /// Whether there is any.
    pub(crate) fn any(&self) -> bool {
        self.frame.or(self.time).or(self.code).is_some()
    }

    /// The column that tells the frames apart.
    pub(crate) fn key(&self) -> Option<usize> {
        self.frame.or(self.time).or(self.code)
    }
}

/// The seconds in a unit of a column of times, by the column's name in small letters; `None` for another
/// column.
fn time_unit(name: &str) -> Option<f64> {
    const TIMES: [&str; 3] = ["timestamp", "time", "t"];
    const UNITS: [(&[&str], f64); 4] = [
        (&["s", "sec", "secs", "second", "seconds"], 1.0),
        (&["ms", "msec", "msecs", "millis", "millisecond", "milliseconds"], 1e-3),
        (&["us", "µs", "μs", "usec", "usecs", "micros", "microsecond", "microseconds"], 1e-6),
        (&["ns", "nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"], 1e-9),
    ];
    let time = TIMES.into_iter().find(|time| name.starts_with(time)).unwrap_or_default();
    let unit = &name[time.len()..];
    if !time.is_empty() && unit.is_empty() {
        return Some(1.0);
    }
    // A column called `s` alone may be anything.
    if unit.chars().count() < 2 && time.is_empty() {
        return None;
    }
    UNITS.into_iter().find(|(names, _)| names.contains(&unit)).map(|(_, seconds)| seconds)
}

/// What the rows say of their time.
pub(crate) struct Stamps {
    columns: StampColumns,
    /// One element a row in each; empty where there is no such column.
    frames: Vec<f64>,
    times: Vec<f64>,
    codes: Vec<Timecode>,
    rows: usize,
}

/// The times of frames.
#[derive(Debug, PartialEq)]
pub(crate) struct Times {
    /// In seconds, strictly increasing.
    pub(crate) times: Vec<f64>,
    /// The row of each.
    pub(crate) kept: Vec<usize>,
}

impl Stamps {
    pub(crate) fn new(columns: StampColumns) -> Self {
        Self { columns, frames: Vec::new(), times: Vec::new(), codes: Vec::new(), rows: 0 }
    }

    /// Takes the current row.
    ///
    /// # Errors
    /// [`Error::Input`] if a cell is no number or no time code.
    pub(crate) fn push(&mut self, rows: &Rows<'_>) -> Result<()> {
        let number = |column: usize, what: &str, expected: &str| {
            rows.number(column).filter(|number| number.abs() <= LARGEST).ok_or_else(|| {
                let found = quoted(&String::from_utf8_lossy(rows.cell(column)));
                rows.error(&format!("the {what} is {found}, expected {expected}"))
            })
        };
        if let Some(column) = self.columns.frame {
            self.frames.push(number(column, "frame", "a number")?);
        }
        if let Some(column) = self.columns.time {
            const EXPECTED: &str =
                "a number of seconds; times such as 10:00:00.5 need the column's name timecode";
            self.times.push(self.columns.unit * number(column, "time", EXPECTED)?);
        }
        if let Some(column) = self.columns.code {
            let code = Timecode::parse(rows.text(column)?).ok_or_else(|| {
                let found = quoted(&String::from_utf8_lossy(rows.cell(column)));
                rows.error(&format!("the time code is {found}, expected HH:MM:SS:FF or a number of seconds"))
            })?;
            self.codes.push(code);
        }
        self.rows += 1;
        Ok(())
    }

    /// Sorts the rows by their frames, or else by their times. Returns the old place of each row.
    pub(crate) fn sort(&mut self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.rows).collect();
        let keys = if self.frames.is_empty() { self.times.clone() } else { self.frames.clone() };
        if !keys.is_empty() {
            order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
        }
        for column in [&mut self.frames, &mut self.times] {
            if !column.is_empty() {
                *column = order.iter().map(|&row| column[row]).collect();
            }
        }
        if !self.codes.is_empty() {
            self.codes = order.iter().map(|&row| self.codes[row]).collect();
        }
        order
    }

    /// The times of the rows. A row that is not later than the one before it is left out, with a warning.
    /// A `rate`, in frames per second, replaces times and time codes.
    ///
    /// # Errors
    /// [`Error::Input`], without the file's name: neither times nor a rate, or times that hardly ever
    /// increase.
    pub(crate) fn times(self, rate: Option<f64>, warnings: &mut Vec<String>) -> Result<Times> {
        let times = match rate {
            Some(rate) => self.counted(rate),
            None if !self.times.is_empty() => even(seconds(self.times, warnings), &self.frames),
            None if !self.codes.is_empty() => of_codes(&self.codes, warnings),
            None => return Err(no_rate()),
        };
        if rate.is_none() {
            warn_if_slow(&times, warnings);
        }
        let mut kept: Vec<usize> = Vec::with_capacity(times.len());
        for row in 0..times.len() {
            if kept.last().is_none_or(|&last| times[row] > times[last]) {
                kept.push(row);
            }
        }
        let dropped = times.len() - kept.len();
        if 2 * dropped > times.len() {
            return Err(Error::malformed(format!(
                "has times that do not increase from row to row in {dropped} of {} rows; give the frame rate, or \
                 export the file anew",
                times.len()
            ))
            .with_remedies(&[rhytid_core::Remedy::GiveRate]));
        }
        if dropped > 0 {
            warnings.push(format!(
                "{dropped} of {} rows are not later than the row before them, and are left out",
                times.len()
            ));
        }
        Ok(Times { times: kept.iter().map(|&row| times[row]).collect(), kept })
    }

    /// Times from the frames' numbers, or from the rows where these do not increase.
    fn counted(&self, rate: f64) -> Vec<f64> {
        let rising = self.frames.windows(2).all(|pair| pair[0] < pair[1]);
        match self.frames.first() {
            Some(first) if rising => self.frames.iter().map(|frame| (frame - first) / rate).collect(),
            _ => (0..self.rows).map(|row| row as f64 / rate).collect(),
        }
    }
}

/// Times in seconds. Steps as of milliseconds, microseconds or nanoseconds are taken for such, with a
/// warning.
fn seconds(mut times: Vec<f64>, warnings: &mut Vec<String>) -> Vec<f64> {
    /// Seconds between frames, from 250 down to 10 frames per second.
    const STEPS: std::ops::Range<f64> = 3.9e-3..0.101;
    const UNITS: [(f64, &str); 3] = [(1e-3, "milliseconds"), (1e-6, "microseconds"), (1e-9, "nanoseconds")];
    let fits = |unit: f64| {
        let steps = times.windows(2).map(|pair| unit * (pair[1] - pair[0]));
        let fitting = steps.filter(|step| STEPS.contains(step)).count();
        times.len() > 10 && fitting * 10 > (times.len() - 1) * 9
    };
    let mut unit = 1.0;
    if let Some((smaller, name)) = UNITS.into_iter().find(|(unit, _)| fits(*unit)) {
        warnings.push(format!(
            "the times look like {name} and are read as such; give the frame rate if they are not"
        ));
        unit = smaller;
    }
    // Seconds since 1970 and the like count from the first frame.
    let first = times.first().copied().filter(|first| (unit * first).abs() > 86_400.0).unwrap_or(0.0);
    times.iter_mut().for_each(|time| *time = unit * (*time - first));
    times
}

/// Warns if most rows are far apart: their times may have another unit, or time codes may only count rows.
fn warn_if_slow(times: &[f64], warnings: &mut Vec<String>) {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    if steps.get(steps.len() / 2).is_some_and(|step| *step >= 0.5) {
        warnings.push(
            "most rows are half a second or more apart, which is slow for a face; give the frame rate if the times \
             are wrong"
                .into(),
        );
    }
}

/// Times that are even but for their rounding to milliseconds, without the rounding. `frames` are the frames'
/// numbers, if there are any.
fn even(times: Vec<f64>, frames: &[f64]) -> Vec<f64> {
    /// Half a millisecond, and the rounding of the first time.
    const ROUNDING: f64 = 1.01e-3;
    let rate = Take { times: times.clone(), ..Take::default() }.rate();
    let rising = frames.len() == times.len() && frames.windows(2).all(|pair| pair[0] < pair[1]);
    let number = |row: usize| if rising { frames[row] - frames[0] } else { row as f64 };
    let exact: Vec<f64> = (0..times.len()).map(|row| times[0] + number(row) / rate).collect();
    let is_near = exact.iter().zip(&times).all(|(exact, time)| (exact - time).abs() <= ROUNDING);
    if is_near && ROUNDING * rate < 0.25 { exact } else { times }
}

fn of_codes(codes: &[Timecode], warnings: &mut Vec<String>) -> Vec<f64> {
    let timecode::Times { times, rate, is_sure } = timecode::times(codes);
    if let Some(rate) = rate.filter(|_| !is_sure) {
        warnings.push(format!(
            "the time codes do not show a whole second, so that they are taken to count {rate} frames a second; give \
             the frame rate if they do not"
        ));
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_times_say_their_unit() {
        for (name, expected) in [
            ("time", Some(1.0)),
            ("t", Some(1.0)),
            ("timestamps", Some(1.0)),
            ("timesec", Some(1.0)),
            ("seconds", Some(1.0)),
            ("timems", Some(1e-3)),
            ("ms", Some(1e-3)),
            ("timestampus", Some(1e-6)),
            ("timeµs", Some(1e-6)),
            ("timestampns", Some(1e-9)),
            ("nanoseconds", Some(1e-9)),
            ("s", None),
            ("timeout", None),
            ("tongueout", None),
            ("", None),
        ] {
            assert_eq!(time_unit(name), expected, "{name}");
        }
    }

    #[test]
    fn times_of_another_unit_are_taken_for_such() {
        // 30 frames per second since 1970, and the same in smaller units.
        for (unit, name) in [(1e-3, "milliseconds"), (1e-6, "microseconds"), (1e-9, "nanoseconds")] {
            let mut warnings = Vec::new();
            let times = (0..30).map(|i| ((1.7e9 + f64::from(i) / 30.0) / unit).round()).collect();
            let found = seconds(times, &mut warnings);
            assert!((found[29] - 29.0 / 30.0).abs() < 2e-3 && found[0] == 0.0, "{name}: {found:?}");
            assert!(warnings.len() == 1 && warnings[0].contains(name), "{warnings:?}");
            warn_if_slow(&found, &mut warnings);
            assert_eq!(warnings.len(), 1);
        }
        // What is taken for nothing else is told: steps of 2 ms in a column of seconds.
        let mut warnings = Vec::new();
        let slow = seconds((0..30).map(|i| 2.0 * f64::from(i)).collect(), &mut warnings);
        assert_eq!(warnings, [""; 0]);
        warn_if_slow(&slow, &mut warnings);
        assert!(warnings[0].contains("half a second or more apart"), "{warnings:?}");
    }
}
