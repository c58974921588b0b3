//! Wrinkles that are stronger or weaker than learned.
//!
//! Gains over time change them. Wrinkles also fade where they are not to be trusted. These are places where
//! the driving markers were filled and not measured, and frames far outside the examples.

use crate::channels::Uncertainty;
use crate::local_normals;
use rayon::prelude::*;
use rhytid_core::{HandleId, Result, Rig, Take};
use rhytid_formats::edits::Curve;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_solve::EXTRAPOLATION;
use std::ops::Range;
use std::sync::Arc;

/// A gain of the wrinkles at each vertex, over time: `1 + w_v (g − 1)`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct VertexGain {
    /// The vertices that the gain changes, ascending, and their w; 1 is the full gain.
    weights: Vec<(u32, f32)>,
    /// g over the take's time in seconds.
    by: Curve,
}

impl VertexGain {
    /// The gain with w of the V vertices, and with g over the take's time in seconds.
    pub(crate) fn new(weights: &[f32], by: Curve) -> Self {
        let weights = (0..).zip(weights.iter().copied()).filter(|(_, weight)| *weight != 0.0);
        Self { weights: weights.collect(), by }
    }

    /// g at a time, in seconds.
    pub(crate) fn at(&self, time: f64) -> f64 {
        self.by.at(time)
    }

    /// The vertices that the gain changes, ascending.
    pub(crate) fn vertices(&self) -> impl Iterator<Item = u32> {
        self.weights.iter().map(|(v, _)| *v)
    }

    /// g, if it is the same at all times.
    pub(crate) fn constant(&self) -> Option<f64> {
        let by = self.by.at(0.0);
        self.by.is_constantly(by).then_some(by)
    }

    /// The factors of the wrinkles that are not 1, if g is `by`: vertices, ascending, and factors.
    pub(crate) fn factors(&self, by: f64) -> impl Iterator<Item = (usize, f64)> {
        let weights = self.weights.iter().filter(move |_| by != 1.0);
        weights.map(move |&(v, weight)| (v as usize, 1.0 + f64::from(weight) * (by - 1.0)))
    }
}

/// Multiplies the fine detail of a take's frames by gains, and fades it by the confidence of the take and of
/// the rig.
///
/// Vertex v of a frame is at x̃ + g c_v (x − x̃). Here x̃ is its place in the large scale, x is its place in
/// the full result, and g is the product of all gains. c_v is the mean confidence of the strain edges that
/// influence v, weighted by the influences: Σ_k α_vk min(c_a, c_b) / Σ_k α_vk. Edge k joins the handles a and
/// b. A vertex without influences has no detail to fade.
///
/// With the learned method, c_v is also multiplied by a factor. The factor depends on σ_v as a multiple of a
/// scale. The scale is the σ of an expression without a scan: at the vertex or over the whole face, whichever
/// is larger. The factor is 1 up to [`EXTRAPOLATION`], falls linearly, and is 0 from twice that on.
pub(crate) struct Fade<'a> {
    rig: &'a Rig,
    gains: &'a [VertexGain],
    /// The time of each frame, in seconds.
    times: &'a [f64],
    vertex_triangles: Arc<VertexTriangles>,
    /// frames × F: the lower confidence of each edge's two handles; empty where no confidence of the take is
    /// below 1.
    edges: Vec<f32>,
    /// The uncertainty of the frames, if some frame is far from the examples.
    far: Option<Uncertainty>,
}

impl<'a> Fade<'a> {
    /// `None` where no frame changes.
    ///
    /// The take has all of the rig's handles, and `handle_positions` are frames × H. The confidence of the
    /// take and of the rig counts only if `fades`.
    ///
    /// # Errors
    /// As [`Uncertainty::new`].
    pub(crate) fn new(
        rig: &'a Rig,
        vertex_triangles: &Arc<VertexTriangles>,
        gains: &'a [VertexGain],
        take: &'a Take,
        handle_positions: &[f32],
        fades: bool,
    ) -> Result<Option<Self>> {
        let marker = |label: &String| take.labels.iter().position(|known| known == label);
        let markers: Vec<usize> = rig.handles().labels.iter().filter_map(marker).collect();
        let confidence = take.confidence.as_ref().filter(|_| fades);
        let mut edges: Vec<f32> = confidence.map_or_else(Vec::new, |confidence| {
            let of_frame = |frame: &[f32]| {
                let at = |handle: HandleId| frame[markers[handle.index()]];
                rig.handles().strain_edges.iter().map(|&[a, b]| at(a).min(at(b))).collect::<Vec<f32>>()
            };
            confidence.chunks_exact(take.labels.len()).flat_map(of_frame).collect()
        });
        if edges.iter().all(|&c| c >= 1.0) {
            edges.clear();
        }
        let is_far = |far: &Uncertainty| (0..take.frames()).any(|frame| far.is_far(frame));
        let far = match fades {
            true => Uncertainty::new(rig, handle_positions)?.filter(is_far),
            false => None,
        };
        let is_gained = gains.iter().any(|gain| gain.constant() != Some(1.0));
        if !is_gained && edges.is_empty() && far.is_none() {
            return Ok(None);
        }
        Ok(Some(Self {
            rig,
            gains,
            times: &take.times,
            vertex_triangles: vertex_triangles.clone(),
            edges,
            far,
        }))
    }

