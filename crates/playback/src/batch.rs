//! Batches: how much memory a rig and its frames need on a device, and how many frames are evaluated at once.

use rhytid_core::{Rig, Stage};

/// The bytes that the results of a batch may take together. A batch has as many frames as fit. The chapter's
/// face of 530,000 vertices has room for a whole batch.
const BATCH_BYTES: usize = 512 << 20;

/// The most frames in a batch. A larger batch is no faster: the CPU backend computes this many frames
/// together.
const MAX_BATCH: usize = 16;

/// The bytes of the rig's arrays on a device. Arrays that only the exporters use are not counted.
pub fn rig_bytes(rig: &Rig) -> usize {
    let words = rig.handles().len()
        + rig.surface().triangles.len() * 3
        + rig.surface().rest.len() * 3
        + rig.basis().as_slice().len()
        + rig.handles().strain_edges.len() * 2
        + rig.influences().edges.as_slice().len()
        + rig.influences().weights.as_slice().len()
        + rig.surface().tangent_neighbors.len()
        + rig.fine_scale().pose_features.as_slice().len()
        + rig.fine_scale().rbf_weights.as_slice().len() * 3;
    let learned = rig.learned().map_or(0, |learned| {
        learned.anchors.as_slice().len() * 2 + learned.example_weights.as_slice().len() * 3
    });
    (words + learned) * 4
}

/// The bytes of one frame's handle positions and of its results at all stages.
pub fn frame_bytes(rig: &Rig) -> usize {
    let results: usize = Stage::ALL.iter().map(|stage| stage.values_per_frame(rig)).sum();
    (results + rig.handles().len() * 3) * 4
}

/// Frames in a batch.
pub fn batch_frames(rig: &Rig) -> usize {
    (BATCH_BYTES / frame_bytes(rig).max(1)).clamp(1, MAX_BATCH)
}
