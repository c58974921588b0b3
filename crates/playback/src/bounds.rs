//! How far edits of markers reach: what the markers that are edited do not hold stays as the take has it, bit for bit.

use crate::local_normals;
use rhytid_core::{Rig, Take};
use rhytid_kernels::normals::VertexTriangles;

/// What is held by edited markers by less of it stays, and by more of it than the second is edited whole; between the two it goes over smoothly.
const HELD: [f64; 2] = [0.05, 0.95];

/// Behind a handle's label: the column where the take has the handle as it was before the edits.
const AS_IT_WAS: &str = " as it was";

/// The label of a handle's column that has it as it was before the edits.
pub(crate) fn as_it_was(label: &str) -> String {
    format!("{label}{AS_IT_WAS}")
}

/// How much of each vertex edited markers hold.
///
/// Vertex v of a frame is at `x + w_v (x' − x)`, of its places x without and x' with the edits. w_v is the sum of its row of the basis over the handles that are edited in any
/// frame, which is 1 at these and 0 at the others, or where it has no such row, as a tooth, what it listens to of them; and of that what
/// goes from 0 to 1 between the two of [`HELD`]. So markers are met, edited and not, what no edited marker holds keeps every bit, and since w does not change
/// over time there is no step.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bounds {
    /// V, from 0 to 1.
    weights: Vec<f32>,
}

impl Bounds {
    /// Of a take that was edited; `None` where nothing was, or all of the face follows.
    pub(crate) fn new(rig: &Rig, take: &Take) -> Option<Self> {
        let is_edited = |label: &String| take.labels.contains(&as_it_was(label));
        let edited: Vec<f64> = rig.labels.iter().map(|label| f64::from(u8::from(is_edited(label)))).collect();
        if edited.iter().all(|edited| *edited == 0.0) || edited.iter().all(|edited| *edited == 1.0) {
            return None;
        }
        let edges = rig.strain_edges.len();
        let of_feature = |e: usize| match rig.strain_edges.get(e) {
            Some(&[a, b]) => 0.5 * (edited[a as usize] + edited[b as usize]),
            None => edited[e - edges],
        };
        let of_vertex = |(v, row): (usize, &[f32])| {
            let held = match row.iter().any(|b| *b != 0.0) {
                true => row.iter().zip(&edited).map(|(b, edited)| f64::from(*b) * edited).sum::<f64>(),
                false => {
                    let parts = rig.listens_to(v).map(|(e, weight)| (weight, weight * of_feature(e)));
                    let (all, held) = parts.fold((0.0, 0.0), |(all, held), (w, of)| (all + w, held + of));
                    if all > 0.0 { held / all } else { 0.0 }
                }
            };
            let s = ((held - HELD[0]) / (HELD[1] - HELD[0])).clamp(0.0, 1.0);
            (s * s * (3.0 - 2.0 * s)) as f32
        };
        let rows = rig.basis.chunks_exact(rig.handles.len()).enumerate();
        Some(Self { weights: rows.map(of_vertex).collect() })
    }

    /// frames × H × 3 positions as they were before the edits, from those after them.
    pub(crate) fn unedited(rig: &Rig, take: &Take, edited: &[f32]) -> Vec<f32> {
        let mut positions = edited.to_vec();
        for (h, label) in rig.labels.iter().enumerate() {
            let label = as_it_was(label);
            let Some(column) = take.labels.iter().position(|other| *other == label) else { continue };
            let frames = positions.chunks_exact_mut(3 * rig.labels.len());
            for (frame, was) in frames.zip(take.positions.chunks_exact(take.labels.len())) {
                frame[3 * h..3 * h + 3].iter_mut().zip(was[column]).for_each(|(x, was)| *x = was as f32);
            }
        }
        positions
    }

    /// The vertices of which edited markers hold anything, ascending.
    pub(crate) fn held(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.weights).filter(|(_, weight)| **weight > 0.0).map(|(v, _)| v)
    }

    /// Where vertex `v` is shown that is at these two places without and with the edits.
    pub(crate) fn between(&self, v: usize, without: [f32; 3], with: [f32; 3]) -> [f32; 3] {
        match self.weights[v] {
            0.0 => without,
            1.0 => with,
            w => std::array::from_fn(|c| {
                let was = f64::from(without[c]);
                (was + f64::from(w) * (f64::from(with[c]) - was)) as f32
            }),
        }
    }

    /// From V positions without the edits and those with them to what is shown, in place of the latter.
    pub(crate) fn blend(&self, without: &[[f32; 3]], with: &mut [[f32; 3]]) {
        for (v, (x, was)) in with.iter_mut().zip(without).enumerate() {
            *x = self.between(v, *was, *x);
        }
    }

    /// The same of the normals of positions that were blended.
    pub(crate) fn blend_normals(
        &self,
        rig: &Rig,
        triangles: &VertexTriangles,
        positions: &[[f32; 3]],
        without: &[[f32; 3]],
        with: &mut [[f32; 3]],
    ) {
        for ((n, was), weight) in with.iter_mut().zip(without).zip(&self.weights) {
            if *weight == 0.0 {
                *n = *was;
            }
        }
        let between = (0..).zip(&self.weights).filter(|(_, w)| **w > 0.0 && **w < 1.0).map(|(v, _)| v);
        local_normals::update(rig, triangles, between, positions, with);
    }
}
