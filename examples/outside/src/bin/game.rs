//! A newcomer's game: every frame handles move, and the face is read to be drawn.
use rhytid::{AnimatorOptions, Stage};

fn main() -> rhytid::Result<()> {
    let rig = rhytid::open_rig("face.safetensors")?;
    let mut animator = rhytid::animator(&rig, &AnimatorOptions::default())?;
    let mut handles = rig.handles().rest.clone();
    let mut positions = Vec::new();
    for frame in 0..60 {
        handles[0][1] += 0.01;
        animator.evaluate(handles.as_flattened())?;
        animator.read(Stage::Positions, &mut positions)?;
        println!("frame {frame}: vertex 0 is at {:?}", &positions[..3]);
    }
    Ok(())
}
