//! The large scale: B times the handles' displacements.
use crate::blocks::{BLOCK, blocks};
use half::f16;
use half::slice::HalfFloatSliceExt;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::{BasisStorage, Rig};
use rhytid_kernels::table::TILE;

/// Vectors of each coordinate whose sums are in registers at once: as many as hide how long an addition takes.
const VECTORS: usize = 4;

/// B in tiles, `[V/64][H][64]`, rows past V being zero: one pass over it streams through memory, and the inner loop of
/// the large scale is a whole number of SIMD registers.
#[derive(Debug)]
pub enum BasisTiles {
    F32(Vec<[f32; TILE]>),
    F16(Vec<[f16; TILE]>),
}

impl BasisTiles {
    pub fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let (vertices, handles) = (rig.vertices(), rig.handles.len());
        match storage {
            BasisStorage::F32 => Self::F32(tiles(&rig.basis, vertices, handles, |b| b)),
            BasisStorage::F16 => Self::F16(tiles(&rig.basis, vertices, handles, f16::from_f32)),
        }
    }

    /// rest + B u of all vertices in all frames; `displacements` is frames × H.
    pub fn apply(&self, rest: &[[f32; 3]], displacements: &[[f32; 3]], handles: usize, out: &mut [[f32; 3]]) {
        let work = blocks(out, rest.len()).into_par_iter().zip(rest.par_chunks(BLOCK)).enumerate();
        work.for_each_init(Vec::new, |widened, (block, (frames, rest))| {
            let mut frames: Vec<_> = frames.into_iter().map(|frame| frame.chunks_mut(TILE)).collect();
            for (i, rest) in rest.chunks(TILE).enumerate() {
                let basis = self.tile(block * (BLOCK / TILE) + i, handles, widened);
                for (frame, u) in frames.iter_mut().zip(displacements.chunks_exact(handles)) {
                    if let Some(out) = frame.next() {
                        Arch::new().dispatch(Tile { basis, u, rest, out });
                    }
                }
            }
        });
    }

    /// The H rows of one tile; `widened` is room for them where they are stored in halves.
    fn tile<'a>(
        &'a self,
        tile: usize,
        handles: usize,
        widened: &'a mut Vec<[f32; TILE]>,
    ) -> &'a [[f32; TILE]] {
        match self {
            Self::F32(rows) => &rows[tile * handles..][..handles],
            Self::F16(rows) => {
                widened.resize(handles, [0.0; TILE]);
                let halves = rows[tile * handles..][..handles].as_flattened();
                halves.convert_to_f32_slice(widened.as_flattened_mut());
                widened
            }
        }
    }
}

/// One tile of one frame.
struct Tile<'a> {
    basis: &'a [[f32; TILE]],
    u: &'a [[f32; 3]],
    rest: &'a [[f32; 3]],
    out: &'a mut [[f32; 3]],
}

impl WithSimd for Tile<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for part in (0..TILE / S::F32_LANES).step_by(VECTORS) {
            let mut sum = [[simd.splat_f32s(0.0); VECTORS]; 3];
            for (row, u) in self.basis.iter().zip(self.u) {
                let row = &S::as_simd_f32s(row).0[part..part + VECTORS];
                for (sum, u) in sum.iter_mut().zip(u) {
                    let u = simd.splat_f32s(*u);
                    for (sum, b) in sum.iter_mut().zip(row) {
                        *sum = simd.add_f32s(*sum, simd.mul_f32s(*b, u));
                    }
                }
            }
            let [x, y, z] = sum.each_ref().map(|sum| bytemuck::cast_slice::<_, f32>(sum));
            let first = (part * S::F32_LANES).min(self.out.len());
            let all = self.out[first..].iter_mut().zip(&self.rest[first..]).zip(x.iter().zip(y).zip(z));
            for ((out, rest), ((x, y), z)) in all {
                *out = [rest[0] + x, rest[1] + y, rest[2] + z];
            }
        }
    }
}

/// B from V×H to `[V/64][H][64]`.
fn tiles<T: Copy + Default>(
    basis: &[f32],
    vertices: usize,
    handles: usize,
    round: impl Fn(f32) -> T,
) -> Vec<[T; TILE]> {
    let mut tiles = vec![[T::default(); TILE]; vertices.div_ceil(TILE) * handles];
    for (v, row) in basis.chunks_exact(handles).enumerate() {
        for (h, &b) in row.iter().enumerate() {
            tiles[v / TILE * handles + h][v % TILE] = round(b);
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(count: usize, seed: f32) -> Vec<f32> {
        (0..count).map(|i| (i as f32 * 12.9898 + seed).sin() * 3.0).collect()
    }

    /// The last tile of a rig is seldom full.
    #[test]
    fn every_kind_of_vector_has_the_bits_of_a_plain_loop() {
        let (handles, vertices) = (89, 61);
        let basis = numbers(handles * TILE, 0.1);
        let (u, rest) = (numbers(3 * handles, 0.2), numbers(3 * vertices, 0.3));
        let (basis, u, rest) = (basis.as_chunks::<TILE>().0, u.as_chunks::<3>().0, rest.as_chunks::<3>().0);
        let mut expected = rest.to_vec();
        for (lane, x) in expected.iter_mut().enumerate() {
            for c in 0..3 {
                let mut sum = 0.0;
                for h in 0..handles {
                    sum += basis[h][lane] * u[h][c];
                }
                x[c] = rest[lane][c] + sum;
            }
        }
        let check = |run: &dyn Fn(Tile<'_>)| {
            let mut out = vec![[0.0; 3]; vertices];
            run(Tile { basis, u, rest, out: &mut out });
            assert!(out == expected);
        };
        check(&|tile| Simd::vectorize(pulp::Scalar, tile));
        check(&|tile| Arch::new().dispatch(tile));
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = pulp::x86::V3::try_new() {
            check(&|tile| Simd::vectorize(avx2, tile));
        }
    }
}
