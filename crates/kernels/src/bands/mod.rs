#![doc = include_str!("README.md")]
use crate::Real;
use crate::differences::{table_index, table_len};
use crate::params::parameter_block;

mod narrow;

pub use narrow::{bits_of_weight, weight_of_bits};

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
    /// N, the rest pose included.
    centers,
    /// 1 where `influence_weights` has numbers of 16 bits, 0 where it has fp32. The reference has numbers of
    /// its own type and ignores this.
    narrow,
    /// 1 where the wrinkles are functions of vector strains too, 0 where they are not.
    wrinkles,
);

impl Params {
    /// For a rig in one piece, of V vertices, F + H features and N centres.
    pub fn whole(frames: usize, vertices: usize, features: usize, centers: usize, wrinkles: bool) -> Self {
        let [frames, vertices, features, centers] = [frames, vertices, features, centers].map(|n| n as u32);
        Self {
            frames,
            vertices,
            first_vertex: 0,
            part_vertices: vertices,
            features,
            centers,
            narrow: 0,
            wrinkles: u32::from(wrinkles),
        }
    }

    /// The vectors of `band_weights` that each vertex has for each centre.
    pub fn kinds(&self) -> usize {
        kinds(self.wrinkles != 0)
    }
}

/// The vectors of `band_weights` that each vertex has for each centre: one of the linear band, and one of the
/// wrinkles where they are functions of vector strains.
pub fn kinds(wrinkles: bool) -> usize {
    if wrinkles { 2 } else { 1 }
}

/// The share of strain edges in the weights of a vertex's influences. Anchors have the rest.
pub const EDGES_SHARE: f64 = 0.9;

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
    /// A.
    pub anchors_per_vertex: usize,
    /// V×A indices of handles.
    pub anchors: &'a [u32],
    /// ν, V×A.
    pub anchor_weights: &'a [T],
    /// V×N×[`Params::kinds`]: a and b, then c / 2 and w of each example. Without wrinkles, a and c / 2.
    pub band_weights: &'a [[T; 3]],
}

/// o and d of vertex `i` of the part, given the table of one frame; `strain_edges` is F. Without wrinkles, d
/// is zero.
pub fn vertex_bands<T: Real>(
    params: Params,
    buffers: &Buffers<'_, T>,
    strain_edges: usize,
    table: &[T],
    i: usize,
) -> [[T; 3]; 2] {
    let (k, a, centers) = (buffers.influences, buffers.anchors_per_vertex, params.centers as usize);
    let (edges, alphas) = (&buffers.influence_edges[i * k..][..k], &buffers.influence_weights[i * k..][..k]);
    let (anchors, nus) = (&buffers.anchors[i * a..][..a], &buffers.anchor_weights[i * a..][..a]);
    let distance = |j: usize| {
        let at = |feature: usize| table[table_index(params.features as usize, feature, j)];
        let mut sum = T::ZERO;
        for (&e, &alpha) in edges.iter().zip(alphas) {
            sum = alpha.mul_add(at(e as usize), sum);
        }
        sum = T::round_from(EDGES_SHARE) * sum;
        for (&h, &nu) in anchors.iter().zip(nus) {
            sum = nu.mul_add(at(strain_edges + h as usize), sum);
        }
        sum
    };
    let weights = &buffers.band_weights[i * params.kinds() * centers..];
    let (mut offset, mut detail) = (weights[0], [T::ZERO; 3]);
    if params.wrinkles != 0 {
        detail = weights[1];
    }
    let rest = distance(0);
    for (j, weights) in weights.chunks_exact(params.kinds()).enumerate().take(centers).skip(1) {
        let squared = distance(j);
        let (along, c) = (rest - squared, weights[0]);
        for axis in 0..3 {
            offset[axis] = c[axis].mul_add(along, offset[axis]);
        }
        if let Some(w) = weights.get(1) {
            let farther = squared.sqrt() - rest.sqrt();
            for axis in 0..3 {
                detail[axis] = w[axis].mul_add(farther, detail[axis]);
            }
        }
    }
    [offset, detail]
}

/// The reference; `strain_edges` is F. `local_detail` is not written without wrinkles.
pub fn bands<T: Real>(
    params: Params,
    (squared_vector_differences, strain_edges): (&[T], u32),
    buffers: &Buffers<'_, T>,
    band_offsets: &mut [[T; 3]],
    local_detail: &mut [[T; 3]],
) {
    let vertices = params.vertices as usize;
    let len = table_len(params.features as usize, params.centers as usize);
    for frame in 0..params.frames as usize {
        let table = &squared_vector_differences[frame * len..][..len];
        for i in 0..params.part_vertices as usize {
            let v = frame * vertices + params.first_vertex as usize + i;
            let [offset, detail] = vertex_bands(params, buffers, strain_edges as usize, table, i);
            band_offsets[v] = offset;
            if params.wrinkles != 0 {
                local_detail[v] = detail;
            }
        }
    }
}
