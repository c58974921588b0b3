#![doc = include_str!("README.md")]
use crate::Real;
use crate::differences::{table_index, table_len};
use crate::params::parameter_block;

parameter_block!(
    /// Frames in the batch.
    frames,
    /// V.
    vertices,
    /// The first vertex of this part; 0 where the rig is in one piece.
    first_vertex,
    /// Vertices of this part.
    part_vertices,
    /// F + H.
    features,
    /// P.
    examples,
    /// 1 where `example_weights` is stored as fp16, 0 where it is not. The twin has its own type for it and does not look.
    fp16,
);

impl Params {
    /// For a rig in one piece, of V vertices, F + H features and P examples.
    pub fn whole(frames: usize, vertices: usize, features: usize, examples: usize) -> Self {
        let [frames, vertices, features, examples] = [frames, vertices, features, examples].map(|n| n as u32);
        Self { frames, vertices, first_vertex: 0, part_vertices: vertices, features, examples, fp16: 0 }
    }
}

/// The part of what a vertex listens to that is its strain edges'; anchors have the rest.
pub const EDGES_SHARE: f64 = 0.9;

/// What the twin reads of a rig: the vertices of the part alone, and what each listens to as the rig has it.
#[derive(Debug, Clone, Copy)]
pub struct Buffers<'a, T> {
    /// K.
    pub influences: usize,
    /// V×K indices of strain edges.
    pub influence_edges: &'a [u32],
    /// α, V×K.
    pub influence_weights: &'a [T],
    /// A.
    pub anchors_per_vertex: usize,
    /// V×A indices of handles.
    pub anchors: &'a [u32],
    /// ν, V×A.
    pub anchor_weights: &'a [T],
    /// c, V×P.
    pub example_weights: &'a [[T; 3]],
}

/// Σ_p c_vp κ_vp of vertex `i` of the part, given the table of one frame; `strain_edges` is F.
pub fn vertex_offset<T: Real>(
    params: Params,
    buffers: &Buffers<'_, T>,
    strain_edges: usize,
    table: &[T],
    i: usize,
) -> [T; 3] {
    let (k, a, examples) = (buffers.influences, buffers.anchors_per_vertex, params.examples as usize);
    let (edges, alphas) = (&buffers.influence_edges[i * k..][..k], &buffers.influence_weights[i * k..][..k]);
    let (anchors, nus) = (&buffers.anchors[i * a..][..a], &buffers.anchor_weights[i * a..][..a]);
    let mut offset = [T::ZERO; 3];
    for (p, c) in buffers.example_weights[i * examples..][..examples].iter().enumerate() {
        let at = |feature: usize| table[table_index(params.features as usize, feature, p)];
        let mut kappa = T::ZERO;
        for (&e, &alpha) in edges.iter().zip(alphas) {
            kappa = alpha.mul_add(at(e as usize), kappa);
        }
        kappa = T::round_from(EDGES_SHARE) * kappa;
        for (&h, &nu) in anchors.iter().zip(nus) {
            kappa = nu.mul_add(at(strain_edges + h as usize), kappa);
        }
        for axis in 0..3 {
            offset[axis] = c[axis].mul_add(kappa, offset[axis]);
        }
    }
    offset
}

/// The twin; `strain_edges` is F.
pub fn linear_band<T: Real>(
    params: Params,
    basis_positions: &[[T; 3]],
    (strain_products, strain_edges): (&[T], u32),
    buffers: &Buffers<'_, T>,
    large_scale_positions: &mut [[T; 3]],
) {
    let vertices = params.vertices as usize;
    let strain_edges = strain_edges as usize;
    let len = table_len(params.features as usize, params.examples as usize);
    for frame in 0..params.frames as usize {
        let table = &strain_products[frame * len..][..len];
        for i in 0..params.part_vertices as usize {
            let v = frame * vertices + params.first_vertex as usize + i;
            let offset = vertex_offset(params, buffers, strain_edges, table, i);
            large_scale_positions[v] = std::array::from_fn(|c| basis_positions[v][c] + offset[c]);
        }
    }
}
