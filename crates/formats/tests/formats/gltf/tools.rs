//! The programs that the tests call.

use rhytid_core::{Error, InputError};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What `cargo xtask setup` has installed from npm.
fn node_folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/node");
    for package in ["gltf-validator", "three"] {
        let found = folder.join("node_modules").join(package).exists();
        assert!(found, "{}: has no {package}; run `cargo xtask setup` first", folder.display());
    }
    folder
}

/// Runs a script of this folder. It gets the folder of npm's packages, then `files`, and prints a line of
/// JSON for each.
pub(crate) fn node(script: &str, files: &[PathBuf]) -> Vec<Value> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/gltf").join(script);
    let mut lines = Vec::new();
    for files in files.chunks(256) {
        let mut command = Command::new("node");
        command.arg(&script).arg(node_folder()).args(files);
        let output = command.output().unwrap_or_else(|e| panic!("node: {e}; run `cargo xtask setup` first"));
        let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{stdout}{}", String::from_utf8_lossy(&output.stderr));
        lines.extend(stdout.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()));
    }
    assert_eq!(lines.len(), files.len());
    lines
}

/// Undoes the compression of `files` by three.js' decoder: plain GLB files beside them, whose binary parts
/// are what the compressed parts unfold to.
pub(super) fn unfold(files: &[PathBuf]) -> Vec<PathBuf> {
    node("unfold.mjs", files).iter().map(|line| line["unfolded"].as_str().unwrap().into()).collect()
}

/// The sentence of an error of the caller.
#[track_caller]
pub(super) fn input_error<T>(result: rhytid_core::Result<T>) -> String {
    refused(result).to_string()
}

/// An error of the caller.
#[track_caller]
pub(super) fn refused<T>(result: rhytid_core::Result<T>) -> InputError {
    match result {
        Err(Error::Input(error)) => error,
        Err(other) => panic!("expected an input error, found {other:?}"),
        Ok(_) => panic!("expected an input error, found success"),
    }
}

/// The `.bin` that the `.gltf` file at `path` names; its name needs no escapes behind the stem.
pub(super) fn bin_beside(path: &Path) -> PathBuf {
    let document: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let uri = document["buffers"][0]["uri"].as_str().unwrap();
    let mut parts = uri.rsplit('.');
    assert_eq!(parts.next(), Some("bin"));
    path.with_extension(format!("{}.bin", parts.next().unwrap()))
}
