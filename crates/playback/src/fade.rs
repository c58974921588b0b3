//! Folds that are stronger or weaker than learned: by a gain, and where they are not to be trusted, as the markers that drive them were filled
//! rather than measured, or the frame is far outside what the examples show.

use crate::local_normals;
use crate::uncertainty::Uncertainty;
use rayon::prelude::*;
use rhytid_core::{Result, Rig, Take};
use rhytid_formats::edits::Curve;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_solve::FAR;
use std::ops::Range;
use std::sync::Arc;

/// By how much folds are multiplied at each vertex, over time: `1 + w_v (g − 1)`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct VertexGain {
    /// The vertices where something changes, ascending, and w: 1 where all of it does.
    weights: Vec<(u32, f32)>,
    /// g over the take's time in seconds.
    by: Curve,
}

impl VertexGain {
    /// With w of the V vertices, and g over the take's time in seconds.
    pub(crate) fn new(weights: &[f32], by: Curve) -> Self {
        let weights = (0..).zip(weights.iter().copied()).filter(|(_, weight)| *weight != 0.0);
        Self { weights: weights.collect(), by }
    }

    /// g at a time, in seconds.
    pub(crate) fn at(&self, time: f64) -> f64 {
        self.by.at(time)
    }

    /// What folds are multiplied by where it is not 1, if g is `by`: vertices, ascending, and factors.
    pub(crate) fn factors(&self, by: f64) -> impl Iterator<Item = (usize, f64)> {
        let weights = self.weights.iter().filter(move |_| by != 1.0);
        weights.map(move |&(v, weight)| (v as usize, 1.0 + f64::from(weight) * (by - 1.0)))
    }

    /// The same over all time, given at each of the H handles: a vertex has the mean of those of the handles that drive its folds.
    pub(crate) fn of_handles(rig: &Rig, gains: &[f32]) -> Self {
        let beyond: Vec<f64> = gains.iter().map(|gain| f64::from(*gain) - 1.0).collect();
        Self::new(&of_vertices(rig, &beyond), Curve::constant(2.0))
    }
}

