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
    /// F.
    strain_edges,
    /// N, the rest pose included.
    centers,
    /// 1 where a vertex's first weight is a constant of every frame and its pivot is the rest pose; otherwise
    /// 0.
    zero_at_rest,
);

impl Params {
    /// For a rig in one piece, of V vertices, F strain edges and N centres.
    pub fn whole(frames: usize, vertices: usize, edges: usize, centers: usize) -> Self {
        let [frames, vertices, strain_edges, centers] = [frames, vertices, edges, centers].map(|n| n as u32);
        Self {
            frames,
            vertices,
            first_vertex: 0,
            part_vertices: vertices,
            strain_edges,
            centers,
            zero_at_rest: 0,
        }
    }
}

/// The data of a rig that the reference reads: only the vertices of the part, and the influences of each in
/// the rig's order.
#[derive(Debug, Clone, Copy)]
pub struct Buffers<'a, T> {
    /// K.
    pub influences: usize,
    /// V×K indices of strain edges.
    pub influence_edges: &'a [u32],
    /// α, V×K.
    pub influence_weights: &'a [T],
    /// w, V×N, in the form that [`pivoted`] gives them, or with b in the first one's place.
    pub rbf_weights: &'a [[T; 3]],
    /// V indices of centres, as [`pivoted`] chose them, or all 0.
    pub pivots: &'a [u32],
}

/// Chooses a pivot for each vertex, the centre with the largest weight, and replaces its weight by the sum of
/// all the vertex's weights. `rbf_weights` is V×N. The sums are rounded once.
pub fn pivoted<T: Real>(rbf_weights: &[[T; 3]], centers: usize) -> (Vec<[T; 3]>, Vec<u32>) {
    let size = |w: &[T; 3]| w[0].abs().max(w[1].abs()).max(w[2].abs());
    let mut weights = rbf_weights.to_vec();
    let pivots = weights.chunks_exact_mut(centers).map(|w| {
        let pivot = (0..centers).fold(0, |best, j| if size(&w[j]) > size(&w[best]) { j } else { best });
        w[pivot] = std::array::from_fn(|c| T::round_from(w.iter().map(|w| w[c].widen()).sum()));
        pivot as u32
    });
    let pivots = pivots.collect();
    (weights, pivots)
}

/// ‖f − f_j‖_v: the distance of two features as a vertex with these influences sees it.
pub fn feature_distance<T: Real>(edges: &[u32], weights: &[T], f: &[T], f_j: &[T]) -> T {
    let mut sum = T::ZERO;
    for (&e, &alpha) in edges.iter().zip(weights) {
        let difference = f[e as usize] - f_j[e as usize];
        sum = alpha.mul_add(difference * difference, sum);
    }
    sum.sqrt()
}

/// d_v of vertex `i` of the part, given the table of one frame.
pub fn vertex_detail<T: Real>(params: Params, buffers: &Buffers<'_, T>, table: &[T], i: usize) -> [T; 3] {
    let (edges, k, n) = (params.strain_edges as usize, buffers.influences, params.centers as usize);
    let influence_edges = &buffers.influence_edges[i * k..][..k];
    let influence_weights = &buffers.influence_weights[i * k..][..k];
    let distance = |j: usize| {
        let mut sum = T::ZERO;
        for (&e, &alpha) in influence_edges.iter().zip(influence_weights) {
            sum = alpha.mul_add(table[table_index(edges, e as usize, j)], sum);
        }
        sum.sqrt()
    };
    let w = &buffers.rbf_weights[i * n..][..n];
    let pivot = buffers.pivots[i] as usize;
    let r_pivot = distance(pivot);
    let mut d = [T::ZERO; 3];
    for (j, w) in w.iter().enumerate() {
        let r = match j == pivot {
            true if params.zero_at_rest != 0 => T::round_from(1.0),
            true => r_pivot,
            false => distance(j) - r_pivot,
        };
        for c in 0..3 {
            d[c] = w[c].mul_add(r, d[c]);
        }
    }
    d
}

/// The reference.
pub fn detail<T: Real>(
    params: Params,
    squared_differences: &[T],
    buffers: &Buffers<'_, T>,
    local_detail: &mut [[T; 3]],
) {
    let vertices = params.vertices as usize;
    let len = table_len(params.strain_edges as usize, params.centers as usize);
    for frame in 0..params.frames as usize {
        let table = &squared_differences[frame * len..][..len];
        for i in 0..params.part_vertices as usize {
            let v = params.first_vertex as usize + i;
            local_detail[frame * vertices + v] = vertex_detail(params, buffers, table, i);
        }
    }
}
