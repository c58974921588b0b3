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

/// The reference.
pub fn strain<T: Real>(
    params: Params,
    handle_positions: &[[T; 3]],
    handle_rest: &[[T; 3]],
    strain_edges: &[[u32; 2]],
    rest_lengths: &[T],
    features: &mut [T],
) {
    let (handles, edges) = (params.handles as usize, params.strain_edges as usize);
    for frame in 0..params.frames as usize {
        let p = &handle_positions[frame * handles..][..handles];
        for i in 0..edges {
            let [a, b] = strain_edges[i].map(|h| h as usize);
            let e = vec3::sub(p[a], p[b]);
            let e_rest = vec3::sub(handle_rest[a], handle_rest[b]);
            let moved = vec3::sub(vec3::sub(p[a], handle_rest[a]), vec3::sub(p[b], handle_rest[b]));
            let sum = vec3::add(e, e_rest);
            let l = rest_lengths[i];
            features[frame * edges + i] = vec3::dot(moved, sum) / (vec3::length(e) + l) / l;
        }
    }
}

/// l: the F lengths of the strain edges at rest, from the rest positions of the handles' vertices.
pub fn rest_lengths<T: Real>(rest: &[[T; 3]], handles: &[u32], strain_edges: &[[u32; 2]]) -> Vec<T> {
    let vertex = |handle: u32| rest[handles[handle as usize] as usize];
    strain_edges.iter().map(|&[a, b]| vec3::length(vec3::sub(vertex(a), vertex(b)))).collect()
}
