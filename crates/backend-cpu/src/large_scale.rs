//! The large scale: B times the handles' displacements.
use crate::lanes::{Lanes, load3, splat3, store3};
use crate::lines::{GROUP, Line3, PANEL, PanelRows};
use crate::prefetch::Prefetch;
use crate::vectors::Vectors;
use half::f16;
use half::slice::HalfFloatSliceExt;
use pulp::{Simd, WithSimd};
use rhytid_core::{BasisStorage, Rig};
use rhytid_kernels::{Number, vec3};

/// Registers of each coordinate whose sums are computed together. This many hide the latency of an addition.
const REGISTERS: usize = 4;

/// Vertices whose sums are computed together in a group of frames. A displacement is loaded once for all of
/// them.
const VERTICES: usize = 4;

/// B in panels, `[V/64][H][64]`. Numbers past V are zero. One pass over it streams through memory.
#[derive(Debug)]
pub(crate) struct Basis {
    handles: usize,
    rows: Rows,
}

/// A panel's rows of a handle as fp16.
type Fp16Rows = [f16; PANEL];

#[derive(Debug)]
enum Rows {
    F32(Vec<PanelRows>),
    F16(Vec<Fp16Rows>),
}

impl Basis {
    pub(crate) fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let (vertices, handles) = (rig.vertices(), rig.handles().len());
        let rows = match storage {
            BasisStorage::F32 => {
                let mut rows = vec![PanelRows::ZERO; vertices.div_ceil(PANEL) * handles];
                each_entry(rig.basis().as_slice(), handles, |at, lane, b| rows[at].0[lane] = b);
                Rows::F32(rows)
            }
            BasisStorage::F16 => {
                let mut rows = vec![[f16::ZERO; PANEL]; vertices.div_ceil(PANEL) * handles];
                each_entry(rig.basis().as_slice(), handles, |at, lane, b| rows[at][lane] = f16::from_f32(b));
                Rows::F16(rows)
            }
        };
        Self { handles, rows }
    }

    /// rest + B u of consecutive vertices from the first one of a panel, in one frame. `u` has H
    /// displacements.
    pub(crate) fn frame(
        &self,
        vectors: Vectors,
        first: usize,
        u: &[[f32; 3]],
        rest: &[[f32; 3]],
        out: &mut [[f32; 3]],
        scratch: &mut Vec<PanelRows>,
    ) {
        let panels = first / PANEL..(first + out.len()).div_ceil(PANEL);
        let range = panels.start * self.handles..panels.end * self.handles;
        match &self.rows {
            Rows::F32(rows) => vectors.run(Frame { rows: &rows[range], u, rest, out }),
            Rows::F16(rows) => fp16_frame(vectors, &rows[range], u, rest, out, scratch),
        }
    }

    /// rest + B u of a panel's vertices, in a group of frames. `u` has H displacements.
    pub(crate) fn group(
        &self,
        vectors: Vectors,
        panel: usize,
        u: &[Line3],
        rest: &[[f32; 3]],
        out: &mut [Line3],
        scratch: &mut Vec<PanelRows>,
    ) {
        let [own, next] = [panel, panel + 1].map(|panel| panel * self.handles..(panel + 1) * self.handles);
        let (rows, next) = match &self.rows {
            Rows::F32(rows) => {
                let own = &rows[own];
                (own, bytemuck::cast_slice(rows.get(next).unwrap_or(own)))
            }
            Rows::F16(rows) => {
                let own = &rows[own];
                (widened(own, scratch), bytemuck::cast_slice(rows.get(next).unwrap_or(own)))
            }
        };
        vectors.run(Group { rows, next, u, rest, out });
    }
}

/// Each entry of B, V×H, with its row among the panels' rows and its place in the row.
fn each_entry(basis: &[f32], handles: usize, mut put: impl FnMut(usize, usize, f32)) {
    for (v, entries) in basis.chunks_exact(handles).enumerate() {
        for (h, &b) in entries.iter().enumerate() {
            put(v / PANEL * handles + h, v % PANEL, b);
        }
    }
}

/// The rows as floats, in `scratch`.
fn widened<'a>(rows: &[Fp16Rows], scratch: &'a mut Vec<PanelRows>) -> &'a [PanelRows] {
    scratch.resize(rows.len(), PanelRows::ZERO);
    rows.as_flattened().convert_to_f32_slice(bytemuck::cast_slice_mut(scratch));
    scratch
}

