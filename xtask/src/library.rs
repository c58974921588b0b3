//! The library as others use it: what a game links, in a browser too, and a newcomer's crate outside the workspace.
use crate::package;
use crate::run::{Result, cargo, command, copy, output, root, run};
use crate::setup::WASM;
use std::fs;

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

/// Checks what the runtime alone depends on, and that it compiles for browsers.
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
    run(cargo(&[&["check", "--target", WASM], &RUNTIME[..]].concat()))
}

/// Builds the newcomer's crate and runs it on a demo face, which the program makes; after [`crate::programs::build`].
pub(crate) fn newcomer() -> Result {
    let (target, outside) = (root().join("target"), root().join("examples/outside"));
    let demo = target.join("outside");
    let io = |e: std::io::Error| format!("{}: {e}", demo.display());
    fs::create_dir_all(&demo).map_err(io)?;
    // The program that the tests have built: for itself alone, cargo would build it with other features of its dependencies.
    let mut make = command(target.join("debug/rhytid"), &["--quiet", "demo", "--vertices", "2000"]);
    make.arg(&demo);
    run(make)?;

    // The versions that are compiled already, in the profile in which they are.
    copy(&root().join("Cargo.lock"), &outside.join("Cargo.lock"))?;
    let mut build = cargo(&["build", "--quiet", "--manifest-path"]);
    build.arg(outside.join("Cargo.toml")).arg("--target-dir").arg(&target);
    let profiles = demo.join("profiles.toml");
    fs::write(&profiles, package::profiles()?).map_err(io)?;
    build.arg("--config").arg(profiles);
    run(build)?;

    let mut play = std::process::Command::new(target.join("debug/outside"));
    play.current_dir(&demo);
    let said = output(play).ok_or("examples/outside failed")?;
    eprintln!("{said}");
    let take = fs::read_to_string(demo.join("performance.csv")).map_err(io)?;
    let frames = take.lines().count() - 1;
    if said.starts_with(&format!("{frames} frames of ")) && !said.contains("by 0.000") {
        return Ok(());
    }
    Err(format!("examples/outside: expected {frames} frames that move, found “{said}”"))
}
