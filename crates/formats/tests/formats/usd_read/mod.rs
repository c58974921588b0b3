//! USD files read back: those of USD's own library as it reads them, our own bit for bit, damaged ones
//! without harm. The programs come from `cargo xtask setup`.

mod damaged;
mod foreign;
mod hostile;
mod json;
mod own;

use rhytid_test_support::{python, root};
use std::path::Path;
use std::process::Command;

/// Runs `script` of this folder, with USD's library writing crate files of `version` into `folder`.
fn make(folder: &Path, version: &str, more: &[&str]) {
    let mut command = Command::new(python());
    command.arg(root().join("crates/formats/tests/formats/usd_read/make.py")).arg(folder).args(more);
    command.env("USD_WRITE_NEW_USDC_FILES_AS_VERSION", version);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
