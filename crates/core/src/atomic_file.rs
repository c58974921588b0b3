//! Files that appear whole.
use crate::named_file::folder_of;
use crate::protected;
use crate::steady_file::SteadyFile;
use crate::temporary::{self, Temporary};
use crate::{Error, Result};
use std::fs::{File, Metadata};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file that appears under its name only when it is whole.
///
/// Bytes go to a file without a name in the same folder. Where the system has no such files, the file has a
/// temporary name. [`AtomicFile::finish`] gives the file its own name. If the file is dropped before that, it
/// is removed, and a file that already has the name stays as it is. A symbolic link stays, and its target is
/// written. A file that is replaced keeps its mode and, where that is allowed, its owner.
#[derive(Debug)]
pub struct AtomicFile {
    writer: BufWriter<SteadyFile>,
    path: PathBuf,
    /// Where links lead.
    target: PathBuf,
}

impl AtomicFile {
    /// Begins the file `path`. It also removes the temporary files of killed processes from the folder.
    ///
    /// # Errors
    /// [`Error::Input`] if the folder does not exist, or `path` is a folder, a device, a pipe, a socket,
    /// read-only, or a file that was read ([`protect_inputs`](crate::protect_inputs)); [`Error::Io`].
    pub fn create(path: &Path) -> Result<Self> {
        let target = followed(path)?;
        let folder = folder_of(&target);
        let wrong = |what: &str| {
            Err(Error::bad_path(format!("{}: the folder {} {what}", path.display(), folder.display())))
        };
        match std::fs::metadata(folder) {
            Ok(found) if found.is_dir() => {}
            Ok(_) => return wrong("is a file; choose another one"),
            Err(e) if e.kind() == io::ErrorKind::NotFound => return wrong("does not exist; create it first"),
            Err(e) => return Err(Error::io(folder)(e)),
        }
        // A separator at the end asks for a folder. Without this check, the error would come only at the end
        // of the work.
        let ends_in_separator = path.to_string_lossy().ends_with(std::path::is_separator);
        let refused = |what: &str| Err(Error::bad_path(format!("{}: is {what}", path.display())));
        match std::fs::metadata(&target) {
            _ if ends_in_separator => return refused("a folder, expected the name of a file"),
            Ok(found) if found.is_dir() => return refused("a folder, expected the name of a file"),
            Ok(found) if !found.is_file() => {
                return refused("a device, a pipe or a socket, expected the name of a file");
            }
            Ok(found) if found.permissions().readonly() => {
                return refused("read-only; choose another name, or make it writable first");
            }
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(Error::io(path)(e)),
            _ => {}
        }
        protected::refuse(&target)?;
        temporary::sweep(folder);
        let file = Temporary::create(folder).map_err(Error::io(path))?;
        let writer = BufWriter::with_capacity(1 << 20, SteadyFile::new(file));
        Ok(Self { writer, path: path.to_owned(), target })
    }

    /// The final name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An unnamed file on the same disk, for bytes that must stand behind others that are not known yet. The
    /// file vanishes when it is dropped.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn spool(&self) -> Result<File> {
        tempfile::tempfile_in(folder_of(&self.target)).map_err(Error::io(&self.path))
    }

    /// For `map_err` on writes: names the final path.
    pub fn error(&self) -> impl FnOnce(io::Error) -> Error + use<> {
        Error::io(&self.path)
    }

    /// As [`AtomicFile::finish`], under another name in the same folder, such as a name that depends on the
    /// contents.
    ///
    /// # Errors
    /// As [`AtomicFile::finish`].
    pub fn finish_as(mut self, path: &Path) -> Result<()> {
        self.path = path.to_owned();
        self.target = path.to_owned();
        self.finish()
    }

    /// Flushes to disk and gives the file its name.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] if the file was read meanwhile. No file is left behind then.
    pub fn finish(self) -> Result<()> {
        let Self { writer, path, target } = self;
        // It may have been read since.
        protected::refuse(&target)?;
        let file = writer.into_inner().map_err(|e| Error::io(&path)(e.into_error()))?;
        let file = file.finish().map_err(Error::io(&path))?;
        if let Ok(replaced) = std::fs::metadata(&target) {
            keep(&replaced, file.file()).map_err(Error::io(&path))?;
        }
        file.persist(&target).map_err(Error::io(&path))
    }
}

/// Longer chains of links are circles.
const LINKS: usize = 40;

/// Where symbolic links lead, whether there is a file or not.
fn followed(path: &Path) -> Result<PathBuf> {
    let mut at = path.to_owned();
    for _ in 0..LINKS {
        match std::fs::symlink_metadata(&at) {
            Ok(found) if found.is_symlink() => {
                let link = std::fs::read_link(&at).map_err(Error::io(path))?;
                at = at.parent().unwrap_or(Path::new("")).join(link);
            }
            _ => return Ok(at),
        }
    }
    Err(Error::bad_path(format!(
        "{}: is a link that leads back to itself; choose another name",
        path.display()
    )))
}

/// Gives a file the mode and the owner of the file that it replaces. A user who may not change the owner
/// stays the owner.
#[cfg(unix)]
fn keep(replaced: &Metadata, file: &File) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let new = file.metadata()?;
    if (new.uid(), new.gid()) != (replaced.uid(), replaced.gid()) {
        let _ = fchown(file, Some(replaced.uid()), Some(replaced.gid()));
    }
    // This comes after the owner, since a change of the owner clears bits of the mode.
    file.set_permissions(replaced.permissions())
}

#[cfg(not(unix))]
fn keep(_: &Metadata, _: &File) -> io::Result<()> {
    Ok(())
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
