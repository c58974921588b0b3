//! Skips: tests that do nothing here report this.
use std::io::Write;
use std::panic::Location;

/// The environment variable that makes every skip a failure, as in continuous integration.
pub const FORBID_SKIPS: &str = "RHYTID_FORBID_SKIPS";

/// Reports that the calling test, or a part of it, is skipped here.
///
/// It writes a line `SKIPPED: name: why` to standard error, which `cargo xtask test` counts. The test returns
/// after it.
///
/// # Panics
/// Where `RHYTID_FORBID_SKIPS` is set.
#[track_caller]
pub fn skip(why: &str) {
    let is_forbidden = std::env::var_os(FORBID_SKIPS).is_some_and(|value| !value.is_empty());
    assert!(!is_forbidden, "{why}, and {FORBID_SKIPS} is set");
    let (thread, caller) = (std::thread::current(), Location::caller());
    // A test's thread has the test's name, unless all tests share one thread.
    let name = match thread.name() {
        Some(name) if name != "main" => name.to_owned(),
        _ => format!("{}:{}", caller.file(), caller.line()),
    };
    // Written directly to the stream and in one piece, because the test harness hides the output of passing
    // tests.
    let _ = std::io::stderr().write_all(format!("\nSKIPPED: {name}: {why}\n").as_bytes());
}
