#![doc = include_str!("README.md")]
use crate::Real;
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
);

/// The data of a rig that the reference reads: only the vertices of the part.
#[derive(Debug, Clone, Copy)]
pub struct Buffers<'a, T> {
    /// Influences of each vertex.
    pub influences: usize,
    /// V × influences indices of features.
    pub features: &'a [u32],
    /// g, V × influences.
    pub gains: &'a [T],
}

/// The reference. `vector_excess` is frames × (F + H).
pub fn beyond<T: Real>(
    params: Params,
    vector_excess: &[[T; 3]],
    buffers: &Buffers<'_, T>,
    band_offsets: &mut [[T; 3]],
) {
    let (vertices, n) = (params.vertices as usize, buffers.influences);
    for (frame, excess) in vector_excess.chunks_exact(params.features as usize).enumerate() {
        for i in 0..params.part_vertices as usize {
            let mut sum = [T::ZERO; 3];
            let influences = buffers.features[i * n..].iter().zip(&buffers.gains[i * n..]).take(n);
            for (&e, &gain) in influences {
                for (sum, d) in sum.iter_mut().zip(excess[e as usize]) {
                    *sum = gain.mul_add(d, *sum);
                }
            }
            let offset = &mut band_offsets[frame * vertices + params.first_vertex as usize + i];
            *offset = crate::vec3::sub(*offset, sum);
        }
    }
}
