//! Writing curves as CSV.

use crate::tables::csv_of;
use rhytid_core::{AtomicFile, Error, Result};
use std::io::Write;
use std::path::Path;

/// Writes curves as CSV: the columns `frame` and `time`, in seconds, then a column for each of `names`. Each
/// frame from `first` on has a row. `values` (frames × names) are written as short as possible without loss.
///
/// # Errors
/// [`Error::Input`] if the folder does not exist; [`Error::Io`].
pub fn write_curves(path: &Path, names: &[String], first: usize, rate: f64, values: &[f32]) -> Result<()> {
    let mut csv = csv_of(names.iter().map(String::as_str));
    let mut encode = || -> csv::Result<()> {
        csv.write_record(["frame", "time"].into_iter().chain(names.iter().map(String::as_str)))?;
        for (frame, row) in (first..).zip(values.chunks_exact(names.len().max(1))) {
            let time = frame as f64 / rate;
            let head = [frame.to_string(), format!("{time:.6}")];
            csv.write_record(head.into_iter().chain(row.iter().map(f32::to_string)))?;
        }
        Ok(())
    };
    encode().map_err(|e| Error::Internal(e.to_string()))?;
    save(path, csv)
}

/// Gives a table the name `path`.
pub(super) fn save(path: &Path, csv: csv::Writer<Vec<u8>>) -> Result<()> {
    let bytes = csv.into_inner().map_err(|e| Error::Internal(e.to_string()))?;
    let mut file = AtomicFile::create(path)?;
    file.write_all(&bytes).map_err(file.error())?;
    file.finish()
}
