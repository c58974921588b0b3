//! Runs the tests of the Blender extension (`integrations/blender/tests`) in each Blender that it is for. The
//! package that it brings is the one of this build.

#[path = "../package/mod.rs"]
mod package;

use rhytid_test_support::{installed, root, shared};
use std::process::Command;

/// Runs all tests in a Blender, which is Python's module `bpy`.
fn test_in(environment: &str) {
    let python = installed(&format!("{environment}/bin/python"));
    let Some(data) = shared("") else { return };
    let folder = tempfile::tempdir().unwrap();
    package::lay_out(folder.path());
    let mut command = Command::new(python);
    command.arg(root().join("integrations/blender/tests/run.py")).arg(folder.path());
    command.env("RHYTID_SHARED", data).current_dir(folder.path());
    let text = package::run(command);
    assert!(text.contains(" tests, 0 skipped"), "some tests were skipped");
}

#[test]
fn the_extension_works_in_blender_5_0() {
    test_in("venv-blender");
}

#[test]
fn the_extension_works_in_blender_4_5() {
    test_in("clients/blender-4.5");
}

#[test]
fn the_extension_works_in_blender_4_2() {
    test_in("clients/blender-4.2");
}
