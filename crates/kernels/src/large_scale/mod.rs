#![doc = include_str!("README.md")]
use crate::params::parameter_block;
use crate::{Real, vec3};

parameter_block!(
    /// Frames in the batch.
    frames,
    /// V.
    vertices,
    /// The first vertex of this part; 0 where the rig is in one piece.
    first_vertex,
    /// Vertices of this part.
    part_vertices,
    /// H.
    handles,
    /// 1 where `basis` is stored as fp16, 0 where it is not. The twin has its own type for it and does not look.
    fp16_basis,
    /// 1 where `band_offsets` are added, 0 where there are none.
    banded,
);

impl Params {
    /// For a rig in one piece.
    pub fn whole(frames: usize, vertices: usize, handles: usize, banded: bool) -> Self {
        let (frames, vertices) = (frames as u32, vertices as u32);
        Self {
            frames,
            vertices,
            first_vertex: 0,
            part_vertices: vertices,
            handles: handles as u32,
            fp16_basis: 0,
            banded: u32::from(banded),
        }
    }
}

/// The twin. `basis` has the rows of the part alone; `band_offsets` is frames × V, or empty.
// Where the processor's own instructions are chosen, the twin is to be compiled for them: without, a fused multiply-add is a call.
#[inline(always)]
pub fn large_scale<T: Real>(
    params: Params,
    rest: &[[T; 3]],
    basis: &[T],
    handle_rest: &[[T; 3]],
    handle_positions: &[[T; 3]],
    band_offsets: &[[T; 3]],
    large_scale_positions: &mut [[T; 3]],
) {
    let (vertices, handles) = (params.vertices as usize, params.handles as usize);
    for frame in 0..params.frames as usize {
        let p = &handle_positions[frame * handles..][..handles];
        for i in 0..params.part_vertices as usize {
            let v = params.first_vertex as usize + i;
            let row = &basis[i * handles..][..handles];
            let mut sum = [T::ZERO; 3];
            for h in 0..handles {
                let u = vec3::sub(p[h], handle_rest[h]);
                for c in 0..3 {
                    sum[c] = row[h].mul_add(u[c], sum[c]);
                }
            }
            let mut position = vec3::add(rest[v], sum);
            if params.banded != 0 {
                position = vec3::add(position, band_offsets[frame * vertices + v]);
            }
            large_scale_positions[frame * vertices + v] = position;
        }
    }
}
