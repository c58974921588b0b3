//! The effects of layers on single frames, for programs that evaluate frames themselves.

use super::Layers;
use crate::edit_falloff::EditFalloff;
use crate::fade::{VertexGain, with_wrinkles_scaled};
use crate::{Correction, EditedTake, Playback};
use rhytid_core::{DeviceInfo, Progress, Result, Rig};
use rhytid_kernels::normals::VertexTriangles;

/// The effects of layers on frames, beside the edits of the take's handles.
///
/// Apply [`FrameEdits::scale_wrinkles`] first. Where edits of handles have a falloff, apply it to the frame
/// with these edits and to the frame without them. Then [`FrameEdits::blend`] the two frames, and
/// [`FrameEdits::correct`] the result.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FrameEdits {
    gains: Vec<VertexGain>,
    corrections: Vec<Correction>,
    falloff: Option<EditFalloff>,
}

impl FrameEdits {
    /// Evaluates the frames of the `edited` take that were sculpted, on the first of `devices` that works.
    ///
    /// # Errors
    /// As [`Playback::new`] and [`Playback::with_layers`].
    pub fn new(
        layers: &Layers,
        rig: &Rig,
        edited: &EditedTake,
        devices: &[DeviceInfo],
        progress: &dyn Progress,
    ) -> Result<Self> {
        let corrections = match layers.sculpted() {
            [] => Vec::new(),
            _ => Playback::new(rig, devices, 1)?.with_layers(layers, edited, progress)?.into_corrections(),
        };
        let falloff = EditFalloff::new(rig, edited);
        Ok(Self { gains: layers.vertex_gains(&edited.take), corrections, falloff })
    }

    /// Whether a frame at this time may change.
    pub fn touches(&self, time: f64) -> bool {
        !self.corrections.is_empty() || self.gains.iter().any(|gain| gain.at(time) != 1.0)
    }

    /// Multiplies the wrinkles of 3V positions, given those of the large scale. The result is whether any
    /// gain is not 1.
    pub fn scale_wrinkles(&self, time: f64, large_scale: &[f32], positions: &mut [f32]) -> bool {
        let (positions, _) = positions.as_chunks_mut::<3>();
        let (smooth, _) = large_scale.as_chunks::<3>();
        for gain in &self.gains {
            for (v, factor) in gain.factors(gain.at(time)) {
                positions[v] = with_wrinkles_scaled(smooth[v], positions[v], factor);
            }
        }
        self.gains.iter().any(|gain| gain.at(time) != 1.0)
    }

    /// The same effects with the falloff that is due where these of the H handles are edited.
    #[must_use]
    pub fn with_edited(&self, rig: &Rig, edited: &[bool]) -> Self {
        Self { falloff: EditFalloff::of_handles(rig, edited), ..self.clone() }
    }

    /// Blends V positions and normals without the edits of handles into those with the edits, by the falloff.
    ///
    /// The result replaces `with_positions` and `with_normals`.
    pub fn blend(
        &self,
        rig: &Rig,
        triangles: &VertexTriangles,
        [positions, normals]: [&[[f32; 3]]; 2],
        with_positions: &mut [[f32; 3]],
        with_normals: &mut [[f32; 3]],
    ) {
        if let Some(falloff) = &self.falloff {
            falloff.blend(positions, with_positions);
            falloff.blend_normals(rig, triangles, with_positions, normals, with_normals);
        }
    }

    /// Adds the sculpted corrections to V positions of the frame at `time`, in seconds, and updates their
    /// normals, as [`Correction::apply`] does. `handles` are the frame's H positions.
    pub fn correct(
        &self,
        rig: &Rig,
        triangles: &VertexTriangles,
        time: f64,
        handles: &[[f32; 3]],
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        for correction in &self.corrections {
            correction.apply(rig, triangles, time, handles, positions, normals);
        }
    }
}
