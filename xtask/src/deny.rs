//! `cargo xtask deny`: licences, duplicate versions, sources and advisories of all dependencies (`deny.toml`).
use crate::run::{Result, cargo, run, succeeds};

/// Checks with cargo-deny; without a network, all but the advisories.
pub(crate) fn deny() -> Result {
    if !succeeds(cargo(&["deny", "--version"])) {
        return Err("this needs cargo-deny: run `cargo install cargo-deny --locked`".into());
    }
    run(cargo(&["deny", "check", "licenses", "bans", "sources"]))?;
    if !succeeds(cargo(&["deny", "fetch", "db"])) {
        eprintln!("!! The advisory database cannot be reached: advisories were NOT checked.");
        return Ok(());
    }
    run(cargo(&["deny", "check", "advisories"]))
}
