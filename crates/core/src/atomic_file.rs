//! Files that appear whole.
use crate::steady_file::SteadyFile;
use crate::{Error, Result};
use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file that appears under its name only when it is whole.
///
/// Bytes go to a temporary file in the same folder; [`AtomicFile::finish`] renames it. Dropped before that,
/// the temporary file is removed and whatever stood under the name is untouched.
#[derive(Debug)]
pub struct AtomicFile {
    writer: BufWriter<SteadyFile>,
    path: PathBuf,
}

impl AtomicFile {
    /// Opens a temporary file beside `path`.
    ///
    /// # Errors
    /// [`Error::Input`] if the folder does not exist or `path` is a folder; [`Error::Io`].
    pub fn create(path: &Path) -> Result<Self> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let wrong = |what: &str| {
            Err(Error::input(format!("{}: the folder {} {what}", path.display(), folder.display())))
        };
        match std::fs::metadata(folder) {
            Ok(found) if found.is_dir() => {}
            Ok(_) => return wrong("is a file; choose another one"),
            Err(e) if e.kind() == io::ErrorKind::NotFound => return wrong("does not exist; create it first"),
            Err(e) => return Err(Error::io(folder)(e)),
        }
        // A separator at the end asks for a folder, and would fail only when all was done.
        let ends_in_separator = path.to_string_lossy().ends_with(std::path::is_separator);
        if path.is_dir() || ends_in_separator {
            return Err(Error::input(format!(
                "{}: is a folder, expected the name of a file",
                path.display()
            )));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".rhytid-").suffix(".partial");
        #[cfg(unix)]
        {
            // A temporary file is private by default; what is renamed gets the rights of any new file.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder).map_err(Error::io(path))?;
        Ok(Self { writer: BufWriter::with_capacity(1 << 20, SteadyFile::new(file)), path: path.to_owned() })
    }

    /// The final name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An unnamed file on the same disk, for what has to be written after what is not yet known. It vanishes
    /// when dropped.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn spool(&self) -> Result<File> {
        let folder = self.writer.get_ref().get().path().parent().unwrap_or(Path::new("."));
        tempfile::tempfile_in(folder).map_err(Error::io(&self.path))
    }

    /// For `map_err` on writes: names the final path.
    pub fn error(&self) -> impl FnOnce(io::Error) -> Error + use<> {
        Error::io(&self.path)
    }

    /// Flushes to disk and renames.
    ///
    /// # Errors
    /// [`Error::Io`]; the temporary file is removed then.
    pub fn finish(self) -> Result<()> {
        let path = self.path;
        let file = self.writer.into_inner().map_err(|e| Error::io(&path)(e.into_error()))?;
        let file = file.finish().map_err(Error::io(&path))?;
        file.persist(&path).map_err(|e| Error::io(&path)(e.error))?;
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.writer.seek(to)
    }
}
