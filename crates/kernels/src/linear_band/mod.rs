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

/// What the twin reads of a rig: the vertices of the part alone, and each one's features as the rig has them.
#[derive(Debug, Clone, Copy)]
pub struct Buffers<'a, T> {
    /// Features of each vertex.
    pub per_vertex: usize,
    /// V × `per_vertex` indices of features.
    pub features: &'a [u32],
    /// ω, V × `per_vertex`.
    pub weights: &'a [T],
    /// c, V×P.
    pub example_weights: &'a [[T; 3]],
}

/// Σ_p c_vp κ_vp of vertex `i` of the part, given the table of one frame.
pub fn vertex_offset<T: Real>(params: Params, buffers: &Buffers<'_, T>, table: &[T], i: usize) -> [T; 3] {
    let (per_vertex, examples) = (buffers.per_vertex, params.examples as usize);
    let features = &buffers.features[i * per_vertex..][..per_vertex];
    let weights = &buffers.weights[i * per_vertex..][..per_vertex];
    let mut offset = [T::ZERO; 3];
    for (p, c) in buffers.example_weights[i * examples..][..examples].iter().enumerate() {
        let mut kappa = T::ZERO;
        for (&e, &omega) in features.iter().zip(weights) {
            kappa = omega.mul_add(table[table_index(params.features as usize, e as usize, p)], kappa);
        }
        for axis in 0..3 {
            offset[axis] = c[axis].mul_add(kappa, offset[axis]);
        }
    }
    offset
}

/// The twin.
pub fn linear_band<T: Real>(
    params: Params,
    basis_positions: &[[T; 3]],
    strain_products: &[T],
    buffers: &Buffers<'_, T>,
    large_scale_positions: &mut [[T; 3]],
) {
    let vertices = params.vertices as usize;
    let len = table_len(params.features as usize, params.examples as usize);
    for frame in 0..params.frames as usize {
        let table = &strain_products[frame * len..][..len];
        for i in 0..params.part_vertices as usize {
            let v = frame * vertices + params.first_vertex as usize + i;
            let offset = vertex_offset(params, buffers, table, i);
            large_scale_positions[v] = std::array::from_fn(|c| basis_positions[v][c] + offset[c]);
        }
    }
}
