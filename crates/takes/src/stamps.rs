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
                "time" | "times" | "t" | "timestamp" | "timestamps" | "seconds" | "sec" | "timesec"
                | "timeseconds" | "timestampsec" | "timestampseconds"
                    if found.time.is_none() =>
                {
                    found.time = Some(column);
                }
                "timems" | "timestampms" | "ms" | "msec" | "millis" | "milliseconds" | "timemilliseconds"
                    if found.time.is_none() =>
                {
                    (found.time, found.unit) = (Some(column), 1e-3);
                }
                "timecode" => found.code = found.code.or(Some(column)),
                _ => {}
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
        let number = |column: usize, what: &str| {
            rows.number(column).filter(|number| number.abs() <= LARGEST).ok_or_else(|| {
                let found = quoted(&String::from_utf8_lossy(rows.cell(column)));
                rows.error(&format!("the {what} is {found}, expected a number"))
            })
        };
        if let Some(column) = self.columns.frame {
            self.frames.push(number(column, "frame")?);
        }
        if let Some(column) = self.columns.time {
            self.times.push(self.columns.unit * number(column, "time")?);
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

/// Times in seconds. Steps as of milliseconds are taken for such, with a warning.
fn seconds(mut times: Vec<f64>, warnings: &mut Vec<String>) -> Vec<f64> {
    /// Steps between frames in milliseconds, from 250 down to 10 frames per second.
    const MILLISECONDS: std::ops::Range<f64> = 3.9..101.0;
    let steps = times.windows(2).map(|pair| pair[1] - pair[0]);
    let fitting = steps.filter(|step| MILLISECONDS.contains(step)).count();
    if times.len() > 10 && fitting * 10 > (times.len() - 1) * 9 {
        warnings.push(
            "the times look like milliseconds and are read as such; give the frame rate if they are not"
                .into(),
        );
        times.iter_mut().for_each(|time| *time *= 1e-3);
    }
    // Seconds since 1970 and the like count from the first frame.
    let first = times.first().copied().filter(|first| first.abs() > 86_400.0).unwrap_or(0.0);
    times.iter_mut().for_each(|time| *time -= first);
    times
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
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    if steps.get(steps.len() / 2).is_some_and(|step| *step >= 0.5) {
        warnings.push(
            "most rows are half a second or more apart, which is slow for a face; give the frame rate if the time \
             codes only count rows"
                .into(),
        );
    }
    times
}
