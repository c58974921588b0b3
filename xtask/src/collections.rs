//! `cargo xtask collections`: public collections of meshes, read by Rhytid and by other programs. It is never
//! a test.
use crate::python;
use crate::run::{Result, cargo, command, root, run};
use std::path::PathBuf;

/// What to compare.
#[derive(clap::Args)]
pub(crate) struct Collections {
    /// Only files with this in their paths.
    #[arg(long, value_name = "WORDS")]
    only: Option<String>,
    /// Write what became of each file to this file, a line of JSON each.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Fetches and makes the files, reads them, and prints the table.
pub(crate) fn collections(options: &Collections) -> Result {
    let (python, blender) = (python::collections()?, python::blender()?);
    run(cargo(&["build", "--release", "--package", "rhytid-meshes", "--example", "mesh_json"]))?;
    let mut compare = command(&python, &[]);
    compare.arg(root().join("benches/collections/compare.py"));
    compare.arg("--program").arg(root().join("target/release/examples/mesh_json"));
    compare.arg("--blender").arg(blender);
    compare.arg("--folder").arg(root().join("target/collections"));
    if let Some(words) = &options.only {
        compare.arg("--only").arg(words);
    }
    if let Some(json) = &options.json {
        compare.arg("--json").arg(json);
    }
    run(compare)
}
