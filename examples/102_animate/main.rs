//! From a rig and a take to a USD file, frame by frame, with the scene described by hand.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 102_animate -- face.usda
//! ```
use rhytid_backend_cpu::Cpu;
use rhytid_core::{Animator, Backend, Error, NoProgress, Result, Stage, UploadOptions, solve};
use rhytid_formats::export::{self, Scene};
use std::path::PathBuf;

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("face.usda"), PathBuf::from);
    let face = rhytid_demo::face(5_000);
    let take = rhytid_demo::performance(&face).slice(0..48);
    let rig = solve(&face, &NoProgress)?.cast::<f32>();
    let handles = take.handle_positions(&rig.labels)?;

    let device = Cpu::devices()?.remove(0);
    let mut animator = Animator::new(&Cpu::open(&device)?, &rig, UploadOptions::frames(take.frames()))?;
    let (mut positions, mut normals) = (Vec::new(), Vec::new());

    // At rest first: GLB stores its frames as differences from there.
    let rest: Vec<f32> = rig.handles.iter().flat_map(|&v| rig.rest[v as usize]).collect();
    animator.evaluate(&rest)?;
    animator.read(Stage::LargeScaleNormals, &mut normals)?;
    let corners = rig.faces.triangle_corners(&rig.triangles);
    let corners = corners.ok_or_else(|| Error::Internal("the rig's triangles are not its faces'".into()))?;
    let scene = Scene {
        name: &rig.name,
        rest: &rig.rest,
        rest_normals: normals.as_chunks().0,
        faces: &rig.faces,
        triangle_corners: &corners,
        uvs: rig.uvs.as_ref(),
        metres_per_unit: rig.metres_per_unit,
        up_axis: rig.up_axis,
        frames: take.frames(),
        rate: take.rate(),
        first_time_code: 0.0,
    };
    let mut exporter = export::create(&path, &scene)?;
    animator.evaluate(&handles)?;
    animator.read(Stage::Positions, &mut positions)?;
    animator.read(Stage::Normals, &mut normals)?;
    let frame = 3 * rig.vertices();
    for (positions, normals) in positions.chunks_exact(frame).zip(normals.chunks_exact(frame)) {
        exporter.frame(positions, normals)?;
    }
    exporter.finish()?;
    println!("{}: {} frames", path.display(), take.frames());
    Ok(())
}
