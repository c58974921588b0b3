//! The face as textures that the window shows.

use crate::gpu::Gpu;
use crate::pace::Fineness;
use rhytid_core::{Progress, Result, Rig};
use rhytid_render::{
    Camera, Lights, Look, Mark, Offscreen, Overlay, Renderer, Skin, SkinRenderer, Sphere, Vertices, albedos,
};
use std::sync::Arc;
use web_time::{Duration, Instant};

/// How a frame is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Drawn<'a> {
    Look(Look),
    Skin(&'a Arc<SkinRenderer>, Fineness),
}

/// How a picture shows a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shown<'a> {
    pub camera: &'a Camera,
    pub drawn: Drawn<'a>,
    /// The marks over the face.
    pub marks: &'a [Mark],
    /// Red, green, blue and opacity.
    pub background: [u8; 4],
}

/// Draws one rig's frames. Each side of a comparison has its own textures.
pub(crate) struct Canvas {
    gpu: Gpu,
    renderer: Renderer,
    lights: Lights,
    overlay: Overlay,
    lift: f32,
    page: Option<Offscreen>,
    sides: [Side; 2],
    /// The skin that was lit. Its light can be drawn again.
    lit: Option<Arc<SkinRenderer>>,
}

/// The pictures of one side. The window shows one while the other is drawn.
#[derive(Default)]
struct Side {
    textures: [Option<wgpu::Texture>; 2],
    /// The one that is drawn next.
    next: usize,
}

/// The times of a picture.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Took {
    pub lighting: Duration,
    pub drawing: Duration,
}

impl Canvas {
    /// A canvas for `rig`. `gpu` is the window's device.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub(crate) fn new(rig: &Rig, gpu: &Gpu) -> Result<Self> {
        let (device, queue) = (gpu.device(), gpu.queue());
        Ok(Self {
            renderer: Renderer::new(
                device,
                queue,
                &rig.surface().faces,
                &rig.surface().triangles,
                Offscreen::TARGET,
            )?,
            lights: Lights::default(),
            overlay: Overlay::new(device, queue, Offscreen::TARGET)?,
            lift: 0.1 * Sphere::around(&rig.handles().rest).radius,
            gpu: gpu.clone(),
            page: None,
            sides: Default::default(),
            lit: None,
        })
    }

    /// The light of [`Drawn::Skin`].
    pub(crate) fn lights(&mut self) -> &mut Lights {
        &mut self.lights
    }

    /// Makes pictures of `size` pixels, width and height, from now on.
    ///
    /// # Errors
    /// As [`Offscreen::new`].
    pub(crate) fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        if self.page.as_ref().is_none_or(|page| page.size() != size) {
            self.page = Some(Offscreen::new(self.gpu.device(), self.gpu.queue(), size)?);
        }
        Ok(())
    }

    /// Draws a frame as the picture of side 0 or 1.
    ///
    /// # Errors
    /// As drawing; [`rhytid_core::Error::Cancelled`].
    pub(crate) fn draw(
        &mut self,
        side: usize,
        vertices: Vertices<'_>,
        shown: Shown<'_>,
        progress: &dyn Progress,
    ) -> Result<(Took, wgpu::Texture)> {
        let page = match &self.page {
            Some(page) => page,
            None => return Err(rhytid_core::Error::Internal("there is nothing to draw on".to_owned())),
        };
        let mut took = Took::default();
        let begin = Instant::now();
        let (device, queue) = (self.gpu.device(), self.gpu.queue());
        let skin = match shown.drawn {
            Drawn::Look(look) => Err(look),
            Drawn::Skin(skin, Fineness::Whole) => {
                light(&self.gpu, skin, vertices, shown.camera, page.aspect(), &self.lights, progress)?;
                self.lit = Some(skin.clone());
                Ok(skin)
            }
            Drawn::Skin(skin, _) if self.lit.as_ref().is_some_and(|lit| Arc::ptr_eq(lit, skin)) => {
                skin.aim(shown.camera, page.aspect(), &self.lights);
                Ok(skin)
            }
            Drawn::Skin(..) => Err(Look::Smooth),
        };
        if skin.is_ok() {
            took.lighting = begin.elapsed();
        }
        let begin = Instant::now();
        if let Err(look) = skin {
            self.renderer.show(shown.camera, page.aspect(), look);
        }
        self.overlay.show(shown.camera, page.size(), self.lift, shown.marks)?;
        page.paint(shown.background, |pass| {
            match skin {
                Ok(skin) => skin.draw(pass, vertices),
                Err(_) => self.renderer.draw(pass, vertices)?,
            }
            if !shown.marks.is_empty() {
                self.overlay.draw(pass);
            }
            Ok(())
        })?;
        let texture = self.sides[side].turn(device, page.size());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        page.copy_to(&mut encoder, &texture);
        let submitted = queue.submit([encoder.finish()]);
        wait(device, submitted);
        took.drawing = begin.elapsed();
        Ok((took, texture))
    }

    /// The last picture. Waits for it, which browsers do not allow.
    ///
    /// # Errors
    /// As [`Picture::read`].
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn picture(&self) -> Result<Option<rhytid_render::Picture>> {
        use rhytid_render::Picture;
        let read = |page: &Offscreen| Picture::read(self.gpu.device(), self.gpu.queue(), page.texture());
        self.page.as_ref().map(read).transpose()
    }

    /// The texture into which the result was drawn.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn drawn_texture(&self) -> Option<&wgpu::Texture> {
        self.page.as_ref().map(Offscreen::texture)
    }
}

