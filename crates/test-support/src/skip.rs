//! Tests that do nothing here, and how they say so.
use std::io::Write;
use std::panic::Location;

/// The environment variable that makes every skip a failure, as in continuous integration.
pub const FORBID_SKIPS: &str = "RHYTID_FORBID_SKIPS";

/// Says that the test that calls this, or a part of it, is not done here: a line `SKIPPED: name: why` on standard error, which
/// `cargo xtask test` counts. The test returns after it.
///
/// # Panics
/// Where `RHYTID_FORBID_SKIPS` is set.
#[track_caller]
pub fn skip(why: &str) {
    let is_forbidden = std::env::var_os(FORBID_SKIPS).is_some_and(|value| !value.is_empty());
    assert!(!is_forbidden, "{why}, and {FORBID_SKIPS} is set");
    let (thread, caller) = (std::thread::current(), Location::caller());
    // A test's thread has its name, but where there is one thread for all.
    let name = match thread.name() {
        Some(name) if name != "main" => name.to_owned(),
        _ => format!("{}:{}", caller.file(), caller.line()),
    };
    // Straight to the stream and in one piece: the test harness hides what passing tests print.
    let _ = std::io::stderr().write_all(format!("\nSKIPPED: {name}: {why}\n").as_bytes());
}
