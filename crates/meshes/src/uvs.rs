//! Texture coordinates on their way into a mesh.

use rhytid_core::Uvs;

/// `values` with one entry per corner in `corners`, in the simplest form: without `corners` where they say
/// nothing that the faces' `indices` do not say already.
pub(super) fn uvs_from_corners(
    values: Vec<[f32; 2]>,
    corners: Vec<u32>,
    vertices: usize,
    indices: &[u32],
) -> Uvs {
    let per_vertex = values.len() == vertices && corners == indices;
    Uvs { values, corners: (!per_vertex).then_some(corners) }
}

/// Says once that texture coordinates which only some corners have are dropped.
pub(super) fn warn_partial_uvs(name: &str, without: usize, corners: usize) {
    log::warn!(
        "{name}: {without} of {corners} face corners have no texture coordinates, so those of the other \
         corners are ignored"
    );
}
