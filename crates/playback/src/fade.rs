//! Folds that are stronger or weaker than learned: by a gain, and where they are not to be trusted, as the markers that drive them were filled
//! rather than measured, or the frame is far outside what the examples show.

use crate::uncertainty::Uncertainty;
use rayon::prelude::*;
use rhytid_core::{Result, Rig, Take};
use rhytid_formats::edits::Curve;
use rhytid_kernels::normals::{self, VertexTriangles};
use rhytid_solve::FAR;
use std::ops::Range;

/// By how much folds are multiplied at each vertex, over time: `1 + w_v (g − 1)`.
#[derive(Debug, Clone, PartialEq)]
pub struct VertexGain {
    /// w, V of them: 0 where nothing changes, 1 where all of it does.
    pub weights: Vec<f32>,
    /// g over the take's time in seconds.
    pub by: Curve,
}

impl VertexGain {
    /// The same over all time, given at each of the H handles: a vertex has the mean of those of the handles that drive its folds.
    pub(crate) fn of_handles(rig: &Rig, gains: &[f32]) -> Self {
        let beyond: Vec<f64> = gains.iter().map(|gain| f64::from(*gain) - 1.0).collect();
        Self { weights: of_vertices(rig, &beyond), by: Curve::constant(2.0) }
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
    vertex_triangles: VertexTriangles,
    /// frames × F: the lesser confidence of each edge's two handles; empty where the take has none below 1.
    edges: Vec<f32>,
    /// Where some frame is far from the examples.
    far: Option<Uncertainty>,
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
        rig: &'a Rig,
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
            vertex_triangles: VertexTriangles::new(rig.vertices(), &rig.triangles),
            edges,
            far,
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
            || frames.clone().any(|frame| self.gains_at(frame).next().is_some())
            || self.far.as_ref().is_some_and(|far| frames.clone().any(|frame| far.is_far(frame)))
    }

    /// The weights and gains that change something in a frame.
    fn gains_at(&self, frame: usize) -> impl Iterator<Item = (&'a [f32], f64)> {
        let gain = move |gain: &'a VertexGain| (gain.weights.as_slice(), gain.by.at(self.times[frame]));
        self.gains.iter().map(gain).filter(|(_, gain)| *gain != 1.0)
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
        let edges = self.rig.strain_edges.len();
        let confidence = self.edges.get(frame * edges..(frame + 1) * edges).unwrap_or_default();
        let far = self.far.as_ref().map(|far| (far, far.samples(frame)));
        let gains: Vec<(&[f32], f64)> = self.gains_at(frame).collect();
        let faded = |v: usize, smooth: &[f32; 3], full: &[f32; 3]| {
            let mut c = if confidence.is_empty() { 1.0 } else { of_vertex(self.rig, v, confidence) };
            if let Some((far, samples)) = &far {
                c *= (2.0 - far.times(v, samples) / FAR).clamp(0.0, 1.0);
            }
            c = c.min(1.0) * self.gain;
            for (weights, gain) in &gains {
                c *= 1.0 + f64::from(weights[v]) * (gain - 1.0);
            }
            match c == 1.0 {
                true => *full,
                false => std::array::from_fn(|i| {
                    let (smooth, full) = (f64::from(smooth[i]), f64::from(full[i]));
                    (smooth + c * (full - smooth)) as f32
                }),
            }
        };
        let before = positions.as_chunks::<3>().0;
        let pairs = large_scale.as_chunks::<3>().0.par_iter().zip(before);
        let found = pairs.enumerate().map(|(v, (smooth, full))| faded(v, smooth, full));
        found.collect_into_vec(&mut self.positions);
        let (moved, after) = (|v: u32| self.positions[v as usize] != before[v as usize], &self.positions);
        if after == before {
            return unchanged;
        }
        if !normals.is_empty() {
            let triangles = &self.rig.triangles;
            let normal = |(v, normal): (usize, &[f32; 3])| {
                let incident = self.vertex_triangles.at(v);
                match incident.iter().any(|&t| triangles[t as usize].iter().any(|&v| moved(v))) {
                    true => normals::vertex_normal(after, triangles, incident),
                    false => *normal,
                }
            };
            let before = normals.as_chunks::<3>().0.par_iter().enumerate();
            before.map(normal).collect_into_vec(&mut self.normals);
        }
        [self.positions.as_flattened(), self.normals.as_flattened()]
    }
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
