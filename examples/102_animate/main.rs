//! From a rig and a take to a USD or glTF file, on the fastest device that conforms, and on the next one if
//! it fails.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 102_animate -- face.usd
//! ```
use rhytid::devices::{Guard, choose_devices};
use rhytid::formats::export::{Options, Recipe};
use rhytid::playback::Performance;
use rhytid::solve::solve;
use rhytid::{NoProgress, Result};
use std::path::PathBuf;

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("face.usd"), PathBuf::from);
    // With files: rhytid::core::rig_file::read and rhytid::playback::read_take.
    let face = rhytid_demo::face(5_000);
    let rig = solve(&face, &NoProgress)?.rounded()?;
    let take = rhytid_demo::performance(&face);

    // Two seconds of the take. The file contains the recipe, which `rhytid verify` reads.
    let recipe = Recipe { end_frame: 48, ..Recipe::default() };
    let performance = Performance::new(recipe, rig, take, None)?;
    let devices = choose_devices("auto", Guard::NONE, &NoProgress)?.devices;
    let mut playback = performance.playback(&devices, &NoProgress)?;
    let written = playback.export(&performance, &path, &Options::default(), &NoProgress)?;

    let device = playback.device();
    println!("{}: {} bytes, on {} ({})", path.display(), written.bytes, device.id(), device.name);
    Ok(())
}
