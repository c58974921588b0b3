//! A newcomer's program: scans and a take become a USD file.
use rhytid::{AnimateOptions, NoProgress, TakeOptions};

fn main() -> rhytid::Result<()> {
    let face = rhytid::open_face("face.toml")?;
    let rig = rhytid::solve(&face, &NoProgress)?;
    rhytid::write_rig("face.safetensors", &rig)?;
    let take = rhytid::open_take("performance.csv", &rig, &TakeOptions::default())?;
    let written = rhytid::animate(rig, take, "face.usd", &AnimateOptions::default())?;
    println!("face.usd has {} bytes", written.bytes);
    Ok(())
}
