//! The face as a texture of the window.

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Result, Rig};
use rhytid_render::{
    Camera, Lights, Look, Mark, Offscreen, Overlay, Renderer, Skin, SkinRenderer, Sphere, Vertices, albedos,
};
use web_time::{Duration, Instant};

/// How a frame is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Drawn {
    Look(Look),
    Skin,
}

/// How a picture shows a frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shown<'a> {
    pub camera: &'a Camera,
    pub drawn: Drawn,
    /// The marks over the face.
    pub marks: &'a [Mark],
    /// Red, green, blue and opacity.
    pub background: [u8; 4],
}

/// Draws one rig's frames. Each side of a comparison has its own texture.
pub(crate) struct Canvas {
    state: RenderState,
    wgpu: Wgpu,
    renderer: Renderer,
    /// Made when it is first needed.
    skin: Option<SkinRenderer>,
    lights: Lights,
    overlay: Overlay,
    lift: f32,
    page: Option<Offscreen>,
    sides: [Option<Side>; 2],
}

/// The picture of one side in the window.
struct Side {
    texture: wgpu::Texture,
    id: egui::TextureId,
}

/// The times of a picture.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Took {
    pub lighting: Duration,
    pub drawing: Duration,
}

impl Canvas {
    /// A canvas for `rig`, in the window of `state`. `wgpu` shares the window's device.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub(crate) fn new(rig: &Rig, wgpu: &Wgpu, state: &RenderState) -> Result<Self> {
        let (device, queue) = (wgpu.device(), wgpu.queue());
        Ok(Self {
            state: state.clone(),
            renderer: Renderer::new(
                device,
                queue,
                &rig.surface().faces,
                &rig.surface().triangles,
                Offscreen::TARGET,
            )?,
            skin: None,
            lights: Lights::default(),
            overlay: Overlay::new(device, queue, Offscreen::TARGET)?,
            lift: 0.1 * Sphere::around(&rig.handles().rest).radius,
            wgpu: wgpu.clone(),
            page: None,
            sides: [None, None],
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
            self.page = Some(Offscreen::new(self.wgpu.device(), self.wgpu.queue(), size)?);
            self.forget_sides();
        }
        Ok(())
    }

    /// Draws a frame into the picture of side 0 or 1.
    ///
    /// # Errors
    /// As drawing.
    pub(crate) fn draw(
        &mut self,
        side: usize,
        rig: &Rig,
        vertices: Vertices<'_>,
        shown: Shown<'_>,
    ) -> Result<Took> {
        let Some(page) = &self.page else { return Ok(Took::default()) };
        let mut took = Took::default();
        let begin = Instant::now();
        let (device, queue) = (self.wgpu.device(), self.wgpu.queue());
        let skin = match (shown.drawn, &mut self.skin) {
            (Drawn::Look(_), _) => None,
            (Drawn::Skin, Some(skin)) => Some(&*skin),
            (Drawn::Skin, none) => Some(&*none.insert(skin(rig, &self.wgpu)?)),
        };
        if let Some(skin) = skin {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            skin.light(&mut encoder, vertices, shown.camera, page.aspect(), &self.lights)?;
            skin.wait(queue.submit([encoder.finish()]))?;
            took.lighting = begin.elapsed();
        }
        let begin = Instant::now();
        if let Drawn::Look(look) = shown.drawn {
            self.renderer.show(shown.camera, page.aspect(), look);
        }
        self.overlay.show(shown.camera, page.size(), self.lift, shown.marks)?;
        page.paint(shown.background, |pass| {
            match skin {
                Some(skin) => skin.draw(pass, vertices),
                None => self.renderer.draw(pass, vertices)?,
            }
            if !shown.marks.is_empty() {
                self.overlay.draw(pass);
            }
            Ok(())
        })?;
        let to = self.sides[side].get_or_insert_with(|| Side::new(&self.state, page.size()));
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let size = to.texture.size();
        encoder.copy_texture_to_texture(page.texture().as_image_copy(), to.texture.as_image_copy(), size);
        let submitted = queue.submit([encoder.finish()]);
        wait(device, submitted);
        took.drawing = begin.elapsed();
        Ok(took)
    }

    /// The texture of a side in the window. `None` before it is drawn.
    pub(crate) fn texture(&self, side: usize) -> Option<egui::TextureId> {
        self.sides[side].as_ref().map(|side| side.id)
    }

    /// The last picture. Waits for it, which browsers do not allow.
    ///
    /// # Errors
    /// As [`Picture::read`].
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn picture(&self) -> Result<Option<rhytid_render::Picture>> {
        use rhytid_render::Picture;
        let read = |page: &Offscreen| Picture::read(self.wgpu.device(), self.wgpu.queue(), page.texture());
        self.page.as_ref().map(read).transpose()
    }

    /// The texture into which the result was drawn.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn drawn_texture(&self) -> Option<&wgpu::Texture> {
        self.page.as_ref().map(Offscreen::texture)
    }

    fn forget_sides(&mut self) {
        for side in self.sides.iter_mut().filter_map(Option::take) {
            self.state.renderer.write().free_texture(&side.id);
        }
    }
}

impl Drop for Canvas {
    fn drop(&mut self) {
        self.forget_sides();
    }
}

impl Side {
    fn new(state: &RenderState, [width, height]: [u32; 2]) -> Self {
        let texture = state.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("face"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            // The window shows the bytes of its textures unchanged, without the sRGB curve.
            format: Offscreen::TARGET.color.remove_srgb_suffix(),
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut renderer = state.renderer.write();
        let id = renderer.register_native_texture(&state.device, &view, wgpu::FilterMode::Nearest);
        Self { texture, id }
    }
}

fn skin(rig: &Rig, wgpu: &Wgpu) -> Result<SkinRenderer> {
    let (device, queue) = (wgpu.device(), wgpu.queue());
    let (millimetres, skin) = (1e3 * rig.surface().metres_per_unit, Skin::default());
    let target = Offscreen::TARGET;
    let renderer = SkinRenderer::new(
        device,
        queue,
        &rig.surface().rest,
        &rig.surface().triangles,
        millimetres,
        target,
        skin,
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
