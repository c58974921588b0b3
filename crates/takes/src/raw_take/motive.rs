//! The CSV that OptiTrack's Motive exports, format versions 1.2x. First comes a line of keys and values. The
//! next lines state for each column its type (a rigid body, a bone, a marker), name, ID, sometimes parent,
//! property and axis. Then come the frames.
use super::frames::{self, Header, filled, number, text};
use super::samples::Columns;
use crate::tables::rows::Rows;
use crate::text::{Table, utf_8};
use rhytid_core::text::{listed, quoted};
use rhytid_core::{Error, RawTake, Result};
use std::collections::HashSet;

/// The most lines between the first one and the axes'.
const MOST_LINES: usize = 12;

/// Reads a file. An empty cell means that the marker was not seen.
///
/// Markers of rigid bodies and bones have the places of Motive's model of them. Such a marker is used only
/// where the file has no measured marker of the same name.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    let table = Table::new(utf_8(bytes), "Format Version");
    let bytes: &[u8] = &table.bytes;
    let mut rows = Rows::without_header(bytes, name, table.separator);
    let mut header = Header { unit: (String::new(), "Length Units"), ..Header::default() };
    if rows.advance()? {
        read_keys(&rows, &mut header);
    }
    let mut lines: Vec<Vec<String>> = Vec::new();
    loop {
        if !rows.advance()? || lines.len() > MOST_LINES {
            return Err(Error::malformed(format!(
                "{name}: has no line that begins with Frame, as Motive's CSV has above its frames; the file may be cut \
                 short"
            )));
        }
        let line: Vec<String> = (0..filled(&rows)).map(|column| text(&rows, column)).collect();
        let is_axes = line.first().is_some_and(|cell| cell.eq_ignore_ascii_case("Frame"));
        if !line.is_empty() {
            lines.push(line);
        }
        if is_axes {
            break;
        }
    }
    let found = markers(&lines).ok_or_else(|| {
        rows.error("expected lines of types, names and properties between the first line and this one")
    })?;
    if found.is_empty() {
        return Err(Error::empty(format!(
            "{name}: has no columns of type Marker and property Position; switch the markers on in Motive's export"
        )));
    }
    let modelled: Vec<&str> = found.iter().filter(|m| m.is_modelled).map(|m| m.label.as_str()).collect();
    if !modelled.is_empty() {
        header.warnings.push(format!(
            "{} markers have only the positions that their rigid body or bone gives them: {}",
            modelled.len(),
            listed(modelled.into_iter())
        ));
    }
    let axes = lines.last().map_or(&[][..], Vec::as_slice);
    header.columns = Columns {
        number: Some(0),
        time: axes.iter().position(|cell| cell.to_ascii_lowercase().starts_with("time")),
        markers: found.iter().map(|marker| marker.column).collect(),
        others_follow: true,
        has_blanks: false,
    };
    header.labels = found.into_iter().map(|marker| marker.label).collect();
    let more = rows.advance()?;
    frames::read(more.then_some(rows), bytes, name, header, rate)
}

fn read_keys(rows: &Rows<'_>, header: &mut Header) {
    let place = |key: &str| {
        // A take's name with a comma moves the keys behind it.
        let cell = (0..rows.width()).find(|&column| text(rows, column).eq_ignore_ascii_case(key));
        cell.map(|column| column + 1)
    };
    let rate = |key| place(key).and_then(|column| number(rows, column));
    header.rate = rate("Export Frame Rate").or_else(|| rate("Capture Frame Rate"));
    header.frames = place("Total Exported Frames").and_then(|column| number(rows, column));
    header.unit.0 = place("Length Units").map(|column| text(rows, column)).unwrap_or_default();
    let started = place("Capture Start Time").map(|column| text(rows, column));
    header.recording.started = started.filter(|text| !text.is_empty());
    header.recording.first_frame = place("Capture Start Frame").and_then(|column| number(rows, column));
    let version = place("Format Version").map(|column| text(rows, column)).unwrap_or_default();
    let version = version.replace(',', ".");
    if !version.starts_with("1.2") {
        header.warnings.push(format!(
            "the format's version is {}, expected 1.2x; the file may be read wrongly",
            quoted(&version)
        ));
    }
}

struct Marker {
    /// The column of its x.
    column: usize,
    label: String,
    is_modelled: bool,
}

/// The columns of the positions of markers; `None` if lines are missing.
fn markers(lines: &[Vec<String>]) -> Option<Vec<Marker>> {
    let (axes, lines) = lines.split_last()?;
    let (properties, lines) = lines.split_last()?;
    // Not every version names its lines. But in all of them the types come first and the names later.
    let line = |title: &str, place: usize| {
        let named =
            lines.iter().find(|line| line.get(1).is_some_and(|cell| cell.eq_ignore_ascii_case(title)));
        named.or(lines.get(place))
    };
    let (types, names) = (line("Type", 0)?, line("Name", 1)?);
    let is = |line: &[String], column: usize, wanted: &str| {
        line.get(column).is_some_and(|cell| cell.eq_ignore_ascii_case(wanted))
    };
    let mut found = Vec::new();
    let mut column = 0;
    while column < axes.len() {
        let xyz = ["X", "Y", "Z"].iter().enumerate();
        let is_position = xyz
            .into_iter()
            .all(|(i, axis)| is(axes, column + i, axis) && is(properties, column + i, "Position"));
        let kind = types.get(column).map_or("", String::as_str).to_ascii_lowercase();
        if is_position && (kind == "marker" || kind.ends_with(" marker")) {
            let label = names.get(column).cloned().unwrap_or_default();
            found.push(Marker { column, label, is_modelled: kind != "marker" });
        }
        column += if is_position { 3 } else { 1 };
    }
    let measured: HashSet<String> =
        found.iter().filter(|marker| !marker.is_modelled).map(|marker| marker.label.clone()).collect();
    let mut modelled = HashSet::new();
    found.retain(|marker| {
        !marker.is_modelled || !measured.contains(&marker.label) && modelled.insert(marker.label.clone())
    });
    Some(found)
}
