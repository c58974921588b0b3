#![doc = include_str!("README.md")]
use crate::params::parameter_block;
use crate::{Real, vec3};

parameter_block!(
    /// Frames in the batch.
    frames,
    /// H.
    handles,
    /// F.
    strain_edges,
);

/// The twin.
pub fn strain<T: Real>(
    params: Params,
    handle_positions: &[[T; 3]],
    strain_edges: &[[u32; 2]],
    rest_lengths: &[T],
    features: &mut [T],
) {
    let (handles, edges) = (params.handles as usize, params.strain_edges as usize);
    for frame in 0..params.frames as usize {
        let p = &handle_positions[frame * handles..][..handles];
        for i in 0..edges {
            let [a, b] = strain_edges[i];
            let length = vec3::length(vec3::sub(p[a as usize], p[b as usize]));
            features[frame * edges + i] = (length - rest_lengths[i]) / rest_lengths[i];
        }
    }
}

/// l: the F lengths of the strain edges at rest, from the rest positions of the handles' vertices.
pub fn rest_lengths<T: Real>(rest: &[[T; 3]], handles: &[u32], strain_edges: &[[u32; 2]]) -> Vec<T> {
    let vertex = |handle: u32| rest[handles[handle as usize] as usize];
    strain_edges.iter().map(|&[a, b]| vec3::length(vec3::sub(vertex(a), vertex(b)))).collect()
}
