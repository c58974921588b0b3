//! The pictures of the painter as textures of the window.

use eframe::egui;
use eframe::egui_wgpu::RenderState;

/// The two sides of a comparison, as the window shows them.
pub(crate) struct Screen {
    state: RenderState,
    sides: [Option<egui::TextureId>; 2],
}

impl Screen {
    pub(crate) fn new(state: &RenderState) -> Self {
        Self { state: state.clone(), sides: [None, None] }
    }

    /// Shows these textures from now on. A side without one stays as it is. Pictures that are
    /// smaller than their place are enlarged smoothly.
    pub(crate) fn show(&mut self, textures: &[Option<wgpu::Texture>; 2], is_enlarged: bool) {
        let mut renderer = self.state.renderer.write();
        for (side, texture) in self.sides.iter_mut().zip(textures) {
            let Some(texture) = texture else { continue };
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            let filter = if is_enlarged { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest };
            let device = &self.state.device;
            match side {
                Some(id) => renderer.update_egui_texture_from_wgpu_texture(device, &view, filter, *id),
                None => *side = Some(renderer.register_native_texture(device, &view, filter)),
            }
        }
    }

    /// The texture of a side: 0 is the result, 1 the side that it is compared with.
    pub(crate) fn texture(&self, side: usize) -> Option<egui::TextureId> {
        self.sides[side]
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        for side in self.sides.iter().flatten() {
            self.state.renderer.write().free_texture(side);
        }
    }
}
