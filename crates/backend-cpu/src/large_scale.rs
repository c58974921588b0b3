//! The large scale: B times the handles' displacements. Where B is in clusters, `B ≈ U W`: first W times the
//! displacements, then U times that.
use crate::lanes::{Lanes, load3, splat3, store3};
use crate::lines::{GROUP, Line, Line3, PANEL, PanelRows};
use crate::prefetch::Prefetch;
use crate::vectors::Vectors;
use half::f16;
use half::slice::HalfFloatSliceExt;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::{BasisStorage, ClusteredBasis, Rig};
use rhytid_kernels::{Number, vec3};
use std::borrow::Cow;
use std::ops::Range;

/// Registers of each coordinate whose sums are computed together. This many hide the latency of an addition.
const REGISTERS: usize = 4;

/// Vertices whose sums are computed together in a group of frames. A displacement is loaded once for all of
/// them.
const VERTICES: usize = 4;

/// Panels of a cluster.
const PANELS: usize = ClusteredBasis::VERTICES / PANEL;

/// B in panels, `[V/64][H][64]`. Where it is in clusters, U in panels, each with as many rows as its cluster
/// has. Numbers past V are zero. One pass over it streams through memory.
#[derive(Debug)]
pub(crate) struct Basis {
    rows: Rows,
    /// H.
    handles: usize,
    clusters: Option<Clusters>,
}

/// What is computed once for each cluster.
#[derive(Debug)]
struct Clusters {
    /// W of all clusters, R×H, in panels of 64 of its rows.
    handle_factors: Box<Basis>,
    /// R.
    rows: usize,
    /// The first of the panels' rows of each cluster's first panel, and the first of its rows of W.
    firsts: Vec<[usize; 2]>,
}

/// Panels that have equally many rows, one behind the other.
struct Panels {
    /// Their rows among all rows of the panels.
    rows: Range<usize>,
    /// The vectors of a frame that their rows are multiplied by.
    vectors: Range<usize>,
}

/// A row of a panel as fp16.
type Fp16Rows = [f16; PANEL];

/// A row of a panel as integers.
type IntegerRows = [i16; PANEL];

#[derive(Debug)]
enum Rows {
    F32(Vec<PanelRows>),
    F16(Vec<Fp16Rows>),
    I16(Vec<IntegerRows>),
}

