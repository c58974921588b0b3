//! Data for tests that lies beside the project and is no part of it.
#![forbid(unsafe_code)]

pub mod sheet;

use std::io::Write;
use std::path::{Path, PathBuf};

/// What `../shared` beside the repository has under this path (the folder itself for ""); `None`, said loudly, where it is not there.
///
/// # Panics
/// Where it is missing and `RHYTID_REQUIRE_SHARED` is set.
pub fn shared(path: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")).join(path);
    if path.exists() {
        return Some(path);
    }
    let required = std::env::var_os("RHYTID_REQUIRE_SHARED").is_some_and(|value| !value.is_empty());
    assert!(!required, "{} is not there, but RHYTID_REQUIRE_SHARED is set", path.display());
    // Straight to the stream: the test harness hides what passing tests print.
    let _ = writeln!(
        std::io::stderr(),
        "\n*** NOT TESTED: {} is not there, so this test did nothing ***\n",
        path.display()
    );
    None
}
