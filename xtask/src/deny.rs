//! `cargo xtask deny`: licences, duplicate versions, sources and advisories of all dependencies (`deny.toml`).
use crate::run::{Result, cargo, run, succeeds};

/// As [`deny`] where cargo-deny is there: it takes longer to build than all of the tests do.
pub(crate) fn deny_where_installed() -> Result {
    if !is_installed() {
        eprintln!("!! cargo-deny is not installed: licences, versions and advisories were NOT checked.");
        return Ok(());
    }
    deny()
}

fn is_installed() -> bool {
    succeeds(cargo(&["deny", "--version"]))
}

/// Checks with cargo-deny; without a network, all but the advisories.
pub(crate) fn deny() -> Result {
    if !is_installed() {
        return Err("this needs cargo-deny: run `cargo install cargo-deny --locked`".into());
    }
    run(cargo(&["deny", "check", "licenses", "bans", "sources"]))?;
    if !succeeds(cargo(&["deny", "fetch", "db"])) {
        eprintln!("!! The advisory database cannot be reached: advisories were NOT checked.");
        return Ok(());
    }
    run(cargo(&["deny", "check", "advisories"]))
}
