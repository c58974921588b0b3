//! Files that were read. No output may replace them.

use crate::outputs::are_one;
use crate::{Error, InputErrorKind, Result};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The files that were read so far; `None` until [`protect_inputs`].
static READ: Mutex<Option<BTreeSet<PathBuf>>> = Mutex::new(None);

/// From now on, an [`AtomicFile`](crate::AtomicFile) refuses to replace a file that this process has read
/// through this library. It does not matter which file names it.
///
/// This is for a program that does one job and ends, such as a command. A program that saves what it has
/// opened does not call it.
pub fn protect_inputs() {
    read().get_or_insert_default();
}

/// Notes a file that is read.
pub(crate) fn note(path: &Path) {
    if let Some(read) = read().as_mut() {
        // A relative path stays right if the working folder changes.
        read.insert(std::path::absolute(path).unwrap_or_else(|_| path.to_owned()));
    }
}

/// Refuses an output that is a file that was read.
///
/// # Errors
/// [`Error::Input`].
pub(crate) fn refuse(output: &Path) -> Result<()> {
    if !output.is_file() {
        return Ok(());
    }
    let found = read().as_ref().and_then(|read| read.iter().find(|input| are_one(output, input)).cloned());
    match found {
        None => Ok(()),
        Some(input) => Err(would_overwrite(output, &input)),
    }
}

/// The error of an output that is also an input.
pub(crate) fn would_overwrite(output: &Path, input: &Path) -> Error {
    Error::input(format!(
        "{}: is {}, which this command reads and would overwrite; choose another name",
        output.display(),
        input.display()
    ))
    .of_kind(InputErrorKind::WouldOverwrite { file: input.to_owned() })
}

fn read() -> MutexGuard<'static, Option<BTreeSet<PathBuf>>> {
    READ.lock().unwrap_or_else(PoisonError::into_inner)
}
