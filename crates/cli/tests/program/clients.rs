//! Exports, opened by the quick half of the programs in `docs/clients.md`. No row may be worse than there.

use rhytid_test_support::installed;
use std::path::Path;
use std::process::Command;

#[test]
fn other_programs_read_exports_as_the_table_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let program = Path::new(env!("CARGO_BIN_EXE_rhytid"));
    // An example of another package, which `cargo test --workspace` builds.
    let gltf_crate = program.with_file_name("examples").join("gltf_crate");
    assert!(gltf_crate.exists(), "run `cargo build --package rhytid-clients --examples`");
    let python = installed("clients/python/bin/python");
    let mut measure = Command::new(&python);
    measure.arg(root.join("benches/clients/clients.py")).args(["--quick", "--check"]);
    measure.arg("--program").arg(program).arg("--python").arg(&python).arg("--gltf-crate").arg(gltf_crate);
    measure.arg("--node").arg(installed("node")).arg("--page").arg(root.join("docs/clients.md"));
    let output = measure.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
