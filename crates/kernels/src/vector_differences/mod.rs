#![doc = include_str!("README.md")]
use crate::differences::{CENTERS_AT_ONCE, table_index, table_len};
use crate::params::parameter_block;
use crate::{Real, vec3};

parameter_block!(
    /// Frames in the batch.
    frames,
    /// H.
    handles,
    /// F.
    strain_edges,
    /// N, the rest pose included.
    centers,
);

/// The data of a rig that the reference reads.
#[derive(Debug, Clone, Copy)]
pub struct Buffers<'a, T> {
    /// F × 2.
    pub strain_edges: &'a [[u32; 2]],
    /// F + H, in mesh units.
    pub feature_lengths: &'a [T],
    /// P × (F + H).
    pub example_vectors: &'a [[T; 3]],
    /// F + H, ratios.
    pub feature_limits: &'a [T],
}

/// A vector strain of its own direction, at most as long as `limit`.
pub fn limited<T: Real>(d: [T; 3], limit: T) -> [T; 3] {
    let size = vec3::dot(d, d).sqrt();
    if size > limit { d.map(|x| x * (limit / size)) } else { d }
}

/// D of feature `e` of a frame, as far as it is followed, from the H displacements of the handles.
pub fn vector_strain<T: Real>(buffers: &Buffers<'_, T>, u: &[[T; 3]], e: usize) -> [T; 3] {
    limited(whole_vector_strain(buffers, u, e), buffers.feature_limits[e])
}

/// The part of D of feature `e` that is not followed.
pub fn vector_excess<T: Real>(buffers: &Buffers<'_, T>, u: &[[T; 3]], e: usize) -> [T; 3] {
    let d = whole_vector_strain(buffers, u, e);
    vec3::sub(d, limited(d, buffers.feature_limits[e]))
}

fn whole_vector_strain<T: Real>(buffers: &Buffers<'_, T>, u: &[[T; 3]], e: usize) -> [T; 3] {
    let edges = buffers.strain_edges.len();
    let moved = match buffers.strain_edges.get(e) {
        Some(&[a, b]) => vec3::sub(u[b as usize], u[a as usize]),
        None => u[e - edges],
    };
    moved.map(|x| x / buffers.feature_lengths[e])
}

/// The reference. `displacements` is frames × H.
pub fn vector_differences<T: Real>(
    params: Params,
    displacements: &[[T; 3]],
    buffers: &Buffers<'_, T>,
    squared_vector_differences: &mut [T],
) {
    let (handles, centers) = (params.handles as usize, params.centers as usize);
    let features = params.strain_edges as usize + handles;
    let len = table_len(features, centers);
    for frame in 0..params.frames as usize {
        let u = &displacements[frame * handles..][..handles];
        let table = &mut squared_vector_differences[frame * len..][..len];
        for e in 0..features {
            let d = vector_strain(buffers, u, e);
            for j in 0..centers.next_multiple_of(CENTERS_AT_ONCE) {
                table[table_index(features, e, j)] = match j {
                    0 => vec3::dot(d, d),
                    _ if j >= centers => T::ZERO,
                    _ => {
                        let away = vec3::sub(d, buffers.example_vectors[(j - 1) * features + e]);
                        vec3::dot(away, away)
                    }
                };
            }
        }
    }
}
