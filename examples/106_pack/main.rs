//! A rig file made small, to send it.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 106_pack -- face.safetensors small.safetensors 0.05
//! ```
//! The last number is how far a vertex may be off, in millimetres. Every command reads the small file as it
//! reads any rig.
use rhytid::core::rig_file;
use rhytid::devices::{Guard, choose_devices};
use rhytid::{Error, NoProgress, Result, playback};
use std::path::Path;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [rig_path, small, millimetres] = &words[..] else {
        eprintln!("give a rig file, the file to write, and a number of millimetres");
        std::process::exit(2);
    };
    let rig = rig_file::read(Path::new(rig_path))?;
    let unit = 1e3 * rig.surface().metres_per_unit;
    let max_error = millimetres.parse::<f64>().expect("a number of millimetres") / unit;
    let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress)?.devices;
    let packed = playback::pack(&rig, &[], max_error, &devices, &NoProgress)?;
    std::fs::write(small, &packed.bytes).map_err(Error::io(Path::new(small)))?;
    println!(
        "{small}: {} bytes, {:.0} a vertex; off by {:.4} mm at most and {:.4} mm RMS, normals by {:.2}° RMS",
        packed.bytes.len(),
        packed.bytes.len() as f64 / rig.vertices() as f64,
        packed.packing.worst * unit,
        packed.packing.rms * unit,
        packed.packing.normals
    );
    Ok(())
}
