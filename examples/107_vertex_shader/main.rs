//! A face whose vertices are computed by the shaders that draw them, beside one that kernels compute first.
//! The first way needs no compute shaders and no storage buffers. So WebGL 2 is enough for it.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 107_vertex_shader -- 60000 vertex_shader.png
//! ```
//!
//! The environment's `WGPU_ADAPTER_NAME` and `WGPU_BACKEND` choose the device.
#[path = "../105_render/host.rs"]
mod host;

use host::Host;
use rhytid::core::BasisStorage;
use rhytid::core::plan::{Plan, PlanLimits};
use rhytid::devices::wgpu::Wgpu;
use rhytid::render::{Camera, Look, Offscreen, Picture, Renderer, Target, Vertices, View};
use rhytid::solve::solve;
use rhytid::{Animator, NoProgress, Stage, UploadOptions};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let vertices = args.next().map_or(Ok(60_000), |n| n.parse())?;
    let path = args.next().unwrap_or_else(|| "vertex_shader.png".to_owned());
    let face = rhytid_demo::face(vertices);
    let take = rhytid_demo::performance(&face);
    let rig = solve(&face, &NoProgress)?.rounded()?;
    let handles = take.handle_positions(&rig.handles().labels)?;
    let frames: Vec<&[f32]> = handles.chunks(3 * rig.handles().len()).take(40).collect();

    let target = Target { samples: 1, ..Offscreen::TARGET };
    let host = Host::open(target, [600, 800])?;
    let surface = rig.surface();
    let camera =
        Camera::framing(&surface.rest, surface.up_axis, View { turn: 25.0, ..View::default() }, 0.75);
    let new = || Renderer::new(&host.device, &host.queue, &surface.faces, &surface.triangles, target);
    println!("{}, {} vertices", host.device.adapter_info().name, rig.vertices());
    println!("{:<38} {:>12} {:>14}", "", "ms per frame", "MB in all");
    let row = |way: &str, begin: Instant, bytes: u64| -> Result<(), Box<dyn Error>> {
        // Reading the picture waits for all frames.
        let picture = Picture::read(&host.device, &host.queue, &host.color)?;
        let ms = begin.elapsed().as_secs_f64() * 1e3 / frames.len() as f64;
        println!("{way:<38} {ms:>12.2} {:>14.1}", bytes as f64 / 1e6);
        Ok(std::fs::write(&path, picture.png()?)?)
    };

    let wgpu = Wgpu::from_device(host.device.clone(), host.queue.clone())?;
    for basis in [BasisStorage::Clustered, BasisStorage::F32] {
        let options = UploadOptions { max_frames: 1, basis };
        let any = PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: u32::MAX };
        let bytes = Plan::new(&rig, options, any, "any")?.bytes();
        let mut animator = Animator::new(&wgpu, &rig, options)?;
        let mut renderer = new()?;
        let begin = Instant::now();
        for frame in &frames {
            animator.evaluate(frame)?;
            renderer.show(&camera, 0.75, Look::Smooth);
            host.frame(|pass| {
                let results =
                    |stage| animator.session().results(stage).next().map(|(_, buffer)| buffer.slice(..));
                let both = results(Stage::Positions).zip(results(Stage::Normals));
                let (positions, normals) = both.ok_or("nothing was evaluated")?;
                Ok::<(), Box<dyn Error>>(renderer.draw(pass, Vertices { positions, normals, numbers: None })?)
            })?;
        }
        row(&format!("kernels, then drawn; basis {}", basis.name()), begin, bytes)?;
    }

    let mut renderer = new()?;
    renderer.set_rig(&rig)?;
    let bytes = renderer.rig_bytes().unwrap_or(0);
    for (way, look) in
        [("evaluated while drawn, flat", Look::Flat), ("placed in a pass, then drawn", Look::Smooth)]
    {
        let begin = Instant::now();
        for frame in &frames {
            renderer.pose(frame)?;
            if look == Look::Smooth {
                renderer.place()?;
            }
            renderer.show(&camera, 0.75, look);
            host.frame(|pass| renderer.draw_posed(pass))?;
        }
        row(way, begin, bytes)?;
    }
    println!("{path}: the last frame");
    Ok(())
}
