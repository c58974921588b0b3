//! The film that the page shows where the viewer cannot run.

use rhytid_backend_cpu::Cpu;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Animator, Backend, DeviceErrorKind, Error, Result, Rig, Stage, Take, UploadOptions};
use rhytid_render::{
    Camera, Film, FrameBuffers, Look, Mark, Offscreen, Overlay, Renderer, Sphere, View, around_handles,
};
use std::io::Cursor;

/// Pixels along a side.
const SIDE: u32 = 480;

/// The background, which is the colour of the dark page.
const BACKGROUND: [u8; 4] = [0x14, 0x18, 0x1c, 0xff];

/// A marker and its rim, as in the viewer: colours, and widths in pixels.
const DOTS: [([f32; 3], f32); 2] = [([1.0; 3], 8.0), ([0.02; 3], 5.5)];

/// A film, and its first picture as PNG.
pub(crate) struct Filmed {
    pub bytes: Vec<u8>,
    pub first: Vec<u8>,
}

/// Draws each frame of a take on its rig, shaded and with its markers.
///
/// # Errors
/// [`Error::Device`] if no device can draw.
pub(crate) fn of(rig: &Rig, take: &Take) -> Result<Filmed> {
    let processor = Cpu::open(&Cpu::devices()?[0])?;
    let mut animator = Animator::new(&processor, rig, UploadOptions::frames(1))?;
    let info = Wgpu::devices()?.into_iter().next().ok_or_else(|| Error::Device {
        kind: DeviceErrorKind::Unsupported,
        device: "wgpu".to_owned(),
        message: "no device can draw the film; install a driver, as cargo xtask setup does".to_owned(),
    })?;
    let wgpu = Wgpu::open(&info)?;
    let (device, queue) = (wgpu.device(), wgpu.queue());
    let surface = rig.surface();
    let target = Offscreen::TARGET;
    let mut renderer = Renderer::new(device, queue, &surface.faces, &surface.triangles, target)?;
    let mut overlay = Overlay::new(device, queue, target)?;
    let lift = 0.1 * Sphere::around(&rig.handles().rest).radius;
    let page = Offscreen::new(device, queue, [SIDE; 2])?;
    let framed = around_handles(&rig.handles().rest, &surface.rest);
    let camera = Camera::framing(&framed, surface.up_axis, View::default(), page.aspect());
    let buffers = FrameBuffers::new(device, queue, rig.vertices())?;

    let written = |error: std::io::Error| Error::Internal(error.to_string());
    let mut bytes = Cursor::new(Vec::new());
    let mut film = Film::new(&mut bytes, [SIDE; 2], take.times.len() as u32, take.rate()).map_err(written)?;
    let mut first = Vec::new();
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let handles = take.handle_positions(&rig.handles().labels)?;
    for frame in handles.chunks_exact(3 * rig.handles().len()) {
        animator.evaluate(frame)?;
        animator.read(Stage::Positions, &mut positions)?;
        animator.read(Stage::Normals, &mut normals)?;
        buffers.set(&positions, &normals, &[]);
        let places = frame.as_chunks::<3>().0;
        let dots = |&at: &[f32; 3]| DOTS.map(|(colour, width)| Mark::dot(at, colour, width));
        let marks: Vec<Mark> = places.iter().flat_map(dots).collect();
        renderer.show(&camera, page.aspect(), Look::Smooth);
        overlay.show(&camera, page.size(), lift, &marks)?;
        let picture = page.draw(BACKGROUND, |pass| {
            renderer.draw(pass, buffers.vertices())?;
            overlay.draw(pass);
            Ok(())
        })?;
        if first.is_empty() {
            first = picture.png()?;
        }
        film.add(&picture).map_err(written)?;
    }
    film.finish().map_err(written)?;
    Ok(Filmed { bytes: bytes.into_inner(), first })
}
