//! From a rig and a take to a USD file, frame by frame, with the scene described by hand.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 102_animate -- face.usd
//! ```
use rhytid_backend_cpu::Cpu;
use rhytid_core::{Animator, Backend, Error, NoProgress, Result, Stage, UploadOptions};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, Options, Provenance, Scene};
use rhytid_solve::solve;
use std::path::PathBuf;

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("face.usd"), PathBuf::from);
    let face = rhytid_demo::face(5_000);
    let take = rhytid_demo::performance(&face).slice(0..48);
    let rig = solve(&face, &NoProgress)?.cast::<f32>();
    let handles = take.handle_positions(&rig.labels)?;

    let device = Cpu::devices()?.remove(0);
    let mut animator = Animator::new(&Cpu::open(&device)?, &rig, UploadOptions::frames(take.frames()))?;
    let (mut positions, mut normals) = (Vec::new(), Vec::new());

    // At rest first: the normals of the pose that is shown where there is no time.
    let rest: Vec<f32> = rig.handles.iter().flat_map(|&v| rig.rest[v as usize]).collect();
    animator.evaluate(&rest)?;
    animator.read(Stage::LargeScaleNormals, &mut normals)?;
    let corners = rig.faces.triangle_corners(&rig.triangles);
    let corners = corners.ok_or_else(|| Error::Internal("the rig's triangles are not its faces'".into()))?;
    // How it was made; `rhytid verify` would read it.
    let provenance = Provenance::default();
    let scene = Scene {
        rest_normals: Some(normals.as_chunks().0),
        frames: take.frames(),
        rate: take.rate(),
        ..Scene::of(&rig, &corners, &provenance)
    };
    let mut exporter = animation::create(&path, &scene, &Options::default())?;
    animator.evaluate(&handles)?;
    animator.read(Stage::Positions, &mut positions)?;
    animator.read(Stage::Normals, &mut normals)?;
    let frame = 3 * rig.vertices();
    for (positions, normals) in positions.chunks_exact(frame).zip(normals.chunks_exact(frame)) {
        exporter.frame(Frame { positions, normals: Some(normals), velocities: None })?;
    }
    let written = exporter.finish(&NoProgress)?;
    println!("{}: {} frames, {} bytes", path.display(), take.frames(), written.bytes);
    Ok(())
}
