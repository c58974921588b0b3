//! `cargo xtask deny`: licences, duplicate versions, sources and advisories of all dependencies, by
//! cargo-deny (`deny.toml`).
use crate::run::{Result, cargo, run, succeeds};

/// As [`deny`], if cargo-deny is installed. It takes longer to build than all of the tests.
pub(crate) fn deny_where_installed() -> Result {
    if !is_installed() {
        eprintln!(
            "!! cargo-deny is not installed: licences, versions, sources and advisories were NOT checked. \
             `cargo install cargo-deny --locked` and `cargo xtask deny` check them."
        );
        return Ok(());
    }
    deny()
}

/// Checks everything. If the database of advisories cannot be reached, checks everything else, with a
/// message.
///
/// # Errors
/// The findings of cargo-deny, or that it is not installed.
pub(crate) fn deny() -> Result {
    if !is_installed() {
        return Err("this needs cargo-deny: run `cargo install cargo-deny --locked`".into());
    }
    run(cargo(&["deny", "check", "licenses", "bans", "sources"]))?;
    if !succeeds(cargo(&["deny", "fetch", "db"])) {
        eprintln!(
            "!! The database of advisories cannot be reached: advisories were NOT checked. \
             Run `cargo xtask deny` on a machine that reaches github.com."
        );
        return Ok(());
    }
    run(cargo(&["deny", "check", "advisories"]))?;
    run(cargo(&[
        "deny",
        "--manifest-path",
        "fuzz/Cargo.toml",
        "check",
        "--config",
        "deny.toml",
        "advisories",
    ]))
}

fn is_installed() -> bool {
    succeeds(cargo(&["deny", "--version"]))
}
