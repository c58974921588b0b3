//! The falloff of edits of markers: vertices that edited markers do not drive keep every bit of the take.

use crate::{EditedTake, local_normals};
use rhytid_core::Rig;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_solve::DrivenComponents;

/// The shares of a vertex that edited markers drive, between which its following fades in.
///
/// Below the first share the vertex does not follow the edit. Above the second it follows the edit fully.
const DRIVEN: [f64; 2] = [0.05, 0.95];

/// How far each vertex follows edits of markers.
///
/// Vertex v of a frame is at `x + w_v (x' − x)`, where x is its place without the edits and x' is its place
/// with them. w_v is a smooth step of the share of v that the edited handles drive. The share is the sum of
/// v's row of the basis over the edited handles. In a part without a handle, such as a tooth, it is the
/// weight of the anchors that are edited.
///
/// The share is 1 at edited handles and 0 at the others, so all markers are met. w does not change over time,
/// so there is no step in time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EditFalloff {
    /// w, V from 0 to 1.
    weights: Vec<f32>,
}

impl EditFalloff {
    /// The falloff of an edited take; `None` where nothing was edited, or where all of the face follows.
    pub(crate) fn new(rig: &Rig, take: &EditedTake) -> Option<Self> {
        let edited: Vec<bool> = rig.handles().labels.iter().map(|label| take.is_edited(label)).collect();
        Self::of_handles(rig, &edited)
    }

    /// The falloff where these of the H handles are edited; `None` as for [`EditFalloff::new`].
    pub(crate) fn of_handles(rig: &Rig, edited: &[bool]) -> Option<Self> {
        let edited: Vec<f64> = edited.iter().map(|edited| f64::from(u8::from(*edited))).collect();
        if edited.iter().all(|edited| *edited == 0.0) || edited.iter().all(|edited| *edited == 1.0) {
            return None;
        }
        let components = DrivenComponents::of_surface(rig.surface(), &rig.handles().points);
        let of_vertex = |(v, row): (usize, &[f32])| {
            let driven: f64 = match rig.learned().filter(|_| !components.driven[v]) {
                Some(learned) => learned.anchors_of(v).map(|(h, nu)| f64::from(nu) * edited[h.index()]).sum(),
                None => row.iter().zip(&edited).map(|(b, edited)| f64::from(*b) * edited).sum(),
            };
            let s = ((driven - DRIVEN[0]) / (DRIVEN[1] - DRIVEN[0])).clamp(0.0, 1.0);
            (s * s * (3.0 - 2.0 * s)) as f32
        };
        let rows = rig.basis().rows().enumerate();
        Some(Self { weights: rows.map(of_vertex).collect() })
    }

    /// The vertices that follow the edits at least in part, ascending.
    pub(crate) fn followers(&self) -> impl Iterator<Item = u32> {
        (0..).zip(&self.weights).filter(|(_, weight)| **weight > 0.0).map(|(v, _)| v)
    }

    /// The place of vertex `v` in the result, given its places without and with the edits.
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

    /// Blends V positions without the edits into those with the edits. The result replaces `with`.
    pub(crate) fn blend(&self, without: &[[f32; 3]], with: &mut [[f32; 3]]) {
        for (v, (x, was)) in with.iter_mut().zip(without).enumerate() {
            *x = self.between(v, *was, *x);
        }
    }

    /// Updates the normals of positions that were blended.
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
