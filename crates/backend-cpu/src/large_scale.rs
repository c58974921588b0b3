//! The large scale: B times the handles' displacements.
use crate::lanes::{Lanes, load3, splat3, store3};
use crate::prefetch::Prefetch;
use crate::rows::{GROUP, RowVectors, TILE, TileRow};
use crate::vectors::Vectors;
use half::f16;
use half::slice::HalfFloatSliceExt;
use pulp::{Simd, WithSimd};
use rhytid_core::{BasisStorage, Rig};
use rhytid_kernels::{Number, vec3};

/// Registers of each coordinate whose sums are computed at once: as many as hide how long an addition takes.
const REGISTERS: usize = 4;

/// Vertices whose sums are computed at once in a group of frames, so that a displacement that is loaded serves all of them.
const VERTICES: usize = 4;

/// B in tiles, `[V/64][H][64]`, rows past V being zero: one pass over it streams through memory.
#[derive(Debug)]
pub struct Basis {
    handles: usize,
    rows: Rows,
}

/// A tile's row in halves.
type HalfRow = [f16; TILE];

#[derive(Debug)]
enum Rows {
    F32(Vec<TileRow>),
    F16(Vec<HalfRow>),
}

impl Basis {
    pub fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let (vertices, handles) = (rig.vertices(), rig.handles.len());
        let rows = match storage {
            BasisStorage::F32 => {
                let mut rows = vec![TileRow::ZERO; vertices.div_ceil(TILE) * handles];
                each_entry(&rig.basis, handles, |row, lane, b| rows[row].0[lane] = b);
                Rows::F32(rows)
            }
            BasisStorage::F16 => {
                let mut rows = vec![[f16::ZERO; TILE]; vertices.div_ceil(TILE) * handles];
                each_entry(&rig.basis, handles, |row, lane, b| rows[row][lane] = f16::from_f32(b));
                Rows::F16(rows)
            }
        };
        Self { handles, rows }
    }

    /// rest + B u of consecutive vertices from the first one of a tile, in one frame. `u` has H displacements.
    pub fn frame(
        &self,
        vectors: Vectors,
        first: usize,
        u: &[[f32; 3]],
        rest: &[[f32; 3]],
        out: &mut [[f32; 3]],
        room: &mut Vec<TileRow>,
    ) {
        let tiles = first / TILE..(first + out.len()).div_ceil(TILE);
        let range = tiles.start * self.handles..tiles.end * self.handles;
        match &self.rows {
            Rows::F32(rows) => vectors.run(Frame { rows: &rows[range], u, rest, out }),
            Rows::F16(rows) => half_frame(vectors, &rows[range], u, rest, out, room),
        }
    }

    /// rest + B u of a tile's vertices, in a group of frames. `u` has H displacements.
    pub fn group(
        &self,
        vectors: Vectors,
        tile: usize,
        u: &[RowVectors],
        rest: &[[f32; 3]],
        out: &mut [RowVectors],
        room: &mut Vec<TileRow>,
    ) {
        let [own, next] = [tile, tile + 1].map(|tile| tile * self.handles..(tile + 1) * self.handles);
        let (rows, next) = match &self.rows {
            Rows::F32(rows) => {
                let own = &rows[own];
                (own, bytemuck::cast_slice(rows.get(next).unwrap_or(own)))
            }
            Rows::F16(rows) => {
                let own = &rows[own];
                (widened(own, room), bytemuck::cast_slice(rows.get(next).unwrap_or(own)))
            }
        };
        vectors.run(Group { rows, next, u, rest, out });
    }
}

/// Each entry of B, V×H, with its row and lane in tiles.
fn each_entry(basis: &[f32], handles: usize, mut put: impl FnMut(usize, usize, f32)) {
    for (v, entries) in basis.chunks_exact(handles).enumerate() {
        for (h, &b) in entries.iter().enumerate() {
            put(v / TILE * handles + h, v % TILE, b);
        }
    }
}

/// The rows as floats, in `room`.
fn widened<'a>(rows: &[HalfRow], room: &'a mut Vec<TileRow>) -> &'a [TileRow] {
    room.resize(rows.len(), TileRow::ZERO);
    rows.as_flattened().convert_to_f32_slice(bytemuck::cast_slice_mut(room));
    room
}

/// AVX-512 widens halves on their way into registers; otherwise they are widened a tile at a time.
fn half_frame(
    vectors: Vectors,
    rows: &[HalfRow],
    u: &[[f32; 3]],
    rest: &[[f32; 3]],
    out: &mut [[f32; 3]],
    room: &mut Vec<TileRow>,
) {
    #[cfg(target_arch = "x86_64")]
    if let (Vectors::Widest, Some(simd)) = (vectors, pulp::x86::V4::try_new()) {
        return simd.vectorize(
            #[inline(always)]
            || frame(simd, rows, u, rest, out),
        );
    }
    let tiles = rows.chunks_exact(u.len()).zip(rest.chunks(TILE).zip(out.chunks_mut(TILE)));
    for (rows, (rest, out)) in tiles {
        vectors.run(Frame { rows: widened(rows, room), u, rest, out });
    }
}

