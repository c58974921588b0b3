#![doc = include_str!("README.md")]
use crate::{Real, vec3};
use bytemuck::{Pod, Zeroable};

/// The parameter block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Params {
    /// Frames in the batch.
    pub frames: u32,
    /// V.
    pub vertices: u32,
    /// F.
    pub strain_edges: u32,
    /// K.
    pub influences: u32,
    /// N, the rest pose included.
    pub centers: u32,
}

/// What the kernel reads of a rig.
#[derive(Debug, Clone, Copy)]
pub struct Buffers<'a, T> {
    /// V×K indices of strain edges.
    pub influence_edges: &'a [u32],
    /// α, V×K.
    pub influence_weights: &'a [T],
    /// N×F.
    pub pose_features: &'a [T],
    /// w, V×N.
    pub rbf_weights: &'a [[T; 3]],
    /// V indices of vertices.
    pub frame_neighbors: &'a [u32],
}

/// The columns t, b, n of a local frame (method, section 5), from the way to the frame neighbour.
pub fn local_frame<T: Real>(to_neighbor: [T; 3], n: [T; 3]) -> [[T; 3]; 3] {
    let along = vec3::dot(to_neighbor, n);
    let t = vec3::normalize(std::array::from_fn(|c| to_neighbor[c] - along * n[c]));
    [t, vec3::cross(n, t), n]
}

/// ‖f − f_j‖_v: the distance of two features as a vertex with these influences sees it.
pub fn feature_distance<T: Real>(edges: &[u32], weights: &[T], f: &[T], f_j: &[T]) -> T {
    let mut sum = T::zero();
    for (&e, &alpha) in edges.iter().zip(weights) {
        let difference = f[e as usize] - f_j[e as usize];
        sum += alpha * (difference * difference);
    }
    sum.sqrt()
}

/// d_v of one vertex for the features `f` of one frame.
pub fn vertex_detail<T: Real>(params: Params, buffers: &Buffers<'_, T>, f: &[T], v: usize) -> [T; 3] {
    let (edges, k, n) = (params.strain_edges as usize, params.influences as usize, params.centers as usize);
    let influence_edges = &buffers.influence_edges[v * k..][..k];
    let influence_weights = &buffers.influence_weights[v * k..][..k];
    let mut d = [T::zero(); 3];
    for j in 0..n {
        let f_j = &buffers.pose_features[j * edges..][..edges];
        let r = feature_distance(influence_edges, influence_weights, f, f_j);
        let w = buffers.rbf_weights[v * n + j];
        for c in 0..3 {
            d[c] += w[c] * r;
        }
    }
    d
}

/// x̃ + R d.
pub fn add_detail<T: Real>(large_scale: [T; 3], [t, b, n]: [[T; 3]; 3], d: [T; 3]) -> [T; 3] {
    std::array::from_fn(|c| large_scale[c] + (t[c] * d[0] + b[c] * d[1] + n[c] * d[2]))
}

/// The twin.
pub fn fine_scale<T: Real>(
    params: Params,
    buffers: &Buffers<'_, T>,
    strain: &[T],
    large_scale: &[[T; 3]],
    large_scale_normals: &[[T; 3]],
    detail: &mut [[T; 3]],
    positions: &mut [[T; 3]],
) {
    let (vertices, edges) = (params.vertices as usize, params.strain_edges as usize);
    for frame in 0..params.frames as usize {
        let f = &strain[frame * edges..][..edges];
        for v in 0..vertices {
            let i = frame * vertices + v;
            let d = vertex_detail(params, buffers, f, v);
            let neighbor = frame * vertices + buffers.frame_neighbors[v] as usize;
            let to_neighbor = vec3::sub(large_scale[neighbor], large_scale[i]);
            let frame = local_frame(to_neighbor, large_scale_normals[i]);
            detail[i] = d;
            positions[i] = add_detail(large_scale[i], frame, d);
        }
    }
}
