//! Normals where a few vertices moved.

use rhytid_core::Rig;
use rhytid_kernels::normals::{self, VertexTriangles};

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
    let around = moved.flat_map(|v| triangles.at(v as usize));
    let mut vertices: Vec<u32> = around.flat_map(|&t| rig.triangles[t as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    for v in vertices {
        normals[v as usize] = normals::vertex_normal(positions, &rig.triangles, triangles.at(v as usize));
    }
}
