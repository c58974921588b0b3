//! Positions from the rows of a text file.
use crate::tables::rows::Rows;
use crate::text::says_missing;
use rhytid_core::text::quoted;
use rhytid_core::{Error, RawTake, Result};

/// Which columns of a file make a frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Columns {
    /// The frame's number.
    pub(super) number: Option<usize>,
    /// The frame's seconds.
    pub(super) time: Option<usize>,
    /// Each marker's x; y and z follow it.
    pub(super) markers: Vec<usize>,
    /// Whether columns behind the last marker's hold other data and are no mistake.
    pub(super) others_follow: bool,
    /// Whether blanks lie between the cells. Then no cell can be empty.
    pub(super) has_blanks: bool,
}

/// Gathers frames of markers.
pub(super) struct Samples {
    columns: Columns,
    /// The number of cells of a row that are read.
    end: usize,
    /// The most positions that a file of this size can hold.
    most: usize,
    positions: Vec<[f64; 3]>,
}

impl Samples {
    /// For a file of `bytes` bytes.
    pub(super) fn new(columns: Columns, bytes: usize) -> Self {
        let end = columns.markers.iter().map(|x| x + 3).max().unwrap_or(0);
        // In a whole row, a marker takes at least three bytes: its separators. Rows that are cut off behind
        // their last value have fewer.
        Self { columns, end, most: bytes / 2, positions: Vec::new() }
    }

    /// Whether the current row is a frame. A row of empty cells is no frame, unless rows have nothing but
    /// markers.
    pub(super) fn is_frame(&self, rows: &Rows<'_>) -> bool {
        let whole = self.columns.number.is_none() && self.columns.time.is_none() && rows.width() >= self.end;
        whole || (0..rows.width()).any(|column| !rows.cell(column).is_empty())
    }

    /// Why the current row lacks cells that cannot be empty; `None` where no cell is missing.
    pub(super) fn lacks_cells(&self, rows: &Rows<'_>) -> Option<Error> {
        (self.columns.has_blanks && rows.width() < self.end).then(|| {
            rows.error(&format!(
                "the row has {} cells, expected {} for the {} markers; where blanks lie between cells, a marker that \
                 was not seen cannot be left out; write NaN for it, or put tabs between the cells",
                rows.width(),
                self.end,
                self.columns.markers.len()
            ))
        })
    }

    /// Adds the current row as a frame. A marker is missing if it has an empty cell, a cell that says that it
    /// is no number, or cells beyond the end of the row.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`]: a cell that is neither empty nor a number, or one that belongs to no
    /// marker. Also rows far shorter than the header, with which the take would be out of proportion to the
    /// file.
    pub(super) fn push(&mut self, rows: &Rows<'_>) -> Result<()> {
        let markers = &self.columns.markers;
        if self.positions.len() + markers.len() > self.most {
            return Err(rows.error(&format!(
                "the rows are far shorter than the header, which has {} markers; the file may be damaged",
                markers.len()
            )));
        }
        let strange = (self.end..rows.width()).find(|&column| !rows.cell(column).is_empty());
        if let Some(column) = strange.filter(|_| !self.columns.others_follow) {
            return Err(rows.error(&format!(
                "cell {} is {}, expected nothing behind the {} cells of the {} markers; the header may be damaged",
                column + 1,
                quoted(&String::from_utf8_lossy(rows.cell(column))),
                self.end,
                markers.len()
            )));
        }
        for &column in markers {
            let mut position = [0.0; 3];
            let mut is_missing = false;
            for (axis, value) in position.iter_mut().enumerate() {
                let cell = rows.cell(column + axis);
                let number = std::str::from_utf8(cell).ok().and_then(|text| text.parse().ok());
                match coordinate(cell, number) {
                    Some(number) if number.is_nan() => is_missing = true,
                    Some(number) => *value = number,
                    None => {
                        return Err(rows.error(&format!(
                            "cell {} is {}, expected a coordinate with a decimal point, or nothing where a marker \
                             was not seen",
                            column + axis + 1,
                            quoted(&String::from_utf8_lossy(cell))
                        )));
                    }
                }
            }
            self.positions.push(if is_missing { RawTake::MISSING } else { position });
        }
        Ok(())
    }

    /// Forgets the last frame.
    pub(super) fn pop(&mut self) {
        self.positions.truncate(self.positions.len().saturating_sub(self.columns.markers.len()));
    }

    /// Frames × M positions.
    pub(super) fn into_positions(self) -> Vec<[f64; 3]> {
        self.positions
    }
}

/// The coordinate in a cell that holds `number`, if it holds any. NaN for a cell that says “no number”, and
/// for numbers that no unit could make a coordinate. `None` for anything else.
pub(super) fn coordinate(cell: &[u8], number: Option<f64>) -> Option<f64> {
    match number {
        Some(number) if number.abs() <= f64::from(f32::MAX) => Some(number),
        Some(_) => Some(f64::NAN),
        None => says_missing(cell).then_some(f64::NAN),
    }
}
