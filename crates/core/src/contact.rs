//! Where parts of a face touch: lids on eyeballs, and skin on skin.
use crate::rig::number;
use crate::rig_check::{below, fail, finite};
use crate::{Openings, Result, VertexId};
use rhytid_kernels::{Real, vec3};

/// Eyeballs, the lids that slide on them (`docs/method.md`, keep lids on their eyeballs), and openings of the
/// skin. Each is empty where none was recognised.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contact<T: Real = f32> {
    /// The eyeballs.
    pub eyeballs: Vec<Eyeball<T>>,
    /// The vertices on and around the lids, one eyeball after the other.
    pub lids: Vec<LidVertex<T>>,
    /// Lips, lids and other skin that meets skin.
    pub openings: Openings<T>,
}

/// An eyeball: a part that moves as a solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eyeball<T: Real = f32> {
    /// Four vertices of the part that are not in a plane.
    pub corners: [VertexId; 4],
    /// The centre is the sum of the corners with these weights, whose sum is 1. It holds for all motions of
    /// the solid.
    pub weights: [T; 4],
}

/// A vertex that slides on an eyeball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LidVertex<T: Real = f32> {
    /// The vertex.
    pub vertex: VertexId,
    /// Its number in [`Contact::eyeballs`].
    pub eyeball: u32,
    /// The number in [`Contact::lids`] of the vertex that this one moves with, as a lash does with its lid.
    /// It is its own number in the skin.
    pub leader: u32,
    /// The least distance from the centre, above 0, in mesh units.
    pub nearest: T,
    /// The greatest distance from the centre, not below `nearest`.
    pub farthest: T,
}

impl<T: Real> Eyeball<T> {
    /// The centre, given V positions.
    pub fn center(&self, positions: &[[T; 3]]) -> [f64; 3] {
        let at = |v: VertexId| positions[v.index()].map(Real::widen);
        let first = at(self.corners[0]);
        let mut center = first;
        for (corner, weight) in self.corners.iter().zip(self.weights).skip(1) {
            let from_first = vec3::sub(at(*corner), first);
            center = vec3::add(center, from_first.map(|x| weight.widen() * x));
        }
        center
    }
}

impl<T: Real> Contact<T> {
    /// Whether nothing touches.
    pub fn is_empty(&self) -> bool {
        self.eyeballs.is_empty() && self.openings.rims.is_empty()
    }

    /// The same in another precision.
    pub(crate) fn cast<U: Real>(&self) -> Contact<U> {
        let eyeball =
            |eyeball: &Eyeball<T>| Eyeball { corners: eyeball.corners, weights: eyeball.weights.map(number) };
        let lid = |lid: &LidVertex<T>| LidVertex {
            vertex: lid.vertex,
            eyeball: lid.eyeball,
            leader: lid.leader,
            nearest: number(lid.nearest),
            farthest: number(lid.farthest),
        };
        Contact {
            eyeballs: self.eyeballs.iter().map(eyeball).collect(),
            lids: self.lids.iter().map(lid).collect(),
            openings: self.openings.cast(),
        }
    }

    /// Checks all numbers, for a face of so many vertices.
    pub(crate) fn check(&self, vertices: usize) -> Result<()> {
        self.openings.check(vertices)?;
        let corners: Vec<VertexId> = self.eyeballs.iter().flat_map(|eyeball| eyeball.corners).collect();
        below("eyeball_corners", VertexId::numbers(&corners), vertices)?;
        let weights: Vec<T> = self.eyeballs.iter().flat_map(|eyeball| eyeball.weights).collect();
        finite("eyeball_weights", &weights)?;
        let lids: Vec<VertexId> = self.lids.iter().map(|lid| lid.vertex).collect();
        below("lid_vertices", VertexId::numbers(&lids), vertices)?;
        for (i, lid) in self.lids.iter().enumerate() {
            if lid.eyeball as usize >= self.eyeballs.len() || lid.leader as usize >= self.lids.len() {
                return fail(format!("lid_vertices[{i}] names an eyeball or a vertex that is not there"));
            }
            let (nearest, farthest) = (lid.nearest.widen(), lid.farthest.widen());
            if !(nearest > 0.0 && farthest >= nearest && farthest.is_finite()) {
                return fail(format!(
                    "lid_distances[{i}] is {nearest} and {farthest}, expected two lengths above 0, the \
                     smaller one first"
                ));
            }
        }
        Ok(())
    }
}