/// AVX-512 widens fp16 while it loads registers. Otherwise fp16 is widened a panel at a time.
fn fp16_frame(
    vectors: Vectors,
    rows: &[Fp16Rows],
    u: &[[f32; 3]],
    rest: &[[f32; 3]],
    out: &mut [[f32; 3]],
    scratch: &mut Vec<PanelRows>,
) {
    #[cfg(target_arch = "x86_64")]
    if let (Vectors::Widest, Some(simd)) = (vectors, pulp::x86::V4::try_new()) {
        return simd.vectorize(
            #[inline(always)]
            || frame(simd, rows, u, rest, out),
        );
    }
    let panels = rows.chunks_exact(u.len()).zip(rest.chunks(PANEL).zip(out.chunks_mut(PANEL)));
    for (rows, (rest, out)) in panels {
        vectors.run(Frame { rows: widened(rows, scratch), u, rest, out });
    }
}

/// A panel's row of a handle, whose registers can be loaded with `S`.
trait Load<S: Simd> {
    fn load(&self, simd: S, register: usize) -> S::f32s;
}

impl<S: Simd> Load<S> for PanelRows {
    #[inline(always)]
    fn load(&self, _: S, register: usize) -> S::f32s {
        S::as_simd_f32s(&self.0).0[register]
    }
}

#[cfg(target_arch = "x86_64")]
impl Load<pulp::x86::V4> for Fp16Rows {
    #[inline(always)]
    fn load(&self, simd: pulp::x86::V4, register: usize) -> pulp::f32x16 {
        let (registers, _) = self.reinterpret_cast().as_chunks::<16>();
        pulp::cast(simd.avx512f._mm512_cvtph_ps(pulp::cast(registers[register])))
    }
}

/// Consecutive vertices in one frame.
struct Frame<'a> {
    rows: &'a [PanelRows],
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
    let panels = rows.chunks_exact(u.len()).zip(rest.chunks(PANEL).zip(out.chunks_mut(PANEL)));
    for (rows, (rest, out)) in panels {
        for first in (0..PANEL / S::F32_LANES).step_by(REGISTERS) {
            let mut sum = [[simd.splat_f32s(0.0); REGISTERS]; 3];
            for (rows, u) in rows.iter().zip(u) {
                let b: [S::f32s; REGISTERS] = std::array::from_fn(|i| rows.load(simd, first + i));
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

/// A panel in a group of frames.
struct Group<'a> {
    rows: &'a [PanelRows],
    /// The next panel's rows as they are stored. They are requested during the work on this panel. That work
    /// reads a few numbers of each handle at a time, in an order that the processor does not predict.
    next: &'a [u8],
    u: &'a [Line3],
    rest: &'a [[f32; 3]],
    out: &'a mut [Line3],
}

impl WithSimd for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let prefetch = Prefetch::new();
        // Requests are spread evenly over the handles and the vertices, since a request among many others has
        // to wait.
        let requests = self.u.len() * (PANEL / VERTICES);
        let bytes = self.next.len().checked_div(requests).unwrap_or(1);
        for (i, out) in self.out.chunks_mut(VERTICES).enumerate() {
            let next = self.next[i * self.u.len() * bytes..].chunks_exact(bytes);
            for register in 0..GROUP / S::F32_LANES {
                let mut sum = [[Lanes::splat(simd, 0.0); 3]; VERTICES];
                for ((rows, u), next) in self.rows.iter().zip(self.u).zip(next.clone()) {
                    prefetch.ask(next);
                    let u = load3(simd, u, register);
                    let (b, _) = rows.0.as_chunks::<VERTICES>();
                    for (sum, b) in sum.iter_mut().zip(&b[i]) {
                        let b = Lanes::splat(simd, *b);
                        for c in 0..3 {
                            sum[c] = b.mul_add(u[c], sum[c]);
                        }
                    }
                }
                for (lane, (out, sum)) in out.iter_mut().zip(sum).enumerate() {
                    let rest = splat3(simd, &self.rest[i * VERTICES + lane]);
                    store3(vec3::add(rest, sum), out, register);
                }
            }
        }
    }
}
