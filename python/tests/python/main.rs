//! The Python package: its tests, its types, its examples and its notebooks.
//!
//! The compiled half is the one that cargo built for this test. It is laid beside a copy of the Python half,
//! as a wheel would have it. `cargo xtask python` tests a real wheel.

#[path = "../package/mod.rs"]
mod package;

use rhytid_test_support::{installed, root};
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

/// The package in a folder of its own.
struct Package {
    folder: tempfile::TempDir,
    python: PathBuf,
}

/// The package, made once for all tests.
fn package() -> &'static Package {
    static PACKAGE: OnceLock<Package> = OnceLock::new();
    PACKAGE.get_or_init(make)
}

fn make() -> Package {
    let python = installed("venv-python/bin/python");
    let folder = tempfile::tempdir().unwrap();
    let source = root().join("python");
    package::lay_out(folder.path());
    package::copy(&source.join("tests"), &folder.path().join("tests"));
    for name in ["stubs.py", "pyproject.toml"] {
        fs::copy(source.join(name), folder.path().join(name)).unwrap();
    }
    Package { folder, python }
}

impl Package {
    /// Runs Python in the package's folder. What it prints is shown if it fails.
    fn run(&self, arguments: &[&str]) {
        let mut command = Command::new(&self.python);
        command.args(arguments).current_dir(self.folder.path()).env("PYTHONPATH", self.folder.path());
        package::run(command);
    }
}

#[test]
fn its_tests_pass() {
    package().run(&["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests"]);
}

#[test]
fn the_types_of_options_are_those_of_the_program() {
    package().run(&["stubs.py", "--check"]);
}

#[test]
fn types_are_right_by_mypy_and_pyright() {
    let package = package();
    let cache = package.folder.path().join("mypy");
    package.run(&[
        "-m",
        "mypy",
        "--strict",
        "--cache-dir",
        cache.to_str().unwrap(),
        "tests/typed.py",
        "rhytid",
    ]);
    let pyright = installed("node/node_modules/.bin/pyright");
    let mut command = Command::new(pyright);
    command.arg("--pythonpath").arg(&package.python).args(["-p", "."]).current_dir(package.folder.path());
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}

/// Each notebook is run from nothing, in a folder of its own.
#[test]
fn notebooks_run() {
    let package = package();
    let mut found = 0;
    for entry in fs::read_dir(root().join("python/notebooks")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "ipynb") {
            package.run(&["tests/notebook.py", path.to_str().unwrap()]);
            found += 1;
        }
    }
    assert_eq!(found, 2);
}