impl Basis {
    pub(crate) fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let (basis, handles) = (rig.basis().as_slice(), rig.handles().len());
        match storage {
            BasisStorage::F32 => Self::dense(basis, handles),
            BasisStorage::F16 => {
                let mut rows = vec![[f16::ZERO; PANEL]; rig.vertices().div_ceil(PANEL) * handles];
                each_entry(basis, handles, |at, lane, b| rows[at][lane] = f16::from_f32(b));
                Self { rows: Rows::F16(rows), handles, clusters: None }
            }
            BasisStorage::Clustered => Self::clustered(rig),
        }
    }

    /// Numbers of vertices or of rows, H of each.
    fn dense(numbers: &[f32], handles: usize) -> Self {
        let mut rows = vec![PanelRows::ZERO; (numbers.len() / handles).div_ceil(PANEL) * handles];
        each_entry(numbers, handles, |at, lane, b| rows[at].0[lane] = b);
        Self { rows: Rows::F32(rows), handles, clusters: None }
    }

    fn clustered(rig: &Rig) -> Self {
        let (basis, handles) = (ClusteredBasis::new(rig), rig.handles().len());
        let mut rows: Vec<IntegerRows> = Vec::new();
        let mut firsts = Vec::new();
        for (i, cluster) in basis.clusters().iter().enumerate() {
            firsts.push([rows.len(), basis.rows_of(i).start]);
            let vertices = cluster.columns.first().map_or(0, Vec::len);
            for first in (0..vertices).step_by(PANEL) {
                let row = |column: &Vec<i16>| -> IntegerRows {
                    std::array::from_fn(|lane| column.get(first + lane).copied().unwrap_or(0))
                };
                rows.extend(cluster.columns.iter().map(row));
            }
        }
        firsts.push([rows.len(), basis.rows()]);
        let handle_factors = Box::new(Self::dense(basis.handle_factors().as_slice(), handles));
        let clusters = Some(Clusters { handle_factors, rows: basis.rows(), firsts });
        Self { rows: Rows::I16(rows), handles, clusters }
    }

    /// How many vectors of a frame the vertices need for each vector of all handles.
    pub(crate) fn width(&self) -> usize {
        self.clusters.as_ref().map_or(self.handles, |clusters| clusters.rows)
    }

    /// The vectors that [`Basis::frame`] needs: W times vectors of the handles. `u` has H vectors, or several
    /// times H.
    pub(crate) fn motions<'a>(&self, vectors: Vectors, u: &'a [[f32; 3]]) -> Cow<'a, [[f32; 3]]> {
        let Some(clusters) = &self.clusters else { return Cow::Borrowed(u) };
        let mut motions = vec![[0.0; 3]; u.len() / self.handles * clusters.rows];
        for (u, motions) in u.chunks_exact(self.handles).zip(motions.chunks_exact_mut(clusters.rows)) {
            motions.par_chunks_mut(PANEL).enumerate().for_each(|(i, out)| {
                let nowhere = [[0.0; 3]; PANEL];
                let rest = &nowhere[..out.len()];
                clusters.handle_factors.frame(vectors, i * PANEL, u, rest, out, &mut Vec::new());
            });
        }
        Cow::Owned(motions)
    }

    /// The same for a group of frames.
    pub(crate) fn group_motions<'a>(&self, vectors: Vectors, u: &'a [Line3]) -> Cow<'a, [Line3]> {
        let Some(clusters) = &self.clusters else { return Cow::Borrowed(u) };
        let mut motions = vec![[Line::ZERO; 3]; u.len() / self.handles * clusters.rows];
        for (u, motions) in u.chunks_exact(self.handles).zip(motions.chunks_exact_mut(clusters.rows)) {
            motions.par_chunks_mut(PANEL).enumerate().for_each(|(i, out)| {
                let nowhere = [[0.0; 3]; PANEL];
                let rest = &nowhere[..out.len()];
                clusters.handle_factors.group(vectors, i, u, rest, out, &mut Vec::new());
            });
        }
        Cow::Owned(motions)
    }

    /// The panels of one cluster among some panels: the first ones of `panels`.
    fn of_one_cluster(&self, panels: &Range<usize>) -> (Range<usize>, Panels) {
        let Some(clusters) = &self.clusters else {
            let rows = panels.start * self.handles..panels.end * self.handles;
            return (panels.clone(), Panels { rows, vectors: 0..self.handles });
        };
        let cluster = panels.start / PANELS;
        let own = panels.start..panels.end.min((cluster + 1) * PANELS);
        let ([first, first_vector], [_, end_vector]) =
            (clusters.firsts[cluster], clusters.firsts[cluster + 1]);
        let vectors = first_vector..end_vector;
        let [begin, end] = [own.start, own.end].map(|p| first + (p - cluster * PANELS) * vectors.len());
        (own, Panels { rows: begin..end, vectors })
    }

    /// rest + B u of consecutive vertices from the first one of a panel, in one frame. `motions` has
    /// [`Basis::width`] vectors, those of [`Basis::motions`].
    pub(crate) fn frame(
        &self,
        vectors: Vectors,
        first: usize,
        motions: &[[f32; 3]],
        mut rest: &[[f32; 3]],
        mut out: &mut [[f32; 3]],
        scratch: &mut Vec<PanelRows>,
    ) {
        let mut panels = first / PANEL..(first + out.len()).div_ceil(PANEL);
        while !panels.is_empty() {
            let (own, Panels { rows: range, vectors: of_cluster }) = self.of_one_cluster(&panels);
            let vertices = (own.len() * PANEL).min(out.len());
            let (own_out, others) = out.split_at_mut(vertices);
            let (own_rest, other_rests) = rest.split_at(vertices);
            let u = &motions[of_cluster];
            match &self.rows {
                Rows::F32(rows) => vectors.run(Frame { rows: &rows[range], u, rest: own_rest, out: own_out }),
                Rows::F16(rows) => {
                    Frame { rows: &rows[range], u, rest: own_rest, out: own_out }.widened(vectors, scratch);
                }
                Rows::I16(rows) => {
                    Frame { rows: &rows[range], u, rest: own_rest, out: own_out }.widened(vectors, scratch);
                }
            }
            (panels.start, out, rest) = (own.end, others, other_rests);
        }
    }

    /// rest + B u of a panel's vertices, in a group of frames. `motions` has [`Basis::width`] vectors, those
    /// of [`Basis::group_motions`].
    pub(crate) fn group(
        &self,
        vectors: Vectors,
        panel: usize,
        motions: &[Line3],
        rest: &[[f32; 3]],
        out: &mut [Line3],
        scratch: &mut Vec<PanelRows>,
    ) {
        let (_, Panels { rows: own, vectors: of_cluster }) = self.of_one_cluster(&(panel..panel + 1));
        // The next panel may have more rows, or fewer. Its first ones are requested.
        let next = own.end..own.end + own.len();
        let (rows, next) = match &self.rows {
            Rows::F32(rows) => {
                let own = &rows[own];
                (own, bytemuck::cast_slice(rows.get(next).unwrap_or(own)))
            }
            Rows::F16(rows) => {
                let own = &rows[own];
                (widened(own, scratch), bytemuck::cast_slice(rows.get(next).unwrap_or(own)))
            }
            Rows::I16(rows) => {
                let own = &rows[own];
                (widened(own, scratch), bytemuck::cast_slice(rows.get(next).unwrap_or(own)))
            }
        };
        vectors.run(Group { rows, next, u: &motions[of_cluster], rest, out });
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

/// A row of a panel with numbers of 16 bits.
trait Narrow: Sized {
    /// Writes the rows as floats.
    fn widen(rows: &[Self], out: &mut [PanelRows]);

    /// Computes consecutive vertices in one frame with registers that are widened while they are loaded.
    /// `false` if the processor cannot.
    fn widened_while_loading(vectors: Vectors, frame: Frame<'_, Self>) -> bool;
}

impl Narrow for Fp16Rows {
    fn widen(rows: &[Self], out: &mut [PanelRows]) {
        rows.as_flattened().convert_to_f32_slice(bytemuck::cast_slice_mut(out));
    }

    #[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables))]
    fn widened_while_loading(vectors: Vectors, frame: Frame<'_, Self>) -> bool {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = vectors.avx512() {
            frame.with_avx512(simd);
            return true;
        }
        false
    }
}

impl Narrow for IntegerRows {
    fn widen(rows: &[Self], out: &mut [PanelRows]) {
        for (out, row) in out.iter_mut().zip(rows) {
            out.0.iter_mut().zip(row).for_each(|(out, &c)| *out = f32::from(c));
        }
    }

    #[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables))]
    fn widened_while_loading(vectors: Vectors, frame: Frame<'_, Self>) -> bool {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = vectors.avx512() {
            frame.with_avx512(simd);
            return true;
        } else if let Some(simd) = vectors.avx2() {
            simd.vectorize(
                #[inline(always)]
                || frame.with(simd),
            );
            return true;
        }
        false
    }
}

