//! Test data that lies beside the project and is not part of it.
#![allow(dead_code, reason = "every test binary uses a part of it")]
use std::io::Write;
use std::path::PathBuf;

/// The folder `../shared` beside the repository, or `None`, said loudly, where it is not there.
///
/// # Panics
/// Where it is missing and `RHYTID_REQUIRE_SHARED` is set.
pub fn shared() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared"));
    if folder.is_dir() {
        return Some(folder);
    }
    let required = std::env::var_os("RHYTID_REQUIRE_SHARED").is_some_and(|v| !v.is_empty());
    assert!(!required, "{} is not there, but RHYTID_REQUIRE_SHARED is set", folder.display());
    // Written past the test harness, which would keep it to itself.
    let _ = writeln!(
        std::io::stderr(),
        "\n*** NOT TESTED: {} is not there, so this test did nothing ***\n",
        folder.display()
    );
    None
}
