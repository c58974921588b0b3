//! Files that have no name yet, or a temporary one.
//!
//! Where the system has files without a name (Linux, most of its file systems), a file that is never finished
//! leaves nothing behind, however its process ends. Elsewhere the file is named `.rhytid-….partial`, and is
//! locked as long as its process lives. So a file that is not locked was left by a process that is gone, and
//! [`sweep`] removes it.

use std::fs::File;
use std::io;
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

const PREFIX: &str = ".rhytid-";
const SUFFIX: &str = ".partial";
/// If a sweep removes a new file before it is locked, the file is made again, at most this often.
const ATTEMPTS: usize = 8;

/// A file on its way to its name.
#[derive(Debug)]
pub(crate) enum Temporary {
    /// It has no name.
    #[cfg_attr(not(target_os = "linux"), allow(dead_code, reason = "there are no such files"))]
    Unnamed(File),
    /// It has a temporary one, and is locked.
    Named(NamedTempFile),
}

impl Temporary {
    /// Opens a file that can be given a name in `folder`.
    pub(crate) fn create(folder: &Path) -> io::Result<Self> {
        match unnamed(folder) {
            Some(file) => Ok(Self::Unnamed(file)),
            None => named(folder).map(Self::Named),
        }
    }

    pub(crate) fn file(&self) -> &File {
        match self {
            Self::Unnamed(file) => file,
            Self::Named(file) => file.as_file(),
        }
    }

    /// Gives the file its name, in place of any other that has it.
    pub(crate) fn persist(self, path: &Path) -> io::Result<()> {
        match self {
            Self::Unnamed(file) => link(&file, path),
            Self::Named(file) => file.persist(path).map(drop).map_err(|e| e.error),
        }
    }
}

/// Removes what processes that are gone left in `folder`. What cannot be looked at stays.
pub(crate) fn sweep(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let is_ours = name.starts_with(PREFIX) && name.ends_with(SUFFIX);
        if !is_ours || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        // The lock is held until the file is gone.
        let Ok(file) = File::open(entry.path()) else { continue };
        if file.try_lock().is_ok() {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn named(folder: &Path) -> io::Result<NamedTempFile> {
    for _ in 0..ATTEMPTS {
        let file = builder().tempfile_in(folder)?;
        match file.as_file().try_lock() {
            // From now on no sweep removes it.
            Ok(()) if file.path().exists() => return Ok(file),
            Ok(()) | Err(std::fs::TryLockError::WouldBlock) => {}
            // Where files cannot be locked, no file is swept.
            Err(std::fs::TryLockError::Error(_)) => return Ok(file),
        }
    }
    Err(io::Error::other(
        "another program keeps removing its temporary file; stop that program, or choose another folder",
    ))
}

fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        // A temporary file is private by default. A renamed file needs the rights of any new file.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder
}

/// `None` where the system has no such files.
#[cfg(target_os = "linux")]
fn unnamed(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags, open};
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let file = File::from(open(folder, flags, Mode::from_raw_mode(0o666)).ok()?);
    // The file gets its name through this path, which a bare container may lack. It is checked now, not after
    // everything is written.
    by_number(&file).exists().then_some(file)
}

#[cfg(not(target_os = "linux"))]
fn unnamed(_: &Path) -> Option<File> {
    None
}

#[cfg(target_os = "linux")]
fn by_number(file: &File) -> std::path::PathBuf {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd()).into()
}

#[cfg(target_os = "linux")]
fn link(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    let link = |name: &Path| linkat(CWD, by_number(file), CWD, name, AtFlags::SYMLINK_FOLLOW);
    match link(path) {
        Err(rustix::io::Errno::EXIST) => {}
        other => return Ok(other?),
    }
    // A link replaces nothing, but a file with a name does; until it has the right one, the lock tells that
    // its process lives. Where it cannot be had, a sweep does not get it either.
    let _ = file.try_lock();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let temporary = builder().make_in(folder, |name| link(name).map_err(io::Error::from))?;
    temporary.persist(path).map_err(|e| e.error)
}

#[cfg(not(target_os = "linux"))]
fn link(_: &File, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn with_a_name_or_without_it_takes_the_place_of_what_stood_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out");
        for round in 0..2 {
            for create in [Temporary::create, |folder: &Path| named(folder).map(Temporary::Named)] {
                let temporary = create(folder.path()).unwrap();
                let text = format!("{round} {temporary:?}");
                temporary.file().write_all(text.as_bytes()).unwrap();
                temporary.persist(&path).unwrap();
                assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
                assert_eq!(names(folder.path()), ["out"]);
            }
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn it_has_no_name_before_its_time() {
        let folder = tempfile::tempdir().unwrap();
        let temporary = Temporary::create(folder.path()).unwrap();
        assert!(matches!(temporary, Temporary::Unnamed(_)), "{temporary:?}");
        assert_eq!(names(folder.path()), [""; 0]);
    }

    #[test]
    fn only_what_nobody_holds_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let held = named(folder.path()).unwrap();
        let held_name = held.path().file_name().unwrap().to_str().unwrap().to_owned();
        for name in
            [".rhytid-left.partial", "rhytid-mine.partial", ".rhytid-mine", ".rhytid-folder.partial.d"]
        {
            std::fs::write(at(name), "").unwrap();
        }
        std::fs::create_dir(at(".rhytid-folder.partial")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink("rhytid-mine.partial", at(".rhytid-link.partial")).unwrap();
        let mut before = names(folder.path());
        sweep(folder.path());
        before.retain(|name| name != ".rhytid-left.partial");
        assert_eq!(names(folder.path()), before);
        assert!(before.contains(&held_name));
        held.persist(at("out")).unwrap();
        assert!(at("out").exists());
    }
}
