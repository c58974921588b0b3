//! The Python package in a folder of its own: the Python half, and beside it the compiled half that Cargo
//! built, as a wheel would have them.

use rhytid_test_support::root;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Copies the package `rhytid` into `folder`.
pub(crate) fn lay_out(folder: &Path) {
    copy(&root().join("python/rhytid"), &folder.join("rhytid"));
    let deps = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let compiled =
        deps.join(format!("{}_rhytid{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX));
    fs::copy(&compiled, folder.join("rhytid/_rhytid.abi3.so")).unwrap();
}

/// Copies the files of a folder that belong to Python.
pub(crate) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let is_ours = path.extension().is_some_and(|e| ["py", "pyi", "typed"].iter().any(|ours| e == *ours));
        if path.is_file() && is_ours {
            fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
        }
    }
}

/// Runs Python. What it prints is shown if it fails. It is returned.
#[track_caller]
pub(crate) fn run(mut command: Command) -> String {
    command.env("RHYTID_ROOT", root()).env("PYTHONDONTWRITEBYTECODE", "1");
    let output = command.output().unwrap();
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let text = text.concat();
    println!("{text}");
    let words: Vec<_> = command.get_args().map(|word| word.to_string_lossy()).collect();
    assert!(output.status.success(), "python {} failed", words.join(" "));
    text
}
