//! A newcomer's game: every frame a handle moves, and the face is read to be drawn.
use rhytid::{AnimatorOptions, Stage};

fn main() -> rhytid::Result<()> {
    let rig = rhytid::open_rig("face.safetensors")?;
    let mut animator = rhytid::animator(&rig, &AnimatorOptions::default())?;
    let mut handles = rig.handles().rest.clone();
    let vertex = rig.handles().points[0].nearest_vertex().index();
    let mut positions = Vec::new();
    for frame in 0..60 {
        handles[0][1] += 0.01;
        animator.evaluate(handles.as_flattened())?;
        animator.read(Stage::Positions, &mut positions)?;
        println!("frame {frame}: the first marker is met at {:?}", &positions[3 * vertex..][..3]);
    }
    Ok(())
}
