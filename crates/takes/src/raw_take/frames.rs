//! The common part of the text formats below their headers: a row for each frame.
use super::clock::Clock;
use super::samples::{Columns, Samples};
use super::{labels, units};
use crate::tables::rows::Rows;
use rhytid_core::{Error, RawTake, Recording, Result, Take};

/// The statements of a header about all frames.
#[derive(Default)]
pub(super) struct Header {
    /// A label for each marker; empty where the file has none.
    pub(super) labels: Vec<String>,
    /// The number of markers that the header states.
    pub(super) markers: Option<usize>,
    /// The number of frames that the header states.
    pub(super) frames: Option<usize>,
    /// Frames per second.
    pub(super) rate: Option<f64>,
    /// The unit of length, and the place that names it.
    pub(super) unit: (String, &'static str),
    /// The number of the frame at time 0.
    pub(super) zero: i64,
    pub(super) columns: Columns,
    pub(super) recording: Recording,
    pub(super) warnings: Vec<String>,
}

/// Reads the frames from the current row of `rows` (`None` where there is none) to the last one of the file.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn read(
    mut rows: Option<Rows<'_>>,
    bytes: &[u8],
    name: &str,
    header: Header,
    rate: Option<f64>,
) -> Result<RawTake> {
    let Header { labels, mut warnings, columns, recording, .. } = header;
    let is_whole = matches!(bytes.last(), Some(b'\n' | b'\r'));
    if labels.is_empty() {
        return Err(Error::empty(format!("{name}: has no markers; export the labelled trajectories too")));
    }
    let mut clock = Clock::from_frame(header.zero);
    let mut samples = Samples::new(columns.clone(), bytes.len());
    let (mut frames, mut first_width, mut last_width) = (0, 0, 0);
    // A row that lacks cells is an error, unless it is the last one of a file that was cut.
    let mut lacks_cells = None;
    while let Some(row) = &mut rows {
        if samples.is_frame(row) {
            clock.push(row, columns.number, columns.time)?;
            if let Some(error) = lacks_cells {
                return Err(error);
            }
            lacks_cells = samples.lacks_cells(row);
            samples.push(row)?;
            last_width = row.width();
            first_width = if frames == 0 { last_width } else { first_width };
            frames += 1;
        }
        if !row.advance()? {
            rows = None;
        }
    }
    if let Some(error) = lacks_cells.filter(|_| is_whole) {
        return Err(error);
    }
    let promised = header.frames.unwrap_or(frames);
    if !is_whole && (last_width < first_width || frames < promised) && frames > 0 {
        frames -= 1;
        samples.pop();
        clock.truncate(frames);
        warnings.push("the file is cut short in its last row, which is left out".into());
    }
    if frames == 0 {
        return Err(Error::empty(format!("{name}: has no frames; copy or export the file anew")));
    }
    if frames < promised {
        warnings
            .push(format!("the file is cut short: {frames} of its {promised} frames are there and are read"));
    } else if frames > promised {
        warnings.push(format!("the header promises {promised} frames, and {frames} are there and are read"));
    }
    let count = labels.len();
    if let Some(promised) = header.markers.filter(|&markers| markers != count) {
        warnings.push(format!("the header promises {promised} markers, and {count} are there and are read"));
    }
    let (unit, place) = header.unit;
    let metres_per_unit = units::metres(&unit);
    if metres_per_unit.is_none() {
        warnings.push(units::unknown(&unit, place));
    }
    let times = clock.times(frames, rate, header.rate, &mut warnings);
    let times = times.map_err(|error| error.in_file(name))?;
    let labels = labels::distinct(labels, &mut warnings);
    let tracks = Take { labels, times, positions: samples.into_positions(), ..Take::default() };
    Ok(RawTake { tracks, metres_per_unit, recording, warnings, ..RawTake::default() })
}

/// A cell's text.
pub(super) fn text(rows: &Rows<'_>, column: usize) -> String {
    labels::text(rows.cell(column))
}

/// A number in a cell of the header, with a point or a comma; `None` where there is none.
pub(super) fn number<T: std::str::FromStr>(rows: &Rows<'_>, column: usize) -> Option<T> {
    let text = std::str::from_utf8(rows.cell(column)).ok()?;
    text.parse().or_else(|_| text.replace(',', ".").parse()).ok()
}

/// The number of cells up to the last one that is not empty.
pub(super) fn filled(rows: &Rows<'_>) -> usize {
    (0..rows.width()).rev().find(|&column| !rows.cell(column).is_empty()).map_or(0, |last| last + 1)
}
