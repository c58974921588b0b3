//! A face that plays in a program's own pass, drawn by Rhytid's renderer on the program's own device.
//! Only the handles cross to the device. The program writes the last frame as a picture. `host.rs` has the
//! parts that a program with wgpu already has.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 105_render -- face.png
//! ```
mod host;

use host::Host;
use rhytid::devices::wgpu::Wgpu;
use rhytid::render::{Camera, Look, Offscreen, Picture, Renderer, Target, Vertices, View};
use rhytid::solve::solve;
use rhytid::{Animator, NoProgress, Stage, UploadOptions};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).unwrap_or_else(|| "face.png".into());
    let face = rhytid_demo::face(60_000);
    let take = rhytid_demo::performance(&face);
    let rig = solve(&face, &NoProgress)?.rounded()?;
    let handles = take.handle_positions(&rig.handles().labels)?;

    let target = Target { samples: 1, ..Offscreen::TARGET };
    let host = Host::open(target, [600, 800])?;
    let rhytid = Wgpu::from_device(host.device.clone(), host.queue.clone())?;
    let mut animator = Animator::new(&rhytid, &rig, UploadOptions::frames(1))?;
    let mut renderer =
        Renderer::new(&host.device, &host.queue, &rig.surface().faces, &rig.surface().triangles, target)?;
    let view = View { turn: 25.0, ..View::default() };
    let camera = Camera::framing(&rig.surface().rest, rig.surface().up_axis, view, 0.75);

    // Once a frame: send the markers, then draw from the buffers that hold the results.
    for frame in handles.chunks(3 * rig.handles().len()).take(80) {
        animator.evaluate(frame)?;
        renderer.show(&camera, 0.75, Look::Smooth);
        host.frame(|pass| {
            let results =
                |stage| animator.session().results(stage).next().map(|(_, buffer)| buffer.slice(..));
            let (positions, normals) = (results(Stage::Positions), results(Stage::Normals));
            let (positions, normals) = positions.zip(normals).ok_or("nothing was evaluated")?;
            renderer.draw(pass, Vertices { positions, normals, numbers: None })?;
            Ok::<(), Box<dyn Error>>(())
        })?;
    }
    std::fs::write(&path, Picture::read(&host.device, &host.queue, &host.color)?.png()?)?;
    println!("{}: drawn on {}", path.display(), host.device.adapter_info().name);
    Ok(())
}
