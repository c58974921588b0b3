#![doc = include_str!("README.md")]
use crate::Real;
use crate::params::parameter_block;

/// Centres whose numbers lie side by side in the table.
pub const CENTERS_AT_ONCE: usize = 8;

parameter_block!(
    /// Frames in the batch.
    frames,
    /// F.
    strain_edges,
    /// N, the rest pose included.
    centers,
);

/// The table's numbers for one frame.
pub fn table_len(edges: usize, centers: usize) -> usize {
    centers.div_ceil(CENTERS_AT_ONCE) * edges * CENTERS_AT_ONCE
}

/// Where a frame's table has the number of edge `e` and centre `j`.
pub fn table_index(edges: usize, e: usize, j: usize) -> usize {
    (j / CENTERS_AT_ONCE * edges + e) * CENTERS_AT_ONCE + j % CENTERS_AT_ONCE
}

/// The reference.
pub fn differences<T: Real>(
    params: Params,
    features: &[T],
    pose_features: &[T],
    squared_differences: &mut [T],
) {
    let (edges, centers) = (params.strain_edges as usize, params.centers as usize);
    let len = table_len(edges, centers);
    for frame in 0..params.frames as usize {
        let table = &mut squared_differences[frame * len..][..len];
        for e in 0..edges {
            for j in 0..centers.next_multiple_of(CENTERS_AT_ONCE) {
                table[table_index(edges, e, j)] = if j < centers {
                    let difference = features[frame * edges + e] - pose_features[j * edges + e];
                    difference * difference
                } else {
                    T::ZERO
                };
            }
        }
    }
}
