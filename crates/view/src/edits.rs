//! The effects of a file of edits on frames. Browsers have no edits.

use crate::same::Same;

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use rhytid_playback::FrameEdits;

/// Browsers have no edits.
#[cfg(target_arch = "wasm32")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FrameEdits {}

#[cfg(target_arch = "wasm32")]
impl FrameEdits {
    pub(crate) fn touches(&self, _: f64) -> bool {
        match *self {}
    }

    pub(crate) fn scale_wrinkles(&self, _: f64, _: &[f32], _: &mut [f32]) -> bool {
        match *self {}
    }

    pub(crate) fn has_falloff(&self) -> bool {
        match *self {}
    }

    pub(crate) fn blend(
        &self,
        _: &rhytid_core::Rig,
        _: &rhytid_kernels::normals::VertexTriangles,
        _: [&[[f32; 3]]; 2],
        _: &mut [[f32; 3]],
        _: &mut [[f32; 3]],
    ) {
        match *self {}
    }

    pub(crate) fn correct(
        &self,
        _: &rhytid_core::Rig,
        _: &rhytid_kernels::normals::VertexTriangles,
        _: f64,
        _: &[[f32; 3]],
        _: &mut [[f32; 3]],
        _: &mut [[f32; 3]],
    ) {
        match *self {}
    }
}

/// The effects of edits on the frame that is shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EditedFrame {
    pub edits: Same<FrameEdits>,
    /// The time of the frame, in seconds.
    pub time: f64,
    /// H positions without the edits. `None` unless the edits have a falloff and move handles.
    pub without: Option<Vec<[f32; 3]>>,
}

/// A take with its edits.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OpenEdits {
    /// The name of the file.
    pub name: String,
    /// frames × H × 3 of the edited take.
    pub positions: Vec<f32>,
    /// All other edits.
    pub on_frames: Same<FrameEdits>,
}
