//! Standard output.

use rhytid::{AtomicFile, Error, Result};
use serde::Serialize;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

/// Writes `text` and a line end to standard output. A reader that went away (`| head`) is not an error.
///
/// # Errors
/// [`Error::Io`] if standard output cannot be written: a full disk behind `>`.
pub(crate) fn say(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result.map_err(Error::io(Path::new("standard output"))),
    }
}

/// Writes a value as indented JSON to standard output.
///
/// # Errors
/// As [`say`].
pub(crate) fn json(value: &impl Serialize) -> Result<()> {
    say(&serde_json::to_string_pretty(value).map_err(|e| Error::Internal(e.to_string()))?)
}

/// Writes a file, whole.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn file(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes).map_err(file.error())?;
    file.finish()
}

/// Rows of cells as a table whose columns are aligned; the last column is not padded.
pub(crate) fn table<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}
