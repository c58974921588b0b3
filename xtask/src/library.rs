//! The library as a game links it, also in a browser.
use crate::run::{Result, cargo, output, run};
use crate::setup::WASM;

/// The runtime alone: the crates that play a rig on a GPU.
const RUNTIME: [&str; 5] = ["--package", "rhytid", "--no-default-features", "--features", "wgpu"];

/// The C interface with as little as possible.
const C_INTERFACE: [&str; 5] = ["--package", "rhytid-capi", "--no-default-features", "--features", "wgpu"];

/// The runtime's own crates. Any other crate of Rhytid's, such as a solver or a file format, is an error.
const OF_THE_RUNTIME: [&str; 5] =
    ["rhytid", "rhytid-backend-wgpu", "rhytid-core", "rhytid-devices", "rhytid-kernels"];

/// Dependencies of the other crates, which the runtime must not have either.
const NOT_AT_RUN_TIME: [&str; 6] = ["earcut", "faer", "gltf", "plotters", "rstar", "toml"];

/// Checks the dependencies of the runtime alone, and that it compiles for browsers. The test of the pages
/// compiles these for browsers, and allows no warning.
pub(crate) fn runtime() -> Result {
    let tree = cargo(&[&["tree", "--edges", "normal", "--prefix", "none"], &RUNTIME[..]].concat());
    let tree = output(tree).ok_or("`cargo tree` failed")?;
    let mut names: Vec<&str> = tree.lines().filter_map(|line| line.split(' ').next()).collect();
    names.sort_unstable();
    names.dedup();
    if !names.contains(&"rhytid-backend-wgpu") {
        return Err("the runtime does not depend on its backend: `cargo tree` was misread".into());
    }
    let is_too_much = |name: &&&str| {
        NOT_AT_RUN_TIME.contains(name) || (name.starts_with("rhytid") && !OF_THE_RUNTIME.contains(name))
    };
    if let Some(name) = names.iter().find(is_too_much) {
        return Err(format!("`rhytid` with the backend wgpu alone depends on {name}"));
    }
    eprintln!("the runtime alone depends on {} crates, Rhytid's own among them", names.len() - 1);
    run(cargo(&[&["check", "--target", WASM], &RUNTIME[..]].concat()))?;
    // What the C interface says of what is left out. Here, all but this crate is compiled already.
    run(cargo(&[&["check", "--target", WASM], &C_INTERFACE[..]].concat()))
}