impl Side {
    /// The texture for the next picture.
    fn turn(&mut self, device: &wgpu::Device, [width, height]: [u32; 2]) -> wgpu::Texture {
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = &mut self.textures[self.next];
        self.next = 1 - self.next;
        let old = texture.take().filter(|texture| texture.size() == size);
        let new = || {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some("face"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                // The window shows the bytes of its textures unchanged, without the sRGB curve.
                format: Offscreen::TARGET.color.remove_srgb_suffix(),
                usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        texture.insert(old.unwrap_or_else(new)).clone()
    }
}

/// Lights skin: in pieces, so that the window can draw in between. Browsers do not allow the waiting that
/// this needs.
fn light(
    gpu: &Gpu,
    skin: &SkinRenderer,
    vertices: Vertices<'_>,
    camera: &Camera,
    aspect: f32,
    lights: &Lights,
    progress: &dyn Progress,
) -> Result<()> {
    if cfg!(not(target_arch = "wasm32")) {
        return skin.light_in_pieces(vertices, camera, aspect, lights, progress);
    }
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    skin.light(&mut encoder, vertices, camera, aspect, lights)?;
    gpu.queue().submit([encoder.finish()]);
    Ok(())
}

/// Prepares skin for a rig. It takes seconds for half a million vertices.
///
/// # Errors
/// As [`SkinRenderer::with_progress`].
pub(crate) fn skin(rig: &Rig, gpu: &Gpu, progress: &dyn Progress) -> Result<SkinRenderer> {
    let (device, queue) = (gpu.device(), gpu.queue());
    let (millimetres, skin) = (1e3 * rig.surface().metres_per_unit, Skin::default());
    let target = Offscreen::TARGET;
    let renderer = SkinRenderer::with_progress(
        device,
        queue,
        &rig.surface().rest,
        &rig.surface().triangles,
        millimetres,
        target,
        skin,
        progress,
    )?;
    renderer.paint(&albedos(rig, skin.albedo));
    Ok(renderer)
}

/// Waits, so that the time of drawing can be measured. Browsers do not allow waiting.
fn wait(device: &wgpu::Device, submission: wgpu::SubmissionIndex) {
    if cfg!(not(target_arch = "wasm32")) {
        // A lost device reports this at the next call.
        let _ = device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None });
    }
}
