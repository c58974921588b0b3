//! The cells of a take's rows.

use crate::tables::rows::Rows;
use rhytid_core::Error;
use rhytid_core::text::quoted;

/// The number in a cell.
pub(super) fn number(cell: &[u8]) -> Option<f64> {
    std::str::from_utf8(cell).ok()?.parse().ok()
}

/// A cell of the current row, for messages.
pub(super) fn shown(rows: &Rows<'_>, column: usize) -> String {
    match rows.cell(column) {
        [] => "empty".to_owned(),
        cell => quoted(&String::from_utf8_lossy(cell)),
    }
}

/// An error in the current row, which is that of `frame`.
pub(super) fn in_frame(rows: &Rows<'_>, frame: usize, message: &str) -> Error {
    rows.error(&format!("frame {frame}: {message}"))
}
