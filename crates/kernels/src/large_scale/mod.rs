#![doc = include_str!("README.md")]
use crate::params::parameter_block;
use crate::{Number, Real, vec3};

parameter_block!(
    /// Frames in the batch.
    frames,
    /// V.
    vertices,
    /// The first vertex of this part; 0 where the rig is in one piece.
    first_vertex,
    /// Vertices of this part.
    part_vertices,
    /// Vectors that a frame's rows of the basis are multiplied by: H, or R where the basis is in clusters.
    /// The reference has one cluster, and as many vectors as the basis has numbers of a vertex.
    motions,
    /// How `basis` is stored: 0 as fp32, 1 as fp16, 2 as integers of 16 bits. The reference has numbers of
    /// its own type and ignores this.
    basis_format,
    /// 1 where `band_offsets` are added, 0 where there are none.
    banded,
    /// 1 where the handles turn: `displacements` then has four vectors of each handle in a frame. 0 where it
    /// has one.
    rotating,
    /// Where the handles turn, the vertex whose rest position is subtracted from the others.
    center,
);

/// Vectors of each handle in a frame where the handles turn: a displacement, and the columns of R − I.
pub const MOTION: usize = 4;

impl Params {
    /// For a rig in one piece.
    pub fn whole(frames: usize, vertices: usize, handles: usize, banded: bool) -> Self {
        let (frames, vertices) = (frames as u32, vertices as u32);
        Self {
            frames,
            vertices,
            first_vertex: 0,
            part_vertices: vertices,
            motions: handles as u32,
            basis_format: 0,
            banded: u32::from(banded),
            rotating: 0,
            center: 0,
        }
    }

    /// The same where the handles turn, if they do; `center` is a vertex.
    pub fn turning(self, center: Option<u32>) -> Self {
        Self { rotating: u32::from(center.is_some()), center: center.unwrap_or(0), ..self }
    }

    /// Vectors of each handle in a frame.
    pub fn vectors(&self) -> usize {
        if self.rotating != 0 { MOTION } else { 1 }
    }
}

/// The reference. `basis` has the rows of the part alone; `displacements` is frames × H, or frames × 4 × H;
/// `band_offsets` is frames × V, or empty.
// The reference is inlined, so that callers can compile it for the processor's own instructions. Without
// these, a fused multiply-add is a function call.
#[inline(always)]
pub fn large_scale<T: Real>(
    params: Params,
    rest: &[[T; 3]],
    basis: &[T],
    displacements: &[[T; 3]],
    band_offsets: &[[T; 3]],
    large_scale_positions: &mut [[T; 3]],
) {
    let (vertices, handles) = (params.vertices as usize, params.motions as usize);
    for frame in 0..params.frames as usize {
        let of_frame = params.vectors() * handles;
        let of_frame = &displacements[frame * of_frame..][..of_frame];
        for i in 0..params.part_vertices as usize {
            let v = params.first_vertex as usize + i;
            let row = &basis[i * handles..][..handles];
            let blended = |vector: usize| {
                let mut sum = [T::ZERO; 3];
                for (b, u) in row.iter().zip(&of_frame[vector * handles..][..handles]) {
                    for c in 0..3 {
                        sum[c] = b.mul_add(u[c], sum[c]);
                    }
                }
                sum
            };
            let mut sum = blended(0);
            if params.rotating != 0 {
                let from_center = vec3::sub(rest[v], rest[params.center as usize]);
                sum = turned(sum, [1, 2, 3].map(blended), from_center);
            }
            let mut position = vec3::add(rest[v], sum);
            if params.banded != 0 {
                position = vec3::add(position, band_offsets[frame * vertices + v]);
            }
            large_scale_positions[frame * vertices + v] = position;
        }
    }
}

/// The displacement of a vertex where the surface turns. It comes from the displacement `at_center`, the
/// columns of R − I, and the vertex's position relative to the centre.
#[inline(always)]
pub fn turned<T: Number>(at_center: [T; 3], columns: [[T; 3]; 3], from_center: [T; 3]) -> [T; 3] {
    let mut sum = at_center;
    for (column, x) in columns.into_iter().zip(from_center) {
        for c in 0..3 {
            sum[c] = column[c].mul_add(x, sum[c]);
        }
    }
    sum
}
