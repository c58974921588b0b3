#![doc = include_str!("README.md")]
use crate::Real;
use crate::params::parameter_block;

parameter_block!(
    /// Frames in the batch. Where the handles turn, four times as many.
    frames,
    /// H.
    handles,
    /// R.
    cluster_rows,
);

/// The reference. `cluster_basis` is H × R, `displacements` is frames × H, and `cluster_motions` is
/// frames × R.
#[inline(always)]
pub fn clusters<T: Real>(
    params: Params,
    cluster_basis: &[T],
    displacements: &[[T; 3]],
    cluster_motions: &mut [[T; 3]],
) {
    let (handles, rows) = (params.handles as usize, params.cluster_rows as usize);
    let frames =
        displacements.chunks_exact(handles.max(1)).zip(cluster_motions.chunks_exact_mut(rows.max(1)));
    for (u, motions) in frames.take(params.frames as usize) {
        for (k, motion) in motions.iter_mut().enumerate() {
            let mut sum = [T::ZERO; 3];
            for (h, u) in u.iter().enumerate() {
                for c in 0..3 {
                    sum[c] = cluster_basis[h * rows + k].mul_add(u[c], sum[c]);
                }
            }
            *motion = sum;
        }
    }
}
