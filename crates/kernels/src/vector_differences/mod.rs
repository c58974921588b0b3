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
    /// 2 × (F + H).
    pub feature_bounds: &'a [[T; 3]],
}

/// D of feature `e` of a frame, limited to its bounds, from the H displacements of the handles.
pub fn vector_strain<T: Real>(buffers: &Buffers<'_, T>, u: &[[T; 3]], e: usize) -> [T; 3] {
    let (edges, features) = (buffers.strain_edges.len(), buffers.feature_lengths.len());
    let moved = match buffers.strain_edges.get(e) {
        Some(&[a, b]) => vec3::sub(u[b as usize], u[a as usize]),
        None => u[e - edges],
    };
    let (least, most) = (buffers.feature_bounds[e], buffers.feature_bounds[features + e]);
    std::array::from_fn(|c| match moved[c] / buffers.feature_lengths[e] {
        x if x < least[c] => least[c],
        x if x > most[c] => most[c],
        x => x,
    })
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