/// Multiplies the detail of a take's frames by gains, and takes it away as the take's confidence and the rig's say.
///
/// Vertex v of a frame is at x̃ + g c_v (x − x̃), from the large scale x̃ towards the full result x, with g the product of all gains. c_v is the confidence of
/// the strain edges that v listens to, weighted by its influences: Σ_k α_vk min(c_a, c_b) / Σ_k α_vk, where edge k joins
/// the handles a and b. A vertex without influences has no detail to fade. By the learned method, c_v is that times what falls from 1
/// to 0 where σ_v is from [`FAR`] to twice as many times that of an example that is left out.
pub(crate) struct Fade<'a> {
    rig: &'a Rig,
    gain: f64,
    gains: &'a [VertexGain],
    /// Of each frame, in seconds.
    times: &'a [f64],
    vertex_triangles: Arc<VertexTriangles>,
    /// frames × F: the lesser confidence of each edge's two handles; empty where the take has none below 1.
    edges: Vec<f32>,
    /// Where some frame is far from the examples.
    far: Option<Uncertainty>,
    /// V: the product of all gains.
    factors: Vec<f64>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl<'a> Fade<'a> {
    /// `None` where all leave every frame as it is. The take has all of the rig's handles, at these frames × H positions; its confidence and the rig's
    /// count where it `fades`.
    ///
    /// # Errors
    /// As [`Uncertainty::new`].
    pub(crate) fn new(
        (rig, vertex_triangles): (&'a Rig, &Arc<VertexTriangles>),
        gain: f64,
        gains: &'a [VertexGain],
        (take, handle_positions): (&'a Take, &[f32]),
        fades: bool,
    ) -> Result<Option<Self>> {
        let marker = |label: &String| take.labels.iter().position(|known| known == label);
        let markers: Vec<usize> = rig.labels.iter().filter_map(marker).collect();
        let confidence = take.confidence.as_ref().filter(|_| fades);
        let mut edges: Vec<f32> = confidence.map_or_else(Vec::new, |confidence| {
            let of_frame = |frame: &[f32]| {
                let at = |handle: u32| frame[markers[handle as usize]];
                rig.strain_edges.iter().map(|&[a, b]| at(a).min(at(b))).collect::<Vec<f32>>()
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
        let is_gained = gains.iter().any(|gain| !gain.by.is_constantly(1.0));
        if gain == 1.0 && !is_gained && edges.is_empty() && far.is_none() {
            return Ok(None);
        }
        Ok(Some(Self {
            rig,
            gain,
            gains,
            times: &take.times,
            vertex_triangles: vertex_triangles.clone(),
            edges,
            far,
            factors: vec![gain; rig.vertices()],
            positions: Vec::new(),
            normals: Vec::new(),
        }))
    }

    /// Whether any of these frames may need its large scale.
    pub(crate) fn touches(&self, frames: Range<usize>) -> bool {
        let edges = self.rig.strain_edges.len();
        let unsure = !self.edges.is_empty()
            && self.edges[frames.start * edges..frames.end * edges].iter().any(|&c| c < 1.0);
        self.gain != 1.0
            || unsure
            || frames.clone().any(|frame| self.is_gained(frame))
            || self.far.as_ref().is_some_and(|far| frames.clone().any(|frame| far.is_far(frame)))
    }

    fn is_gained(&self, frame: usize) -> bool {
        self.gains.iter().any(|gain| gain.at(self.times[frame]) != 1.0)
    }

    /// A frame's 3V positions and normals (empty where they are not wanted) after the fading, from those before and the 3V
    /// positions of its large scale. Where nothing fades, and away from what does, every bit is what came in.
    pub(crate) fn frame<'s>(
        &'s mut self,
        frame: usize,
        large_scale: &[f32],
        [positions, normals]: [&'s [f32]; 2],
    ) -> [&'s [f32]; 2] {
        let unchanged = [positions, normals];
        if !self.touches(frame..frame + 1) {
            return unchanged;
        }
        let before = positions.as_chunks::<3>().0;
        let smooth = large_scale.as_chunks::<3>().0;
        let time = self.times[frame];
        let factors = || self.gains.iter().flat_map(move |gain| gain.factors(gain.at(time)));
        self.factors.fill(self.gain);
        factors().for_each(|(v, factor)| self.factors[v] *= factor);
        let of_frame = frame * self.rig.strain_edges.len()..(frame + 1) * self.rig.strain_edges.len();
        let confidence = self.edges.get(of_frame).unwrap_or_default();
        let far = self.far.as_ref().map(|far| (far, far.samples(frame)));
        if self.gain == 1.0 && confidence.is_empty() && far.is_none() {
            // Only where a gain is.
            self.positions.clear();
            self.positions.extend_from_slice(before);
            for (v, _) in factors() {
                self.positions[v] = folded(smooth[v], before[v], self.factors[v]);
            }
        } else {
            let faded = |(v, (smooth, full)): (usize, (&[f32; 3], &[f32; 3]))| {
                let mut c = if confidence.is_empty() { 1.0 } else { of_vertex(self.rig, v, confidence) };
                if let Some((far, samples)) = &far {
                    c *= (2.0 - far.times(v, samples) / FAR).clamp(0.0, 1.0);
                }
                folded(*smooth, *full, c.min(1.0) * self.factors[v])
            };
            smooth.par_iter().zip(before).enumerate().map(faded).collect_into_vec(&mut self.positions);
        }
        let moved = |v: &usize| self.positions[*v] != before[*v];
        let moved: Vec<u32> = (0..before.len()).filter(moved).map(|v| v as u32).collect();
        if moved.is_empty() {
            return unchanged;
        }
        self.normals.clear();
        self.normals.extend_from_slice(normals.as_chunks().0);
        let (triangles, moved) = (&self.vertex_triangles, moved.into_iter());
        local_normals::update(self.rig, triangles, moved, &self.positions, &mut self.normals);
        [self.positions.as_flattened(), self.normals.as_flattened()]
    }
}

/// A vertex with its folds times so much; every bit of it where that is 1.
pub(crate) fn folded(smooth: [f32; 3], full: [f32; 3], factor: f64) -> [f32; 3] {
    if factor == 1.0 {
        return full;
    }
    std::array::from_fn(|i| {
        let (smooth, full) = (f64::from(smooth[i]), f64::from(full[i]));
        (smooth + factor * (full - smooth)) as f32
    })
}

/// V numbers from those of the H handles: the mean of those of the handles that drive a vertex's folds, 0 where there is none.
pub(crate) fn of_vertices(rig: &Rig, handles: &[f64]) -> Vec<f32> {
    let mean = |&[a, b]: &[u32; 2]| (0.5 * (handles[a as usize] + handles[b as usize])) as f32;
    let edges: Vec<f32> = rig.strain_edges.iter().map(mean).collect();
    let k = rig.influences();
    let is_driven = |v: usize| rig.influence_weights[v * k..][..k].iter().any(|alpha| *alpha > 0.0);
    (0..rig.vertices()).map(|v| if is_driven(v) { of_vertex(rig, v, &edges) as f32 } else { 0.0 }).collect()
}

/// c_v, from the confidence of the F edges; or what else they have.
fn of_vertex(rig: &Rig, v: usize, edges: &[f32]) -> f64 {
    let k = rig.influences();
    let influences = rig.influence_edges[v * k..][..k].iter().zip(&rig.influence_weights[v * k..][..k]);
    let (mut weighted, mut total) = (0.0, 0.0);
    for (&edge, &alpha) in influences {
        weighted += f64::from(alpha) * f64::from(edges[edge as usize]);
        total += f64::from(alpha);
    }
    if total > 0.0 { weighted / total } else { 1.0 }
}
