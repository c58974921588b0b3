//! Folds that fade where the markers that drive them were filled rather than measured.

use rhytid_core::{Rig, Take};
use rhytid_kernels::normals::{self, VertexTriangles};
use std::ops::Range;

/// Takes detail away from the frames of a take as its confidence says.
///
/// Vertex v of a frame is at x̃ + c_v (x − x̃), between the large scale x̃ and the full result x. c_v is the confidence of
/// the strain edges that v listens to, weighted by its influences: Σ_k α_vk min(c_a, c_b) / Σ_k α_vk, where edge k joins
/// the handles a and b. A vertex without influences has no detail to fade.
pub(crate) struct Fade<'a> {
    rig: &'a Rig,
    vertex_triangles: VertexTriangles,
    /// frames × F: the lesser confidence of each edge's two handles.
    edges: Vec<f32>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl<'a> Fade<'a> {
    /// `None` where the take's confidence leaves everything as it is. The take has all of the rig's handles.
    pub(crate) fn new(rig: &'a Rig, take: &Take) -> Option<Self> {
        let confidence = take.confidence.as_ref()?;
        let marker = |label: &String| take.labels.iter().position(|known| known == label);
        let markers: Vec<usize> = rig.labels.iter().map(marker).collect::<Option<_>>()?;
        let edges: Vec<f32> = confidence
            .chunks_exact(take.labels.len())
            .flat_map(|frame| {
                let at = |handle: u32| frame[markers[handle as usize]];
                rig.strain_edges.iter().map(move |&[a, b]| at(a).min(at(b)))
            })
            .collect();
        let vertex_triangles = VertexTriangles::new(rig.vertices(), &rig.triangles);
        let fades = edges.iter().any(|&c| c < 1.0);
        fades.then(|| Self { rig, vertex_triangles, edges, positions: Vec::new(), normals: Vec::new() })
    }

    /// Whether any of these frames may need its large scale.
    pub(crate) fn touches(&self, frames: Range<usize>) -> bool {
        let edges = self.rig.strain_edges.len();
        self.edges[frames.start * edges..frames.end * edges].iter().any(|&c| c < 1.0)
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
        let confidence = &self.edges[frame * edges..][..edges];
        let mut fades = false;
        self.positions.clear();
        let pairs = large_scale.as_chunks::<3>().0.iter().zip(positions.as_chunks::<3>().0);
        self.positions.extend(pairs.enumerate().map(|(v, (smooth, full))| {
            let c = vertex_confidence(self.rig, v, confidence);
            if c >= 1.0 {
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

/// c_v, from the confidence of the F edges.
fn vertex_confidence(rig: &Rig, v: usize, edges: &[f32]) -> f64 {
    let k = rig.influences();
    let influences = rig.influence_edges[v * k..][..k].iter().zip(&rig.influence_weights[v * k..][..k]);
    let (mut weighted, mut total) = (0.0, 0.0);
    for (&edge, &alpha) in influences {
        weighted += f64::from(alpha) * f64::from(edges[edge as usize]);
        total += f64::from(alpha);
    }
    if total > 0.0 { weighted / total } else { 1.0 }
}
