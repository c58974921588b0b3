//! From a face to a rig file, with progress.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 101_solve -- face.safetensors
//! ```
//! With your own scans, `rhytid::formats::project::read("FACE.toml")` gives the `Face`.
use rhytid::core::rig_file;
use rhytid::solve::{examine, solve};
use rhytid::{Progress, Result};
use std::path::PathBuf;

struct Lines;

impl Progress for Lines {
    fn report(&self, step: &'static str, done: u64, total: u64) {
        if done == total {
            println!("  {step}: done");
        }
    }
}

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("face.safetensors"), PathBuf::from);
    let face = rhytid_demo::face(9_409);
    for finding in examine(&face).findings {
        println!("{:?}: {}", finding.severity, finding.message);
    }
    let rig = solve(&face, &Lines)?.rounded()?;
    rig_file::write(&path, &rig)?;
    println!("{}: {} vertices, {} handles", path.display(), rig.vertices(), rig.handles().len());
    Ok(())
}
