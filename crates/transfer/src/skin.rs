//! The part of a face's mesh that takes part in a transfer: the components with a landmark.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_geometry::{Closest, Surface};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use std::collections::BTreeSet;

/// A triangle is a counterpart only if the cosine between its normal and the vertex's is above this.
const FACING: f64 = 0.75;

/// A surface on which counterparts are searched.
pub(crate) struct Skin<'a> {
    pub positions: Vec<DVec3>,
    pub triangles: &'a [[u32; 3]],
    pub at_vertices: VertexTriangles,
    /// V: whether a vertex takes part.
    pub takes_part: Vec<bool>,
    /// V normals of length 1; 0 where there is no area.
    pub normals: Vec<DVec3>,
    /// Edges with a triangle on one side only, the lower vertex first.
    border: BTreeSet<[u32; 2]>,
}

impl<'a> Skin<'a> {
    /// The skin of V positions, of which those count that `takes_part`.
    pub(crate) fn new(positions: Vec<DVec3>, triangles: &'a [[u32; 3]], takes_part: Vec<bool>) -> Self {
        let at_vertices = VertexTriangles::new(positions.len(), triangles);
        let mut skin = Self {
            positions,
            triangles,
            at_vertices,
            takes_part,
            normals: Vec::new(),
            border: BTreeSet::new(),
        };
        skin.normals = skin.normals_of(&skin.positions);
        for t in triangles {
            for [a, b] in edges(t) {
                let edge = [a.min(b), a.max(b)];
                // A second occurrence of an edge is a triangle on its other side.
                if !skin.border.remove(&edge) {
                    skin.border.insert(edge);
                }
            }
        }
        skin
    }

    /// The normals for other positions of the vertices.
    pub(crate) fn normals_of(&self, positions: &[DVec3]) -> Vec<DVec3> {
        let points: Vec<[f64; 3]> = positions.iter().map(DVec3::to_array).collect();
        let normal = |v| DVec3::from_array(vertex_normal(&points, self.triangles, self.at_vertices.at(v)));
        (0..points.len()).into_par_iter().map(normal).collect()
    }

    /// The part that takes part, as a surface with the normals of its triangles.
    pub(crate) fn facing(&self, positions: &[DVec3]) -> Facing {
        let corners = |t: usize| self.triangles[t].map(|v| positions[v as usize]);
        let normal = |t: usize| {
            let [a, b, c] = corners(t);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let takes_part =
            |t: &usize| self.takes_part[self.triangles[*t][0] as usize] && !is_degenerate(corners(*t));
        let all = 0..self.triangles.len();
        Facing {
            surface: Surface::new(all.clone().filter(takes_part).map(|t| (t, corners(t)))),
            normals: all.map(normal).collect(),
        }
    }

    /// Whether a closest point is on the border. If so, the true counterpart may be beyond.
    pub(crate) fn is_border(&self, closest: &Closest) -> bool {
        let corners = self.triangles[closest.triangle];
        let is_border = |a: u32, b: u32| self.border.contains(&[a.min(b), a.max(b)]);
        let on: Vec<u32> = (0..3).filter(|&i| closest.weights[i] > 0.0).map(|i| corners[i]).collect();
        match on[..] {
            [a, b] => is_border(a, b),
            [v] => self.at_vertices.at(v as usize).iter().any(|&t| {
                let of_triangle = edges(&self.triangles[t as usize]);
                of_triangle.into_iter().any(|[a, b]| (a == v || b == v) && is_border(a, b))
            }),
            _ => false,
        }
    }
}

fn edges(&[a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// A surface with a front and a back side.
pub(crate) struct Facing {
    surface: Surface,
    normals: Vec<DVec3>,
}

impl Facing {
    /// The closest point within a distance that faces the same way as `normal`.
    pub(crate) fn closest(&self, p: DVec3, normal: DVec3, within: f64) -> Option<Closest> {
        self.surface.closest_that(p, within, |t| self.normals[t].dot(normal) > FACING)
    }

    /// Whether any surface is within a distance, whichever way it faces.
    pub(crate) fn has_any(&self, p: DVec3, within: f64) -> bool {
        self.surface.closest_that(p, within, |_| true).is_some()
    }
}
