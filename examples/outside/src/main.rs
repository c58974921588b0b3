//! A newcomer's program: loads a rig, takes any device, plays a take and reads positions.
use rhytid::formats::export::Recipe;
use rhytid::formats::take::Missing;
use rhytid::devices::{Guard, choose_devices};
use rhytid::playback::{CleanUp, Performance, read_take};
use rhytid::{NoProgress, Result, rig_file};
use std::path::Path;

fn main() -> Result<()> {
    let rig = rig_file::read(Path::new("face.safetensors"))?;
    let take = read_take(Path::new("performance.csv"), &rig, Missing::Error, &CleanUp::default(), &NoProgress)?;
    let performance = Performance::new(Recipe::default(), rig, take, None)?;
    let devices = choose_devices("auto", Guard::NONE, &NoProgress)?.devices;
    let mut playback = performance.playback(&devices, &NoProgress)?;
    let (rig, mut frames, mut farthest) = (&performance.rig, 0, 0.0_f32);
    playback.play(&performance.selection, &performance.recipe, &NoProgress, |frame| {
        let moved = frame.positions().iter().zip(rig.rest.as_flattened()).map(|(x, rest)| (x - rest).abs());
        farthest = moved.fold(farthest, f32::max);
        frames += 1;
        Ok(())
    })?;
    println!("{frames} frames of {} vertices, which move by {farthest:.3} at the most", rig.vertices());
    Ok(())
}
