//! What a game does: upload a rig once, then send only marker positions, one frame at a time.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 103_host_application -- 530000
//! ```
use rhytid::core::Backend;
use rhytid::devices::cpu::Cpu;
use rhytid::solve::solve;
use rhytid::{Animator, NoProgress, Result, Stage, UploadOptions};
use std::time::Instant;

fn main() -> Result<()> {
    let vertices = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(9_409);
    let face = rhytid_demo::face(vertices);
    let take = rhytid_demo::performance(&face);
    let rig = solve(&face, &NoProgress)?.rounded()?;
    let handles = take.handle_positions(&rig.handles().labels)?;

    let device = Cpu::devices()?.remove(0);
    let mut animator = Animator::new(&Cpu::open(&device)?, &rig, UploadOptions::frames(1))?;
    println!("{} vertices on {} ({})", rig.vertices(), device.id(), device.name);

    let mut positions = Vec::new();
    let start = Instant::now();
    for frame in handles.chunks_exact(3 * rig.handles().len()) {
        animator.evaluate(frame)?;
        animator.read(Stage::Positions, &mut positions)?;
    }
    let each = start.elapsed() / take.frames() as u32;
    println!("{} frames of {} markers, {each:.2?} each", take.frames(), rig.handles().len());
    Ok(())
}
