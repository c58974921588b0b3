//! The attachments of a pass.

/// The attachments into which a pass draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target {
    /// The format of the colour attachment. Shaders write linear colours, so an sRGB format shows them
    /// correctly.
    pub color: wgpu::TextureFormat,
    /// The format of the depth attachment, which is cleared to 1.
    pub depth: wgpu::TextureFormat,
    /// Samples for each pixel of both.
    pub samples: u32,
}

impl Target {
    /// Pixels farther than those that are already there are not drawn. `hides` says whether drawn pixels hide
    /// later ones.
    pub(crate) fn depth_test(self, hides: bool) -> wgpu::DepthStencilState {
        wgpu::DepthStencilState {
            format: self.depth,
            depth_write_enabled: Some(hides),
            depth_compare: Some(wgpu::CompareFunction::LessEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }
    }

    pub(crate) fn multisample(self) -> wgpu::MultisampleState {
        wgpu::MultisampleState { count: self.samples, ..Default::default() }
    }
}
