//! Frames as skin.

use crate::args;
use rhytid::devices::wgpu::Wgpu;
use rhytid::render::{Camera, Lights, Offscreen, Skin, SkinRenderer, Vertices, albedos};
use rhytid::{Result, Rig};
use std::time::{Duration, Instant};

/// Draws skin.
pub(super) struct SkinLook {
    pub renderer: SkinRenderer,
    lights: Lights,
    wgpu: Wgpu,
    /// Time of light and its spreading.
    pub time: Duration,
}

impl SkinLook {
    /// Of a rig.
    pub(super) fn new(args: &args::Render, rig: &Rig, wgpu: &Wgpu) -> Result<Self> {
        let (device, queue, skin) = (wgpu.device(), wgpu.queue(), Skin::default());
        let millimetres = 1e3 * rig.surface().metres_per_unit;
        let renderer = SkinRenderer::new(
            device,
            queue,
            &rig.surface().rest,
            &rig.surface().triangles,
            millimetres,
            Offscreen::TARGET,
            skin,
        )?;
        renderer.paint(&albedos(rig, skin.albedo));
        if renderer.too_fine() > 0.02 {
            log::warn!(
                "on {:.0} % of the surface triangles are so fine that light spreads less far in the skin than it should",
                100.0 * renderer.too_fine()
            );
        }
        Ok(Self { renderer, lights: args.skin.lights(), wgpu: wgpu.clone(), time: Duration::ZERO })
    }

    /// Lights a frame, and waits until it is lit.
    pub(super) fn light(&mut self, vertices: Vertices<'_>, camera: &Camera, aspect: f32) -> Result<()> {
        let begin = Instant::now();
        let device = self.wgpu.device();
        let mut encoder = device.create_command_encoder(&Default::default());
        self.renderer.light(&mut encoder, vertices, camera, aspect, &self.lights)?;
        self.renderer.wait(self.wgpu.queue().submit([encoder.finish()]))?;
        self.time += begin.elapsed();
        Ok(())
    }
}
