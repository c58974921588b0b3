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
    /// H.
    pub handles: u32,
}

/// The twin.
pub fn large_scale<T: Real>(
    params: Params,
    rest: &[[T; 3]],
    basis: &[T],
    handle_rest: &[[T; 3]],
    handle_positions: &[[T; 3]],
    large_scale: &mut [[T; 3]],
) {
    let (vertices, handles) = (params.vertices as usize, params.handles as usize);
    for frame in 0..params.frames as usize {
        let p = &handle_positions[frame * handles..][..handles];
        for v in 0..vertices {
            let row = &basis[v * handles..][..handles];
            let mut sum = [T::zero(); 3];
            for h in 0..handles {
                let u = vec3::sub(p[h], handle_rest[h]);
                for c in 0..3 {
                    sum[c] += row[h] * u[c];
                }
            }
            large_scale[frame * vertices + v] = std::array::from_fn(|c| rest[v][c] + sum[c]);
        }
    }
}
