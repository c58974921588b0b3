//! The TSV that Qualisys Track Manager exports. First come lines of a key and its values between tabs. A line
//! that names the columns may follow. Then come the frames, with or without number and time.
use super::frames::{self, Header, filled, number, text};
use super::samples::Columns;
use super::timecode;
use crate::tables::rows::Rows;
use crate::text::{Table, utf_8};
use rhytid_core::{Error, InputErrorKind, RawTake, Result, TakeEvent, Timecode};

/// Reads a file. An empty cell means that the marker was not seen. Lengths are in millimetres: the file does
/// not state the unit, but the program always writes millimetres.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    let table = Table::new(utf_8(bytes), "NO_OF_FRAMES");
    let bytes: &[u8] = &table.bytes;
    let mut rows = Rows::without_header(bytes, name, table.separator);
    let mut header = Header { unit: ("mm".to_owned(), "the unit"), zero: 1, ..Header::default() };
    let mut named: Option<Columns> = None;
    let mut has_names = false;
    let mut more = rows.advance()?;
    while more {
        let first = text(&rows, 0);
        if first.is_empty() || first.parse::<f64>().is_ok() {
            break;
        }
        match first.to_ascii_uppercase().as_str() {
            "NO_OF_FRAMES" => header.frames = number(&rows, 1),
            "NO_OF_MARKERS" => header.markers = number(&rows, 1),
            "FREQUENCY" => header.rate = number(&rows, 1),
            "TIME_STAMP" => header.recording.started = Some(text(&rows, 1)).filter(|text| !text.is_empty()),
            "EVENT" => {
                // The name, the frame and the seconds.
                let time = number(&rows, 3).or_else(|| Some((number::<f64>(&rows, 2)? - 1.0) / header.rate?));
                let name = text(&rows, 1);
                header.recording.events.extend(time.map(|time| TakeEvent { name, time }));
            }
            "MARKER_NAMES" => {
                header.labels = (1..filled(&rows)).map(|column| text(&rows, column)).collect();
                has_names = true;
            }
            "DATA_INCLUDED" if !text(&rows, 1).eq_ignore_ascii_case("3D") => {
                return Err(rows
                    .error(&format!(
                        "the data that is included is {}, expected 3D; export the trajectories' 3D data",
                        rhytid_core::text::quoted(&text(&rows, 1))
                    ))
                    .of_kind(InputErrorKind::UnsupportedFormat));
            }
            _ if axis_of(&rows, filled(&rows).saturating_sub(1)) == Some('Z') => {
                named = Some(named_columns(&rows));
                if !has_names {
                    let columns = named.iter().flat_map(|columns| &columns.markers);
                    header.labels = columns.map(|&column| label_of(&rows, column)).collect();
                }
            }
            _ => {}
        }
        more = rows.advance()?;
    }
    header.columns = match named {
        Some(columns) => columns,
        None if more => columns_by_width(&rows, header.labels.len(), header.markers)?,
        None => return Err(Error::empty(format!("{name}: has no frames; copy or export the file anew"))),
    };
    header.recording.timecode = if more { timecode_of(&rows) } else { None };
    let (names, markers) = (header.labels.len(), header.columns.markers.len());
    if has_names && names != markers {
        header.warnings.push(format!("MARKER_NAMES has {names} names, and there are {markers} markers"));
    }
    header.labels.resize(markers, String::new());
    frames::read(more.then_some(rows), bytes, name, header, rate)
}

/// `X` of the columns `jaw00 X` and `X`.
fn axis_of(rows: &Rows<'_>, column: usize) -> Option<char> {
    let name = text(rows, column);
    let (before, axis) = name.rsplit_once(' ').unwrap_or(("", &name));
    let axis = ["X", "Y", "Z"].iter().find(|known| known.eq_ignore_ascii_case(axis))?.chars().next();
    axis.filter(|_| before.is_empty() || name.contains(' '))
}

/// `jaw00` of the column `jaw00 X`.
fn label_of(rows: &Rows<'_>, column: usize) -> String {
    text(rows, column).rsplit_once(' ').map(|(label, _)| label.trim().to_owned()).unwrap_or_default()
}

/// The time code of the first frame, if the current row has one.
fn timecode_of(rows: &Rows<'_>) -> Option<Timecode> {
    (0..rows.width().min(3)).find_map(|column| timecode::parse(&text(rows, column)))
}

/// The columns according to the line that names them.
fn named_columns(rows: &Rows<'_>) -> Columns {
    let place =
        |wanted: &str| (0..rows.width()).find(|&column| text(rows, column).eq_ignore_ascii_case(wanted));
    let markers = (0..rows.width()).filter(|&column| {
        let axes = [0, 1, 2].map(|axis| axis_of(rows, column + axis));
        axes == [Some('X'), Some('Y'), Some('Z')]
    });
    Columns { number: place("Frame"), time: place("Time"), markers: markers.collect(), ..Columns::default() }
}

/// The columns by the width of the first frame: three for each marker. Before them there are number and time,
/// or nothing.
fn columns_by_width(rows: &Rows<'_>, names: usize, promised: Option<usize>) -> Result<Columns> {
    let width = rows.width();
    // A row may end in a tab.
    let open = usize::from(rows.cell(width.saturating_sub(1)).is_empty());
    for markers in [Some(names), promised].into_iter().flatten().filter(|&markers| markers <= width) {
        for lead in [0, 2, 3] {
            let cells = lead + 3 * markers;
            if width == cells || width == cells + open {
                return Ok(Columns {
                    number: (lead > 0).then_some(0),
                    time: (lead > 0).then_some(1),
                    markers: (0..markers).map(|marker| lead + 3 * marker).collect(),
                    ..Columns::default()
                });
            }
        }
    }
    Err(rows.error(&format!(
        "the row has {width} cells, expected 3 for each of {} markers, alone or behind a frame number, a time and perhaps a time code; \
         export with a header that names the columns",
        promised.unwrap_or(names)
    )))
}
