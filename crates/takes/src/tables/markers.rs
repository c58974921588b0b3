//! The marker of each handle: `handle,marker,distance_mm,sure`. The table is written as a proposal, and a
//! person edits it.
use super::rows::Rows;
use super::{csv_of, write_checked};
use rhytid_core::text::quoted;
use rhytid_core::{Error, InputErrorKind, Result, input_file};
use std::path::Path;

/// A handle and its marker.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerRow {
    /// The handle's label.
    pub handle: String,
    /// The marker's label in the capture file; `None` where it has none.
    pub marker: Option<String>,
    /// How far the marker is from the handle at neutral, in millimetres; `None` where that is not known.
    pub distance_mm: Option<f64>,
    /// The certainty: 0 if another marker fits as well, up to 1.
    pub sure: f64,
}

/// Reads the pairs of handle and marker from a CSV file with these two columns. Handles without a marker are
/// skipped. Other columns do not matter.
///
/// # Errors
/// [`Error::Input`]: no such columns, no handle in a row, a handle or a marker that occurs twice.
/// [`Error::Io`].
pub fn read_markers(path: &Path) -> Result<Vec<(String, String)>> {
    let bytes = input_file::read(path, input_file::LARGEST_TEXT)?;
    decode(&bytes, &path.display().to_string())
}

fn decode(bytes: &[u8], name: &str) -> Result<Vec<(String, String)>> {
    let mut rows = Rows::open(bytes, name)?;
    let place = |name: &str| rows.header().iter().position(|cell| cell == name);
    let (Some(handle), Some(marker)) = (place("handle"), place("marker")) else {
        return Err(rows.error(&format!(
            "the header is {}, expected columns “handle” and “marker”",
            quoted(&rows.header().join(","))
        )));
    };
    let mut pairs: Vec<(String, String)> = Vec::new();
    while rows.next()? {
        let pair = (rows.text(handle)?.to_owned(), rows.text(marker)?.to_owned());
        if pair.0.is_empty() {
            return Err(rows.error("the handle is empty, expected its label"));
        }
        if pair.1.is_empty() {
            continue;
        }
        if let Some(other) = pairs.iter().find(|other| other.0 == pair.0 || other.1 == pair.1) {
            return Err(rows.error(&format!(
                "{} has the marker {}, but {} has {} already; each handle has one marker, and each marker one handle",
                quoted(&pair.0),
                quoted(&pair.1),
                quoted(&other.0),
                quoted(&other.1)
            )).of_kind(InputErrorKind::Conflict));
        }
        pairs.push(pair);
    }
    Ok(pairs)
}

/// Writes the table.
///
/// # Errors
/// [`Error::Input`] if [`read_markers`] would not read it back: labels that occur twice, or begin or end with
/// a blank. [`Error::Io`].
pub fn write_markers(path: &Path, table: &[MarkerRow]) -> Result<()> {
    let labels = table.iter().flat_map(|row| [Some(&row.handle), row.marker.as_ref()]).flatten();
    let mut csv = csv_of(labels.map(String::as_str));
    let mut encode = || -> csv::Result<()> {
        csv.write_record(["handle", "marker", "distance_mm", "sure"])?;
        for row in table {
            let distance = row.distance_mm.map_or(String::new(), |distance| format!("{distance:.2}"));
            let marker = row.marker.as_deref().unwrap_or_default();
            csv.write_record([&row.handle, marker, &distance, &format!("{:.2}", row.sure)])?;
        }
        Ok(())
    };
    encode().map_err(|e| Error::Internal(e.to_string()))?;
    let bytes = csv.into_inner().map_err(|e| Error::Internal(e.to_string()))?;
    let pairs: Vec<(String, String)> =
        table.iter().filter_map(|row| Some((row.handle.clone(), row.marker.clone()?))).collect();
    write_checked(path, &bytes, |name| Ok(decode(&bytes, name)? == pairs))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_comes_back_and_mistakes_are_named() {
        let row = |handle: &str, marker: Option<&str>| MarkerRow {
            handle: handle.into(),
            marker: marker.map(str::to_owned),
            distance_mm: marker.map(|_| 1.25),
            sure: 0.5,
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("markers.csv");
        write_markers(&path, &[row("chin", Some("M1")), row("brow", None), row("a,b", Some("M 2"))]).unwrap();
        let pairs = [("chin", "M1"), ("a,b", "M 2")].map(|(a, b)| (a.to_owned(), b.to_owned()));
        assert_eq!(read_markers(&path).unwrap(), pairs);
        for (text, expected) in [
            ("handle,label\nchin,M1\n", "line 1: the header is \"handle,label\", expected columns"),
            ("handle,marker\n,M1\n", "line 2: the handle is empty"),
            (
                "handle,marker\nchin,M1\nbrow,M1\n",
                "line 3: \"brow\" has the marker \"M1\", but \"chin\" has \"M1\" already",
            ),
        ] {
            let message = decode(text.as_bytes(), "table.csv").unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
