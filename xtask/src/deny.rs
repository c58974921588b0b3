//! `cargo xtask deny`: licences, duplicate versions, sources and advisories of all dependencies (`deny.toml`).
use crate::advisories;
use crate::run::{Result, cargo, run, succeeds};

/// As [`deny`], with cargo-deny where that is there: it takes longer to build than all of the tests do.
pub(crate) fn deny_where_installed() -> Result {
    advisories::lock_files()?;
    if !is_installed() {
        eprintln!(
            "!! cargo-deny is not installed: licences, versions and newer advisories were NOT checked."
        );
        return Ok(());
    }
    with_cargo_deny()
}

/// Checks the lock files, and with cargo-deny everything; without a network, all but the newest advisories.
pub(crate) fn deny() -> Result {
    advisories::lock_files()?;
    if !is_installed() {
        return Err("the rest needs cargo-deny: run `cargo install cargo-deny --locked`".into());
    }
    with_cargo_deny()
}

fn is_installed() -> bool {
    succeeds(cargo(&["deny", "--version"]))
}

fn with_cargo_deny() -> Result {
    run(cargo(&["deny", "check", "licenses", "bans", "sources"]))?;
    if !succeeds(cargo(&["deny", "fetch", "db"])) {
        eprintln!("!! The advisory database cannot be reached: newer advisories were NOT checked.");
        return Ok(());
    }
    run(cargo(&["deny", "check", "advisories"]))
}
