//! Normals where a few vertices moved.

use rayon::prelude::*;
use rhytid_core::Rig;
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};

/// Computes the normals of the vertices that moved and of those beside them from the V positions; the others keep every bit. Nothing where there are
/// no normals.
pub(crate) fn update(
    rig: &Rig,
    triangles: &VertexTriangles,
    moved: impl Iterator<Item = u32>,
    positions: &[[f32; 3]],
    normals: &mut [[f32; 3]],
) {
    if normals.is_empty() {
        return;
    }
    let mut is_beside = vec![false; positions.len()];
    for v in moved {
        let corners = triangles.at(v as usize).iter().flat_map(|&t| rig.triangles[t as usize]);
        corners.for_each(|v| is_beside[v as usize] = true);
    }
    normals.par_iter_mut().enumerate().filter(|(v, _)| is_beside[*v]).for_each(|(v, normal)| {
        *normal = vertex_normal(positions, &rig.triangles, triangles.at(v));
    });
}
