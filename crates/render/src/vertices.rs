//! A frame on the device that draws it.

/// The vertices of one frame in buffers of the renderer's device, as a session of the wgpu backend has them.
#[derive(Debug, Clone, Copy)]
pub struct Vertices<'a> {
    /// V × 3 floats, in mesh units.
    pub positions: wgpu::BufferSlice<'a>,
    /// V × 3 floats: normals of length 1.
    pub normals: wgpu::BufferSlice<'a>,
    /// V floats, for [`crate::Look::Heat`] and [`crate::Look::LitHeat`].
    pub numbers: Option<wgpu::BufferSlice<'a>>,
}
