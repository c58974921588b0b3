//! Whether the animations fit on the disk.

use super::speed::Speed;
use rhytid::core::human;
use std::path::Path;

/// Warns if so many frames are larger than what is free in the job's folder.
pub(super) fn check(folder: &Path, speed: &Speed, frames: usize) {
    let expected = (speed.frame_bytes * frames as f64) as u64;
    if let Some(free) = free(folder).filter(|free| *free < expected) {
        log::warn!(
            "{}: the animations need about {}, and {} are free there; make room, give --output on another disk, or \
             write less: docs/farm.md compares the kinds of files",
            folder.display(),
            human::bytes(expected),
            human::bytes(free)
        );
    }
}

/// The bytes that this user can write in a folder.
#[cfg(unix)]
fn free(folder: &Path) -> Option<u64> {
    let found = rustix::fs::statvfs(folder).ok()?;
    found.f_bavail.checked_mul(found.f_frsize)
}

#[cfg(not(unix))]
fn free(_: &Path) -> Option<u64> {
    None
}
