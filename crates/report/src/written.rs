//! Pages and their numbers as files.

use rhytid_core::{AtomicFile, Error, Result};
use std::io::Write;
use std::path::Path;

/// Where a report is written, and its heading.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The folder, which is created if necessary.
    pub folder: &'a Path,
    /// The heading: whom the report is about, such as the rig's name.
    pub title: &'a str,
}

/// Writes texts, each to a file of its name in the folder `dir`, which is created if necessary.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn write_texts<const N: usize>(dir: &Path, texts: [(&str, String); N]) -> Result<()> {
    std::fs::create_dir_all(dir).map_err(Error::io(dir))?;
    for (name, text) in texts {
        let mut file = AtomicFile::create(&dir.join(name))?;
        let written = file.write_all(text.as_bytes()).and_then(|()| file.write_all(b"\n"));
        written.map_err(file.error())?;
        file.finish()?;
    }
    Ok(())
}
