//! Tells the report the commit of the build.
use std::fs;
use std::path::Path;
use std::process::Command;

fn main() {
    // In a published package, cargo has left the commit here.
    let packaged = Path::new(".cargo_vcs_info.json");
    let commit = if packaged.exists() { of_package(packaged) } else { of_checkout() };
    println!("cargo::rustc-env=RHYTID_COMMIT={}", commit.unwrap_or_else(|| "unknown".into()));
    println!("cargo::rerun-if-changed=build.rs");
    // Every commit is written there. If the file is missing, it must not be watched: cargo would build anew
    // each time.
    let log = Path::new("../.git/logs/HEAD");
    if log.exists() {
        println!("cargo::rerun-if-changed={}", log.display());
    }
}

/// The first twelve digits of `{"git": {"sha1": "…"}}`.
fn of_package(file: &Path) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let digits = text.split_once("\"sha1\"")?.1.split('"').nth(1)?;
    digits.get(..12).map(str::to_owned)
}

/// The commit that git reports, if this is the project's own checkout and not a copy inside another one.
fn of_checkout() -> Option<String> {
    if !Path::new("../.git").exists() {
        return None;
    }
    let output = Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output().ok()?;
    let commit = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (output.status.success() && !commit.is_empty()).then_some(commit)
}
