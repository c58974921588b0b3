//! The library as a game links it, in a browser too.
use crate::run::{Result, cargo, output, run};
use crate::setup::WASM;

/// The runtime alone: what plays a rig on a GPU.
const RUNTIME: [&str; 5] = ["--package", "rhytid", "--no-default-features", "--features", "wgpu"];

/// What the runtime must not carry: the solve and what it stands on, and every file format but the rig's.
const NOT_AT_RUN_TIME: [&str; 9] = [
    "earcut",
    "faer",
    "gltf",
    "plotters",
    "rhytid-capture",
    "rhytid-formats",
    "rhytid-solve",
    "rstar",
    "toml",
];

/// Checks what the runtime alone depends on, and that it compiles for browsers, as the pages do without a warning.
pub(crate) fn runtime() -> Result {
    let tree = cargo(&[&["tree", "--edges", "normal", "--prefix", "none"], &RUNTIME[..]].concat());
    let tree = output(tree).ok_or("`cargo tree` failed")?;
    let mut names: Vec<&str> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
    names.sort_unstable();
    names.dedup();
    if !names.contains(&"rhytid-backend-wgpu") {
        return Err("the runtime does not depend on its backend: `cargo tree` was misread".into());
    }
    if let Some(name) = NOT_AT_RUN_TIME.iter().find(|name| names.contains(name)) {
        return Err(format!("`rhytid` with the backend wgpu alone depends on {name}"));
    }
    eprintln!("the runtime alone depends on {} crates, Rhytid's own among them", names.len() - 1);
    run(cargo(&[&["check", "--target", WASM], &RUNTIME[..]].concat()))?;
    // What is compiled for browsers alone, the lints have not seen.
    run(cargo(&["clippy", "--target", WASM, "--package", "rhytid-web", "--", "-D", "warnings"]))
}
