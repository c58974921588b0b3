//! The files of a browser, which has no file system. A page hands them over, and readers find them by name.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

static FILES: Mutex<BTreeMap<PathBuf, Arc<[u8]>>> = Mutex::new(BTreeMap::new());

/// A file that can be read by its name, until this is dropped.
#[derive(Debug)]
pub struct HeldFile {
    path: PathBuf,
    bytes: Arc<[u8]>,
}

impl HeldFile {
    /// Holds the bytes of a file. A file of the same name is there no longer.
    pub fn new(name: &str, bytes: Arc<[u8]>) -> Self {
        let path = PathBuf::from(name);
        FILES.lock().unwrap_or_else(PoisonError::into_inner).insert(path.clone(), bytes.clone());
        Self { path, bytes }
    }

    /// Its name.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for HeldFile {
    fn drop(&mut self) {
        let mut files = FILES.lock().unwrap_or_else(PoisonError::into_inner);
        // Another file may have taken its name.
        if files.get(&self.path).is_some_and(|held| Arc::ptr_eq(held, &self.bytes)) {
            files.remove(&self.path);
        }
    }
}

/// The bytes of a file.
///
/// # Errors
/// [`io::ErrorKind::NotFound`].
pub(crate) fn get(path: &Path) -> io::Result<Arc<[u8]>> {
    let files = FILES.lock().unwrap_or_else(PoisonError::into_inner);
    files.get(path).cloned().ok_or_else(|| io::ErrorKind::NotFound.into())
}
