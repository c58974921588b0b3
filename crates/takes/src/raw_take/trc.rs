//! TRC, a text format of Motion Analysis that many programs write: lines of cells between tabs, and in some
//! programs between commas, semicolons or blanks. First come
//! keys and values of the trial. Then a line has `Frame#`, `Time` and the labels of the markers, each over
//! the first of its three columns. The next line numbers the axes, and then come the frames.
use super::frames::{self, Header, filled, number, text};
use super::samples::Columns;
use crate::tables::rows::Rows;
use crate::text::{Table, utf_8};
use rhytid_core::text::quoted;
use rhytid_core::{Error, RawTake, Result};

/// Columns before the first marker.
const LEAD: usize = 2;

/// Reads a file. An empty cell, or a cell without a number, means that the marker was not seen. Rows may end
/// early.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    let table = Table::new(utf_8(bytes), "Frame");
    let bytes: &[u8] = &table.bytes;
    let mut rows = Rows::without_header(bytes, name, table.separator);
    let mut header = Header { unit: (String::new(), "Units"), zero: 1, ..Header::default() };
    // The places of the keys, until the line of their values.
    let mut keys: Option<Vec<String>> = None;
    loop {
        if !rows.advance()? {
            return Err(Error::malformed(format!(
                "{name}: has no line that begins with Frame#, as a TRC file has above its frames; the file may be cut \
                 short"
            )));
        }
        let cells = || (0..rows.width()).map(|column| text(&rows, column));
        if text(&rows, 0).to_ascii_lowercase().starts_with("frame") {
            break;
        }
        if let Some(keys) = keys.take() {
            read_values(&rows, &keys, &mut header);
        } else if cells().any(|cell| cell.eq_ignore_ascii_case("DataRate")) {
            keys = Some(cells().map(|cell| cell.to_ascii_lowercase()).collect());
        }
    }
    let labels = labels(&rows, &table, header.markers, &mut header.warnings)?;
    let mut count = labels.len();
    let mut more = rows.advance()?;
    if more && is_axes(&rows) {
        count = count.max(markers_in(filled(&rows)));
        more = rows.advance()?;
    }
    while more && filled(&rows) == 0 {
        more = rows.advance()?;
    }
    if more {
        // Markers without a label show only in the length of a row.
        let room = rows.width().saturating_sub(LEAD) / 3;
        count = count.max(markers_in(filled(&rows))).max(room.min(header.markers.unwrap_or(0)));
        // Some programs write whole numbers with digits behind the point.
        let number = number::<f64>(&rows, 0).map(|number| number as i64);
        // Numbers that continue the session say it themselves.
        header.recording.first_frame = number.filter(|&number| number > 1).or(header.recording.first_frame);
    }
    header.labels = labels;
    header.labels.resize(count, String::new());
    header.columns = Columns {
        number: Some(0),
        time: Some(1),
        markers: (0..count).map(|marker| LEAD + 3 * marker).collect(),
        others_follow: false,
        has_blanks: table.has_blanks,
    };
    frames::read(more.then_some(rows), bytes, name, header, rate)
}

/// The number of markers that a row of so many cells reaches.
fn markers_in(cells: usize) -> usize {
    cells.saturating_sub(LEAD).div_ceil(3)
}

fn read_values(rows: &Rows<'_>, keys: &[String], header: &mut Header) {
    for (column, key) in keys.iter().enumerate() {
        match key.as_str() {
            "datarate" => header.rate = number(rows, column),
            "numframes" => header.frames = number(rows, column),
            "nummarkers" => header.markers = number(rows, column),
            "units" => header.unit.0 = text(rows, column),
            "origdatastartframe" => header.recording.first_frame = number(rows, column),
            _ => {}
        }
    }
}

/// The labels, each with its place over every third column. Some programs put them side by side.
fn labels(
    rows: &Rows<'_>,
    table: &Table<'_>,
    promised: Option<usize>,
    warnings: &mut Vec<String>,
) -> Result<Vec<String>> {
    let cells: Vec<String> = (LEAD..filled(rows)).map(|column| text(rows, column)).collect();
    if table.has_blanks {
        if let Some(promised) = promised.filter(|&promised| promised != cells.len()) {
            return Err(rows.error(&format!(
                "the line has {} labels between blanks, expected {promised}, as NumMarkers says; put tabs between the \
                 cells if a label has a blank in it",
                cells.len()
            )));
        }
        return Ok(cells);
    }
    let out_of_place = cells.iter().enumerate().find(|(place, cell)| place % 3 != 0 && !cell.is_empty());
    let Some((place, label)) = out_of_place else {
        return Ok(cells.into_iter().step_by(3).collect());
    };
    let labels: Vec<String> = cells.iter().filter(|cell| !cell.is_empty()).cloned().collect();
    if promised != Some(labels.len()) {
        return Err(rows.error(&format!(
            "the label {} stands over column {}, expected labels over columns 3, 6, 9 and so on, the first of each \
             marker's three",
            quoted(label),
            LEAD + place + 1
        )));
    }
    warnings.push("the labels do not stand over their columns; they are used in their order".into());
    Ok(labels)
}

/// Whether this is the line `X1`, `Y1`, `Z1` and so on.
fn is_axes(rows: &Rows<'_>) -> bool {
    let first = (0..rows.width()).map(|column| rows.cell(column)).find(|cell| !cell.is_empty());
    first.is_some_and(|cell| matches!(cell.first(), Some(b'X' | b'x')))
}
