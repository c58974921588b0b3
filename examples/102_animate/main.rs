//! From a rig and a take to a USD or glTF file, on the fastest device that conforms, and on the next one if it fails.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 102_animate -- face.usd
//! ```
use rhytid::formats::export::{Options, Provenance};
use rhytid::playback::{Guard, Playback, PlaybackOptions, Selection, choose_devices};
use rhytid::solve::solve;
use rhytid::{NoProgress, Result};
use std::path::PathBuf;

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("face.usd"), PathBuf::from);
    // With files: rhytid::rig_file::read and rhytid::playback::read_take.
    let face = rhytid_demo::face(5_000);
    let rig = solve(&face, &NoProgress)?.cast::<f32>();
    let take = rhytid_demo::performance(&face);

    // Two seconds of it. Velocities would need the frames before and after: true in place of false.
    let selection = Selection::new(take, 0..48, None, false)?;
    let devices = choose_devices("auto", Guard::NONE, &NoProgress)?.devices;
    let mut playback = Playback::new(&rig, &devices, selection.take.frames())?;
    // How it was made, in the file: `rhytid verify` would read it.
    let provenance = Provenance::default();
    let (wanted, options) = (PlaybackOptions::default(), Options::default());
    let written = playback.export(&selection, wanted, &path, &options, &provenance, &NoProgress)?;

    let device = playback.device();
    println!("{}: {} bytes, on {} ({})", path.display(), written.bytes, device.id(), device.name);
    Ok(())
}
