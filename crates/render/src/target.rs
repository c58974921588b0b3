//! The attachments of a pass.

/// What a pass draws into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Target {
    /// Of the colour attachment; colours are written linear, so an sRGB format shows them right.
    pub color: wgpu::TextureFormat,
    /// Of the depth attachment, cleared to 1.
    pub depth: wgpu::TextureFormat,
    /// Samples for each pixel of both.
    pub samples: u32,
}

impl Target {
    /// What is farther than what is there is not drawn; whether what is drawn hides what comes later.
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