/// A row of B whose registers can be loaded with `S`.
trait Load<S: Simd> {
    fn load(&self, simd: S, part: usize) -> S::f32s;
}

impl<S: Simd> Load<S> for TileRow {
    #[inline(always)]
    fn load(&self, _: S, part: usize) -> S::f32s {
        S::as_simd_f32s(&self.0).0[part]
    }
}

#[cfg(target_arch = "x86_64")]
impl Load<pulp::x86::V4> for HalfRow {
    #[inline(always)]
    fn load(&self, simd: pulp::x86::V4, part: usize) -> pulp::f32x16 {
        let (registers, _) = self.reinterpret_cast().as_chunks::<16>();
        pulp::cast(simd.avx512f._mm512_cvtph_ps(pulp::cast(registers[part])))
    }
}

/// Consecutive vertices in one frame.
struct Frame<'a> {
    rows: &'a [TileRow],
    u: &'a [[f32; 3]],
    rest: &'a [[f32; 3]],
    out: &'a mut [[f32; 3]],
}

impl WithSimd for Frame<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        frame(simd, self.rows, self.u, self.rest, self.out);
    }
}

#[inline(always)]
fn frame<S: Simd, R: Load<S>>(simd: S, rows: &[R], u: &[[f32; 3]], rest: &[[f32; 3]], out: &mut [[f32; 3]]) {
    let tiles = rows.chunks_exact(u.len()).zip(rest.chunks(TILE).zip(out.chunks_mut(TILE)));
    for (rows, (rest, out)) in tiles {
        for first in (0..TILE / S::F32_LANES).step_by(REGISTERS) {
            let mut sum = [[simd.splat_f32s(0.0); REGISTERS]; 3];
            for (row, u) in rows.iter().zip(u) {
                let b: [S::f32s; REGISTERS] = std::array::from_fn(|i| row.load(simd, first + i));
                for (sum, u) in sum.iter_mut().zip(u) {
                    let u = simd.splat_f32s(*u);
                    for (sum, b) in sum.iter_mut().zip(b) {
                        *sum = simd.mul_add_f32s(b, u, *sum);
                    }
                }
            }
            let [x, y, z] = sum.each_ref().map(|sum| bytemuck::cast_slice::<_, f32>(sum));
            let first = (first * S::F32_LANES).min(out.len());
            let all = out[first..].iter_mut().zip(&rest[first..]).zip(x.iter().zip(y).zip(z));
            for ((out, rest), ((x, y), z)) in all {
                *out = [rest[0] + x, rest[1] + y, rest[2] + z];
            }
        }
    }
}

/// A tile in a group of frames.
struct Group<'a> {
    rows: &'a [TileRow],
    /// The next tile's rows as they are stored. They are asked for during the work on this one, which takes of each row a few numbers at
    /// a time: not an order that the processor foresees.
    next: &'a [u8],
    u: &'a [RowVectors],
    rest: &'a [[f32; 3]],
    out: &'a mut [RowVectors],
}

impl WithSimd for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let prefetch = Prefetch::new();
        // As much for each handle and each few vertices: a request that comes with many others has to wait.
        let requests = self.u.len() * (TILE / VERTICES);
        let bytes = self.next.len().checked_div(requests).unwrap_or(1);
        for (i, out) in self.out.chunks_mut(VERTICES).enumerate() {
            let next = self.next[i * self.u.len() * bytes..].chunks_exact(bytes);
            for part in 0..GROUP / S::F32_LANES {
                let mut sum = [[Lanes::splat(simd, 0.0); 3]; VERTICES];
                for ((row, u), next) in self.rows.iter().zip(self.u).zip(next.clone()) {
                    prefetch.ask(next);
                    let u = load3(simd, u, part);
                    let (b, _) = row.0.as_chunks::<VERTICES>();
                    for (sum, b) in sum.iter_mut().zip(&b[i]) {
                        let b = Lanes::splat(simd, *b);
                        for c in 0..3 {
                            sum[c] = b.times_plus(u[c], sum[c]);
                        }
                    }
                }
                for (lane, (out, sum)) in out.iter_mut().zip(sum).enumerate() {
                    let rest = splat3(simd, &self.rest[i * VERTICES + lane]);
                    store3(vec3::add(rest, sum), out, part);
                }
            }
        }
    }
}