    /// Whether any of these frames may fade all over the face. If so, it needs the large scale of the whole
    /// face.
    pub(crate) fn is_everywhere(&self, frames: Range<usize>) -> bool {
        let edges = self.rig.handles().strain_edges.len();
        let unsure = |frame: usize| {
            let of_frame = self.edges.get(frame * edges..(frame + 1) * edges).unwrap_or_default();
            of_frame.iter().any(|&c| c < 1.0)
        };
        let is_far = |frame| self.far.as_ref().is_some_and(|far| far.is_far(frame));
        frames.into_iter().any(|frame| unsure(frame) || is_far(frame))
    }

    /// Whether a gain changes a frame. If so, the frame needs the large scale of the gain's vertices.
    pub(crate) fn is_gained(&self, frame: usize) -> bool {
        self.gains.iter().any(|gain| gain.at(self.times[frame]) != 1.0)
    }

    /// Fades a frame's V positions and updates its normals.
    ///
    /// `large_scale` are the V positions of the large scale, which matter only where something fades.
    /// `normals` is empty where no normals are wanted. Vertices where nothing fades keep every bit, and so do
    /// normals away from those that fade.
    pub(crate) fn frame(
        &self,
        frame: usize,
        large_scale: &[[f32; 3]],
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        let mut moved: Vec<u32> = Vec::new();
        if self.is_everywhere(frame..frame + 1) {
            let edges = self.rig.handles().strain_edges.len();
            let confidence = self.edges.get(frame * edges..(frame + 1) * edges).unwrap_or_default();
            let far = self.far.as_ref().map(|far| (far, far.samples(frame)));
            let fade = |(v, (x, smooth)): (usize, (&mut [f32; 3], &[f32; 3]))| {
                let mut c = if confidence.is_empty() { 1.0 } else { of_vertex(self.rig, v, confidence) };
                if let Some((far, samples)) = &far {
                    c *= (2.0 - far.times(v, samples) / EXTRAPOLATION).clamp(0.0, 1.0);
                }
                let before = std::mem::replace(x, with_wrinkles_scaled(*smooth, *x, c.min(1.0)));
                (*x != before).then_some(v as u32)
            };
            let all = positions.par_iter_mut().zip(large_scale).enumerate();
            moved = all.filter_map(fade).collect();
        }
        for gain in self.gains {
            for (v, factor) in gain.factors(gain.at(self.times[frame])) {
                positions[v] = with_wrinkles_scaled(large_scale[v], positions[v], factor);
                moved.push(v as u32);
            }
        }
        local_normals::update(self.rig, &self.vertex_triangles, moved.into_iter(), positions, normals);
    }
}

/// A vertex with its wrinkles multiplied by `factor`. Every bit stays where the factor is 1.
pub(crate) fn with_wrinkles_scaled(smooth: [f32; 3], full: [f32; 3], factor: f64) -> [f32; 3] {
    if factor == 1.0 {
        return full;
    }
    std::array::from_fn(|i| {
        let (smooth, full) = (f64::from(smooth[i]), f64::from(full[i]));
        (smooth + factor * (full - smooth)) as f32
    })
}

/// V numbers, from numbers of the H handles.
///
/// A vertex has the mean number of the handles that drive its wrinkles, or 0 where no handle does.
pub(crate) fn of_vertices(rig: &Rig, handles: &[f64]) -> Vec<f32> {
    let mean = |&[a, b]: &[HandleId; 2]| (0.5 * (handles[a.index()] + handles[b.index()])) as f32;
    let edges: Vec<f32> = rig.handles().strain_edges.iter().map(mean).collect();
    let is_driven = |v: usize| rig.influences().weights.row(v).iter().any(|alpha| *alpha > 0.0);
    (0..rig.vertices()).map(|v| if is_driven(v) { of_vertex(rig, v, &edges) as f32 } else { 0.0 }).collect()
}

/// c_v, from the confidence of the F edges; or the same mean of another number of the edges.
fn of_vertex(rig: &Rig, v: usize, edges: &[f32]) -> f64 {
    let (mut weighted, mut total) = (0.0, 0.0);
    for (edge, alpha) in rig.influences().at(v) {
        weighted += f64::from(alpha) * f64::from(edges[edge.index()]);
        total += f64::from(alpha);
    }
    if total > 0.0 { weighted / total } else { 1.0 }
}
