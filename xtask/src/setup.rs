//! `cargo xtask setup`: the needs of the tests beyond Rust. It installs only what is missing, so that a
//! second run takes a moment.
use crate::run::{Result, command, copy, output, root, run, same_text, succeeds};
use crate::{debian, python};
use std::fs;
use std::path::Path;

/// The oldest Node.js on which the glTF validator is known to run.
const OLDEST_NODE: u32 = 18;

/// Rust's name for WebAssembly in browsers.
pub(crate) const WASM: &str = "wasm32-unknown-unknown";

/// Installs system packages, then the Python packages into environments under `target/`, the npm packages
/// into `target/node`, and Rust's target for browsers.
pub(crate) fn setup() -> Result {
    system_packages()?;
    debian::swiftshader()?;
    python::python_packages()?;
    node_packages()?;
    wasm_target()
}

fn system_packages() -> Result {
    let mut missing = Vec::new();
    if !succeeds(command("python3", &["-c", "import venv, ensurepip"])) {
        missing.extend(["python3", "python3-venv"]);
    }
    if !succeeds(command("node", &["--version"])) {
        missing.push("nodejs");
    }
    if !succeeds(command("npm", &["--version"])) {
        missing.push("npm");
    }
    missing.extend(debian::missing_packages());
    if !missing.is_empty() {
        debian::install(&missing)?;
    }
    let version = output(command("node", &["--version"])).unwrap_or_default();
    let major = version.trim_start_matches('v').split('.').next().and_then(|n| n.parse::<u32>().ok());
    match major {
        Some(major) if major >= OLDEST_NODE => Ok(()),
        _ => Err(format!(
            "the glTF validator needs Node.js {OLDEST_NODE} or newer, found “{version}”; install a newer one"
        )),
    }
}

/// The target that pages are built for.
fn wasm_target() -> Result {
    let libraries = output(command("rustc", &["--print", "target-libdir", "--target", WASM]));
    if libraries.is_some_and(|folder| Path::new(&folder).is_dir()) {
        return Ok(());
    }
    if !succeeds(command("rustup", &["--version"])) {
        return Err(format!(
            "Rust's target {WASM} is missing, and there is no rustup here: install it as you installed Rust, \
             then try again"
        ));
    }
    run(command("rustup", &["target", "add", WASM]))
}

fn node_packages() -> Result {
    let folder = root().join("target/node");
    let wanted = root().join("xtask/node");
    // Written last, so that it stands for a finished installation.
    let installed = folder.join("installed.json");
    if same_text(&wanted.join("package-lock.json"), &installed) {
        return Ok(());
    }
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for name in ["package.json", "package-lock.json"] {
        copy(&wanted.join(name), &folder.join(name))?;
    }
    let mut install = command("npm", &["ci", "--no-audit", "--no-fund"]);
    install.current_dir(&folder);
    run(install)
        .map_err(|e| format!("{e}: the packages of xtask/node/package.json could not be installed"))?;
    copy(&wanted.join("package-lock.json"), &installed)
}
