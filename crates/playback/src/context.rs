//! The data that all stages of a take's frames share.

use rhytid_core::{Rig, Stage};
use rhytid_formats::export::OutputStage;
use rhytid_kernels::normals::VertexTriangles;

/// The data that all stages of a take's frames share.
pub(crate) struct Context<'c> {
    pub rig: &'c Rig,
    pub triangles: &'c VertexTriangles,
    /// Frames × H positions, without the edits of markers that have a falloff.
    pub unedited: &'c [[f32; 3]],
    /// Frames × H positions, with all edits.
    pub edited: &'c [[f32; 3]],
    /// The time of each frame, in seconds; empty where no stage needs it.
    pub times: &'c [f64],
    /// The output stage of the frames.
    pub stage: OutputStage,
    /// Whether frames have normals.
    pub normals: bool,
}

impl<'c> Context<'c> {
    /// The number of frames.
    pub(crate) fn frames(&self) -> usize {
        self.edited.len() / self.rig.handles().len()
    }

    /// H positions of a frame in `of`, which is `unedited` or `edited`.
    pub(crate) fn pose(&self, of: &'c [[f32; 3]], frame: usize) -> &'c [[f32; 3]] {
        let mut frames = of.chunks_exact(self.rig.handles().len());
        frames.nth(frame).expect("a frame of the take")
    }

    /// The device's stage that gives a frame's positions.
    pub(crate) fn shown(&self) -> Stage {
        stages(self.stage)[0]
    }
}

/// The device's stages that give an output stage's positions and normals.
pub(crate) fn stages(stage: OutputStage) -> [Stage; 2] {
    match stage {
        OutputStage::LargeScale | OutputStage::Shell => [Stage::LargeScale, Stage::LargeScaleNormals],
        OutputStage::Full => [Stage::Positions, Stage::Normals],
    }
}
