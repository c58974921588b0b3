//! The text that Vicon's Nexus and Shogun export as CSV or ASCII. A file has sections one below the other. A
//! section has a line of its name, a line of its rate, a line of labels, a line of columns, a line of units,
//! and frames. Only the section of the trajectories and that of the events are read.
//!
//! The older Workstation and Nexus 1 write `120,Hz`, call the first column `Field #`, and have no line of
//! units.
use super::frames::{self, Header, filled, number, text};
use super::samples::Columns;
use crate::tables::rows::Rows;
use crate::text::{Table, line_with, utf_8};
use rhytid_core::{Error, RawTake, Result, TakeEvent};

/// The names of sections, each alone in its line.
pub(super) const SECTIONS: [&str; 7] =
    ["Trajectories", "Model Outputs", "Devices", "Joints", "Segments", "Events", "Analog"];

/// The names of the column of the frames' numbers.
const FRAMES: [&str; 2] = ["Frame", "Field #"];

/// Reads a file. An empty cell means that the marker was not seen.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    let text_of_table = utf_8(bytes);
    let frames = FRAMES.into_iter().find(|name| line_with(&text_of_table, name).is_some());
    let table = Table::new(text_of_table, frames.unwrap_or(FRAMES[0]));
    let bytes: &[u8] = &table.bytes;
    let has_none = || {
        let found: Vec<&str> =
            SECTIONS.into_iter().filter(|section| line_with(bytes, section).is_some()).collect();
        Error::empty(format!(
            "{name}: has no section Trajectories, but {}; export the trajectories too",
            found.join(", ")
        ))
    };
    let section = line_with(bytes, SECTIONS[0]).ok_or_else(has_none)?;
    let start = bytes.len() - section.len();
    let bytes_to_end = &bytes[..start + end_of(section)];
    let mut rows = Rows::without_header(bytes_to_end, name, table.separator);
    while rows.advance()? && !text(&rows, 0).eq_ignore_ascii_case(SECTIONS[0]) {}
    let mut header = Header { unit: (String::new(), "the line of units"), zero: 1, ..Header::default() };
    header.recording.events = events(bytes, table.separator);
    let mut labels: Vec<String> = Vec::new();
    let axes = loop {
        if !rows.advance()? {
            return Err(Error::malformed(format!(
                "{name}: has no line that begins with Frame or Field # below Trajectories, as Vicon's CSV has above its \
                 frames; the file may be cut short"
            )));
        }
        let cells: Vec<String> = (0..filled(&rows)).map(|column| text(&rows, column)).collect();
        let first = cells.first().map_or("", String::as_str);
        if FRAMES.iter().any(|name| first.eq_ignore_ascii_case(name)) {
            break cells;
        }
        if first.is_empty() {
            labels = cells;
        } else if header.rate.is_none() {
            header.rate = number(&rows, 0);
        }
    };
    let mut columns = Columns { number: Some(0), others_follow: true, ..Columns::default() };
    let is_axis =
        |column: usize, axis: &str| axes.get(column).is_some_and(|cell| cell.eq_ignore_ascii_case(axis));
    for column in 0..axes.len() {
        if is_axis(column, "X") && is_axis(column + 1, "Y") && is_axis(column + 2, "Z") {
            columns.markers.push(column);
            header.labels.push(labels.get(column).cloned().unwrap_or_default());
        }
    }
    let mut more = rows.advance()?;
    if more && text(&rows, 0).is_empty() {
        let first = columns.markers.first().map(|&column| text(&rows, column));
        header.unit.0 = first.unwrap_or_default();
        more = rows.advance()?;
    }
    header.columns = columns;
    frames::read(more.then_some(rows), bytes_to_end, name, header, rate)
}

/// The byte at which a section ends: before the first line below its frames that begins with a letter.
fn end_of(section: &[u8]) -> usize {
    let Some(frames) = FRAMES.into_iter().find_map(|name| line_with(section, name)) else {
        return section.len();
    };
    let mut at = section.len() - frames.len();
    let next_line = |at: usize| {
        let end = section[at..].iter().position(|byte| matches!(byte, b'\n' | b'\r'))?;
        Some(at + end + 1)
    };
    while let Some(next) = next_line(at) {
        at = next;
        let begins = section[at..].iter().find(|byte| !matches!(byte, b' ' | b'"'));
        if begins.is_some_and(u8::is_ascii_alphabetic) {
            return at;
        }
    }
    section.len()
}

/// The section of events: a line of columns, and a line for each event. Columns are found by their names.
fn events(bytes: &[u8], separator: u8) -> Vec<TakeEvent> {
    let Some(section) = line_with(bytes, "Events") else { return Vec::new() };
    let mut rows = Rows::without_header(section, "", separator);
    let mut columns: Vec<String> = Vec::new();
    let mut found = Vec::new();
    while matches!(rows.advance(), Ok(true)) {
        let cells: Vec<String> = (0..filled(&rows)).map(|column| text(&rows, column)).collect();
        let place = |name: &str| columns.iter().position(|cell| cell.to_ascii_lowercase().starts_with(name));
        if let (Some(name), Some(time)) = (place("name"), place("time")) {
            // The next section begins with its name.
            let Some(time) = number(&rows, time) else { break };
            let context = place("context").map(|column| text(&rows, column)).unwrap_or_default();
            found
                .push(TakeEvent { name: format!("{context} {}", text(&rows, name)).trim().to_owned(), time });
        } else if cells.iter().any(|cell| cell.to_ascii_lowercase().starts_with("time")) {
            columns = cells;
        }
    }
    found
}
