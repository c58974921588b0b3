//! Tells the report which commit it is about.
use std::path::Path;
use std::process::Command;

fn main() {
    let commit = Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output().ok();
    let commit = commit.filter(|output| output.status.success());
    let commit = commit.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    let commit = commit.filter(|commit| !commit.is_empty()).unwrap_or_else(|| "unknown".into());
    println!("cargo::rustc-env=RHYTID_COMMIT={commit}");
    println!("cargo::rerun-if-changed=build.rs");
    // Every commit is written there. Where it is missing, cargo would build anew each time.
    let log = Path::new("../.git/logs/HEAD");
    if log.exists() {
        println!("cargo::rerun-if-changed={}", log.display());
    }
}
