//! Folds that are stronger or weaker than learned: by a gain, and where they are not to be trusted, as the markers that drive them were filled
//! rather than measured, or the frame is far outside what the examples show.

use crate::uncertainty::Uncertainty;
use rhytid_core::{Result, Rig, Take};
use rhytid_kernels::normals::{self, VertexTriangles};
use rhytid_solve::FAR;
use std::ops::Range;

/// Multiplies the detail of a take's frames by a gain, and takes it away as the take's confidence and the rig's say.
///
/// Vertex v of a frame is at x̃ + g c_v (x − x̃), from the large scale x̃ towards the full result x, with the gain g, which by region is the mean, weighted as below, of the edges' two
/// handles. c_v is the confidence of
/// the strain edges that v listens to, weighted by its influences: Σ_k α_vk min(c_a, c_b) / Σ_k α_vk, where edge k joins
/// the handles a and b. A vertex without influences has no detail to fade. By the learned method, c_v is that times what falls from 1
/// to 0 where σ_v is from [`FAR`] to twice as many times that of an example that is left out.
pub(crate) struct Fade<'a> {
    rig: &'a Rig,
    gain: f64,
    /// F: the mean gain of each edge's two handles; empty where all are 1.
    gains: Vec<f32>,
    vertex_triangles: VertexTriangles,
    /// frames × F: the lesser confidence of each edge's two handles; empty where the take has none below 1.
    edges: Vec<f32>,
    /// Where some frame is far from the examples.
    far: Option<Uncertainty>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl<'a> Fade<'a> {
    /// `None` where all leave everything as it is. The take by which it fades, if it does, has all of the rig's handles, at these
    /// frames × H positions.
    ///
    /// # Errors
    /// As [`Uncertainty::new`].
    pub(crate) fn new(
        rig: &'a Rig,
        gain: f64,
        gains: &[f32],
        fades: Option<(&Take, &[f32])>,
    ) -> Result<Option<Self>> {
        let gains = if gains.iter().all(|gain| *gain == 1.0) { Vec::new() } else { edge_gains(rig, gains) };
        let vertex_triangles = || VertexTriangles::new(rig.vertices(), &rig.triangles);
        let Some((take, handle_positions)) = fades else {
            let edges = Vec::new();
            let (positions, normals) = (Vec::new(), Vec::new());
            let gained = || Self {
                rig,
                gain,
                gains: gains.clone(),
                vertex_triangles: vertex_triangles(),
                edges,
                far: None,
                positions,
                normals,
            };
            return Ok((gain != 1.0 || !gains.is_empty()).then(gained));
        };
        let marker = |label: &String| take.labels.iter().position(|known| known == label);
        let markers: Vec<usize> = rig.labels.iter().filter_map(marker).collect();
        let mut edges: Vec<f32> = take.confidence.as_ref().map_or_else(Vec::new, |confidence| {
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
        let far = Uncertainty::new(rig, handle_positions)?.filter(is_far);
        if gain == 1.0 && gains.is_empty() && edges.is_empty() && far.is_none() {
            return Ok(None);
        }
        let vertex_triangles = vertex_triangles();
        Ok(Some(Self {
            rig,
            gain,
            gains,
            vertex_triangles,
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
        let mut frames = frames;
        self.gain != 1.0
            || !self.gains.is_empty()
            || unsure
            || self.far.as_ref().is_some_and(|far| frames.any(|frame| far.is_far(frame)))
    }

    /// A frame's 3V positions and normals (empty where they are not wanted) after the fading, from those before and the 3V
    /// positions of its large scale. Where nothing fades they are what came in; where something does, all normals are
    /// computed anew.
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
        let mut fades = false;
        self.positions.clear();
        let pairs = large_scale.as_chunks::<3>().0.iter().zip(positions.as_chunks::<3>().0);
        self.positions.extend(pairs.enumerate().map(|(v, (smooth, full))| {
            let mut c = if confidence.is_empty() { 1.0 } else { of_vertex(self.rig, v, confidence) };
            if let Some((far, samples)) = far {
                c *= (2.0 - far.times(v, samples) / FAR).clamp(0.0, 1.0);
            }
            c = c.min(1.0) * self.gain;
            if !self.gains.is_empty() {
                c *= of_vertex(self.rig, v, &self.gains);
            }
            if c == 1.0 {
                return *full;
            }
            fades = true;
            std::array::from_fn(|i| {
                let (smooth, full) = (f64::from(smooth[i]), f64::from(full[i]));
                (smooth + c * (full - smooth)) as f32
            })
        }));
        if !fades {
            return unchanged;
        }
        if !normals.is_empty() {
            let vertices = self.rig.vertices();
            self.normals.resize(vertices, [0.0; 3]);
            normals::normals(
                normals::Params::whole(1, vertices),
                &self.positions,
                &self.rig.triangles,
                &self.vertex_triangles,
                &mut self.normals,
            );
        }
        [self.positions.as_flattened(), self.normals.as_flattened()]
    }
}

/// The mean gain of the two handles of each of the F edges.
fn edge_gains(rig: &Rig, gains: &[f32]) -> Vec<f32> {
    let mean = |&[a, b]: &[u32; 2]| 0.5 * (gains[a as usize] + gains[b as usize]);
    rig.strain_edges.iter().map(mean).collect()
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
