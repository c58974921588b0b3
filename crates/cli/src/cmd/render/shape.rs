//! The face in one frame.

/// A frame on the host, V × 3 each.
#[derive(Clone, Copy, Default)]
pub(super) struct Shape<'a> {
    pub positions: &'a [f32],
    pub normals: &'a [f32],
}
