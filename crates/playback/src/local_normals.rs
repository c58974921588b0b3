//! Updates of normals where a few vertices moved.

use rayon::prelude::*;
use rhytid_core::Rig;
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};

/// Computes the normals of the vertices that moved, and of their neighbours, from the V positions. All other
/// normals keep every bit. Does nothing where `normals` is empty.
pub(crate) fn update(
    rig: &Rig,
    triangles: &VertexTriangles,
    moved: impl Iterator<Item = u32>,
    positions: &[[f32; 3]],
    normals: &mut [[f32; 3]],
) {
    let mut moved = moved.peekable();
    if !normals.is_empty() && moved.peek().is_some() {
        update_where(&beside(rig, triangles, moved), rig, triangles, positions, normals);
    }
}

/// V: whether a vertex is one of `vertices` or a neighbour of one, so that its normal changes where they
/// move.
pub(crate) fn beside(
    rig: &Rig,
    triangles: &VertexTriangles,
    vertices: impl Iterator<Item = u32>,
) -> Vec<bool> {
    let mut beside = vec![false; rig.vertices()];
    for v in vertices {
        let corners = triangles.at(v as usize).iter().flat_map(|&t| rig.surface().triangles[t as usize]);
        corners.for_each(|v| beside[rig.surface().first(v) as usize] = true);
    }
    rig.surface().spread(&mut beside);
    beside
}

/// Computes the normals of the vertices that `vertices` (V) marks.
pub(crate) fn update_where(
    vertices: &[bool],
    rig: &Rig,
    triangles: &VertexTriangles,
    positions: &[[f32; 3]],
    normals: &mut [[f32; 3]],
) {
    normals.par_iter_mut().enumerate().filter(|(v, _)| vertices[*v]).for_each(|(v, normal)| {
        *normal = vertex_normal(positions, &rig.surface().triangles, triangles.at(v));
    });
}
