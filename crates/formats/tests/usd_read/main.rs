//! USD files read back: those of USD's own library as it reads them, our own bit for bit, damaged ones without harm.
//! The programs come from `cargo xtask setup`.
#![allow(unused_crate_dependencies)]

#[path = "../export/animation.rs"]
#[allow(dead_code, reason = "the exporters' tests use all of it")]
mod animation;
mod damaged;
mod foreign;
mod hostile;
mod json;
mod own;

use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs `script` of this folder, with USD's library writing crate files of `version` into `folder`.
fn make(folder: &Path, version: &str, more: &[&str]) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let python =
        std::env::var_os("RHYTID_PYTHON").map_or_else(|| root.join("target/venv/bin/python"), PathBuf::from);
    assert!(python.exists(), "{}: not found; run `cargo xtask setup` first", python.display());
    let mut command = Command::new(python);
    command.arg(root.join("crates/formats/tests/usd_read/make.py")).arg(folder).args(more);
    command.env("USD_WRITE_NEW_USDC_FILES_AS_VERSION", version);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