/// The rows as floats, in `scratch`.
fn widened<'a, N: Narrow>(rows: &[N], scratch: &'a mut Vec<PanelRows>) -> &'a [PanelRows] {
    scratch.resize(rows.len(), PanelRows::ZERO);
    N::widen(rows, scratch);
    scratch
}

/// A row of a panel whose registers can be loaded with `S`.
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

#[cfg(target_arch = "x86_64")]
impl Load<pulp::x86::V4> for IntegerRows {
    #[inline(always)]
    fn load(&self, simd: pulp::x86::V4, register: usize) -> pulp::f32x16 {
        let (registers, _) = self.as_chunks::<16>();
        let integers = simd.avx512f._mm512_cvtepi16_epi32(pulp::cast(registers[register]));
        pulp::cast(simd.avx512f._mm512_cvtepi32_ps(integers))
    }
}

#[cfg(target_arch = "x86_64")]
impl Load<pulp::x86::V3> for IntegerRows {
    #[inline(always)]
    fn load(&self, simd: pulp::x86::V3, register: usize) -> pulp::f32x8 {
        let (registers, _) = self.as_chunks::<8>();
        let integers = simd.avx2._mm256_cvtepi16_epi32(pulp::cast(registers[register]));
        pulp::cast(simd.avx._mm256_cvtepi32_ps(integers))
    }
}

/// Consecutive vertices in one frame, with rows that are `R`.
struct Frame<'a, R> {
    rows: &'a [R],
    u: &'a [[f32; 3]],
    rest: &'a [[f32; 3]],
    out: &'a mut [[f32; 3]],
}

impl WithSimd for Frame<'_, PanelRows> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.with(simd);
    }
}

impl<R: Narrow> Frame<'_, R> {
    /// Widens the rows while they are loaded, or else a panel at a time.
    fn widened(self, vectors: Vectors, scratch: &mut Vec<PanelRows>) {
        let Self { rows, u, rest, out } = self;
        if R::widened_while_loading(vectors, Frame { rows, u, rest, out }) {
            return;
        }
        let panels = rows.chunks_exact(u.len()).zip(rest.chunks(PANEL).zip(out.chunks_mut(PANEL)));
        for (rows, (rest, out)) in panels {
            vectors.run(Frame { rows: widened(rows, scratch), u, rest, out });
        }
    }
}

impl<R> Frame<'_, R> {
    #[cfg(target_arch = "x86_64")]
    fn with_avx512(self, simd: pulp::x86::V4)
    where
        R: Load<pulp::x86::V4>,
    {
        simd.vectorize(
            #[inline(always)]
            || self.with(simd),
        );
    }

    #[inline(always)]
    fn with<S: Simd>(self, simd: S)
    where
        R: Load<S>,
    {
        let Self { rows, u, rest, out } = self;
        let panels = rows.chunks_exact(u.len()).zip(rest.chunks(PANEL).zip(out.chunks_mut(PANEL)));
        for (rows, (rest, out)) in panels {
            for first in (0..PANEL / S::F32_LANES).step_by(REGISTERS) {
                let mut sums = [[Lanes::splat(simd, 0.0); 3]; REGISTERS];
                for (rows, u) in rows.iter().zip(u) {
                    let u = splat3(simd, u);
                    for (i, sum) in sums.iter_mut().enumerate() {
                        let b = Lanes(simd, rows.load(simd, first + i));
                        for (sum, u) in sum.iter_mut().zip(u) {
                            *sum = b.mul_add(u, *sum);
                        }
                    }
                }
                let sums = [0, 1, 2].map(|axis| sums.map(|sum| sum[axis].1));
                let [x, y, z] = sums.each_ref().map(|sum| bytemuck::cast_slice::<_, f32>(sum));
                let first = (first * S::F32_LANES).min(out.len());
                let all = out[first..].iter_mut().zip(&rest[first..]).zip(x.iter().zip(y).zip(z));
                for ((out, rest), ((x, y), z)) in all {
                    *out = [rest[0] + x, rest[1] + y, rest[2] + z];
                }
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
