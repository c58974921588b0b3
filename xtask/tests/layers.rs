//! The layers of ARCHITECTURE.md, compared with cargo's dependencies. The page is the list.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Crates outside the map: chores, examples and measurements. No crate depends on them.
const BESIDE: [&str; 7] = ["clients", "examples", "peers", "python", "xtask", "xtask-kernels", "xtask-web"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The layer of each crate, counted from the top of the list.
fn layers() -> BTreeMap<String, usize> {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let list = page.split_once("```layers\n").unwrap().1.split_once("```").unwrap().0;
    let mut layers = BTreeMap::new();
    for (layer, line) in list.lines().enumerate() {
        for name in line.split_whitespace() {
            assert!(layers.insert(name.to_owned(), layer).is_none(), "{name} is in two layers");
        }
    }
    layers
}

/// The crates of the workspace and their dependencies within it, without those of tests.
fn crates() -> BTreeMap<String, Vec<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let metadata = ["metadata", "--no-deps", "--offline", "--format-version", "1"];
    let output = Command::new(cargo).args(metadata).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    let short = |name: &Value| name.as_str().unwrap().trim_start_matches("rhytid-").to_owned();
    let packages = metadata["packages"].as_array().unwrap();
    let names: Vec<String> = packages.iter().map(|package| short(&package["name"])).collect();
    let dependencies = |package: &Value| {
        let all = package["dependencies"].as_array().unwrap().iter();
        let used = all.filter(|dependency| dependency["kind"].is_null() && !dependency["path"].is_null());
        used.map(|dependency| short(&dependency["name"])).filter(|name| names.contains(name)).collect()
    };
    packages.iter().map(|package| (short(&package["name"]), dependencies(package))).collect()
}

#[test]
fn every_crate_depends_on_layers_above_its_own_alone() {
    let (layers, crates) = (layers(), crates());
    assert!(crates.len() > 25, "{crates:?}");
    for (name, dependencies) in &crates {
        if BESIDE.contains(&name.as_str()) {
            continue;
        }
        let Some(layer) = layers.get(name) else { panic!("{name} is in no layer of ARCHITECTURE.md") };
        for dependency in dependencies {
            let above = layers.get(dependency).is_some_and(|other| other < layer);
            assert!(above, "{name} depends on {dependency}, which is not above it in ARCHITECTURE.md");
        }
    }
    for name in layers.keys() {
        assert!(crates.contains_key(name), "ARCHITECTURE.md has {name}, which is no crate");
    }
}

/// The tests that the page names for an invariant exist.
#[test]
fn what_holds_the_invariants_is_there() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    assert!(page.len() <= 9_000, "{} bytes, at most 9,000: it is a map", page.len());
    let table = page.split_once("## What must stay true").unwrap().1;
    let quoted = table.split('`').skip(1).step_by(2);
    let paths: Vec<&str> = quoted.filter(|text| text.contains('/')).collect();
    assert!(paths.len() >= 10, "{paths:?}");
    for path in paths {
        assert!(root().join(path).exists(), "{path} does not exist");
    }
}
