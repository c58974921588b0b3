//! Files that are read whole. A file is refused if it never ends, does not fit, or changes while it is read.

#[cfg(target_arch = "wasm32")]
use crate::held_files;
use crate::{Error, Result, human, protected};
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;

/// Bytes of the largest table, project, setup or report that is read.
pub const LARGEST_TEXT: u64 = 1 << 28;

/// Bytes of the largest mesh or take that is read: an OBJ of 4,000,000 vertices has a sixteenth of this.
pub const LARGEST_MESH_OR_TAKE: u64 = 1 << 33;

/// Bytes of the largest rig, or array of frames, that is read.
pub const LARGEST_RIG: u64 = 1 << 36;

/// A file that is open.
#[cfg(not(target_arch = "wasm32"))]
pub type InputFile = File;
/// A file that is open. A browser has files in memory alone.
#[cfg(target_arch = "wasm32")]
pub type InputFile = io::Cursor<std::sync::Arc<[u8]>>;

/// Opens a file that is read in pieces, or more than once. A pipe cannot be read so.
///
/// # Errors
/// [`Error::Input`] if `path` is a folder, a device or a pipe; [`Error::Io`].
pub fn open(path: &Path) -> Result<InputFile> {
    #[cfg(target_arch = "wasm32")]
    return held_files::get(path).map(io::Cursor::new).map_err(Error::io(path));
    #[cfg(not(target_arch = "wasm32"))]
    open_regular(path)
}

#[cfg(not(target_arch = "wasm32"))]
fn open_regular(path: &Path) -> Result<File> {
    let wrong = |what: &str| Err(Error::bad_path(format!("{}: {what}", path.display())));
    let found = std::fs::metadata(path).map_err(Error::io(path))?;
    match () {
        () if found.is_dir() => wrong("is a folder, expected a file; check the path"),
        () if is_device(&found) => wrong("is a device, expected a file; check the path"),
        () if !found.is_file() => wrong("is a pipe, but is read more than once; save it as a file first"),
        () => {
            protected::note(path);
            File::open(path).map_err(Error::io(path))
        }
    }
}

/// Whether `path` is a regular file.
///
/// # Errors
/// As [`std::fs::metadata`].
pub fn is_regular(path: &Path) -> io::Result<bool> {
    #[cfg(target_arch = "wasm32")]
    return held_files::get(path).map(|_| true);
    #[cfg(not(target_arch = "wasm32"))]
    std::fs::metadata(path).map(|found| found.is_file())
}

/// The first `most` bytes of a regular file. A file that is not regular cannot be read twice, so nothing of
/// it is read.
///
/// # Errors
/// As opening and reading. [`io::ErrorKind::InvalidInput`] if the file is not regular.
pub fn start(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    if !is_regular(path)? {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    #[cfg(target_arch = "wasm32")]
    let file = io::Cursor::new(held_files::get(path)?);
    #[cfg(not(target_arch = "wasm32"))]
    let file = File::open(path)?;
    let mut bytes = Vec::new();
    file.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a file, or a pipe to its end.
///
/// # Errors
/// [`Error::Input`] if `path` is a folder or a device, or has more than `limit` bytes. A file that is too
/// large is not read at all. [`Error::Input`] also if the file becomes shorter or longer while it is read.
/// [`Error::Io`].
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    #[cfg(target_arch = "wasm32")]
    if let Ok(held) = held_files::get(path) {
        return Ok(held.to_vec());
    }
    let shown = path.display();
    let wrong = |what: &str| Err(Error::bad_path(format!("{shown}: {what}")));
    // This comes before the file is opened, since opening has an effect on some devices.
    let found = std::fs::metadata(path).map_err(Error::io(path))?;
    if found.is_dir() {
        return wrong("is a folder, expected a file; check the path");
    }
    if is_device(&found) {
        return wrong("is a device, expected a file; check the path");
    }
    protected::note(path);
    let file = File::open(path).map_err(Error::io(path))?;
    let announced = file.metadata().map_err(Error::io(path))?;
    let too_large = |has: String| {
        let most = human::bytes(limit);
        Err(Error::too_large(format!(
            "{shown}: {has}, expected at most {most}; check that it is the file that you mean"
        )))
    };
    if announced.is_file() && announced.len() > limit {
        return too_large(format!("has {}", human::bytes(announced.len())));
    }
    let mut bytes = Vec::new();
    if announced.is_file() {
        let reserved = bytes.try_reserve_exact(usize::try_from(announced.len()).unwrap_or(usize::MAX));
        if reserved.is_err() {
            let size = human::bytes(announced.len());
            return Err(Error::too_large(format!(
                "{shown}: has {size}, more than the memory that is left; close other programs"
            )));
        }
    }
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(Error::io(path))?;
    let read = bytes.len() as u64;
    match () {
        () if announced.is_file() && read != announced.len() => Err(Error::cut_short(format!(
            "{shown}: had {} bytes when it was opened, and {read} when it was read; wait until it is written, and try again",
            announced.len()
        ))),
        () if read > limit => too_large("goes on and on".into()),
        () => Ok(bytes),
    }
}

#[cfg(unix)]
fn is_device(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device() || found.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: &Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_end_or_does_not_fit_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("face.obj");
        std::fs::write(&path, "v 0 0 0\n").unwrap();
        assert_eq!(read(&path, 8).unwrap(), b"v 0 0 0\n");
        let said = |path: &Path, limit| read(path, limit).unwrap_err().to_string();
        assert!(said(&path, 7).contains("has 8 bytes, expected at most 7 bytes"), "{}", said(&path, 7));
        assert!(said(folder.path(), 7).contains("is a folder, expected a file"));
        // The file is larger than any disk. Nothing of it is read.
        File::options().write(true).open(&path).unwrap().set_len(1 << 42).unwrap();
        assert!(said(&path, LARGEST_RIG).contains("expected at most"), "{}", said(&path, LARGEST_RIG));
        #[cfg(unix)]
        assert!(said(Path::new("/dev/zero"), 7).contains("is a device"));
        #[cfg(target_os = "linux")]
        assert!(said(Path::new("/proc/self/status"), 1 << 20).contains("had 0 bytes when it was opened"));
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        // Opening it would wait for its other end.
        assert!(open(&path).unwrap_err().to_string().contains("is a pipe, but is read more than once"));
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_read_to_its_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("take.csv");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        for (limit, is_read) in [(8, true), (7, false)] {
            let writer = std::thread::spawn({
                let path = path.clone();
                move || std::fs::write(path, "time,a_x\n".get(..8).unwrap())
            });
            assert_eq!(read(&path, limit).is_ok(), is_read);
            let _ = writer.join().unwrap();
        }
    }
}
