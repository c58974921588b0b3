//! A file's encoding, told by its first bytes.

use super::opened::Opened;
use super::source::Source;
use super::{crate_file, package, text};
use rhytid_core::{InputErrorKind, Result};
use std::io::Cursor;
use std::path::Path;

/// Opens a crate file, text or a package, told apart by their first bytes.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if it is none of these or damaged; [`rhytid_core::Error::Io`].
pub fn open(path: &Path) -> Result<Opened> {
    of_source(Source::open(path)?)
}

/// The same of a file's `bytes`; `name` is for messages.
///
/// # Errors
/// As [`open()`].
pub fn decode(bytes: Vec<u8>, name: &str) -> Result<Opened> {
    of_source(Source::new(Box::new(Cursor::new(bytes)), name.to_owned())?)
}

fn of_source(mut source: Source) -> Result<Opened> {
    let mut first = [0; 8];
    let read = source.read_some(0, &mut first)?;
    match &first[..read] {
        b"PXR-USDC" => crate_file::open(source),
        [b'P', b'K', 3, 4, ..] => of_source(package::first_member(source)?),
        b"#usda 1." => text::open(source),
        [] => Err(source.wrong("is empty, expected a USD file; export it again").of_kind(InputErrorKind::Empty)),
        _ => Err(source.wrong(
            "begins neither as binary USD (PXR-USDC) nor as text (#usda 1.0) nor as a package (zip); is it a USD file?",
        ).of_kind(InputErrorKind::UnsupportedFormat)),
    }
}
