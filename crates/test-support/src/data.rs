//! The data beside the project, and the programs that `cargo xtask setup` installs.
use crate::skip;
use std::path::{Path, PathBuf};

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The path in `../shared` beside the repository (the folder itself for ""). `None`, with a [`skip`], if it
/// does not exist.
#[track_caller]
pub fn shared(path: &str) -> Option<PathBuf> {
    let path = root().join("../shared").join(path);
    if path.exists() {
        return Some(path);
    }
    skip(&format!("{} is not there", path.display()));
    None
}

/// A path under `target/` that `cargo xtask setup` installs.
///
/// # Panics
/// If it does not exist.
#[track_caller]
pub fn installed(path: &str) -> PathBuf {
    let path = root().join("target").join(path);
    assert!(path.exists(), "{}: not found; run `cargo xtask setup`", path.display());
    path
}

/// The Python with the current USD: `RHYTID_PYTHON`, or the one that `cargo xtask setup` installed.
///
/// # Panics
/// If it does not exist.
#[track_caller]
pub fn python() -> PathBuf {
    python_of("RHYTID_PYTHON", "venv")
}

/// The Python with the oldest tested USD: `RHYTID_PYTHON_USD_24_3`, or the one that `cargo xtask setup`
/// installed.
///
/// # Panics
/// If it does not exist.
#[track_caller]
pub fn python_usd_24_3() -> PathBuf {
    python_of("RHYTID_PYTHON_USD_24_3", "venv-usd-24.3")
}

#[track_caller]
fn python_of(variable: &str, environment: &str) -> PathBuf {
    let installed = || installed(&format!("{environment}/bin/python"));
    std::env::var_os(variable).map_or_else(installed, PathBuf::from)
}
