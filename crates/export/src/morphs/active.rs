//! Pairs of a vertex and a frame near the bound or beyond it, on which ADMM iterates (see [`super::fit`]).
//!
//! `Q T + D` (F×3V) is to be replaced by its best approximation of rank n. The directions hardly change
//! between two iterations, so one step of subspace iteration with a Rayleigh–Ritz projection suffices. Let G
//! be the Gram matrix of `Q T + D`, `P = Qᵀ (Q T + D) = T + Qᵀ D` and `B = D Pᵀ`. Then the columns of Q and
//! of G Q span the same space as those of Q and of B. S = [Q, S₂], F×s, is an orthonormal basis of this
//! space. So
//!
//! `R = Sᵀ (Q T + D) = [P; S₂ᵀ D]`, `R Rᵀ = A diag(λ) Aᵀ`, `Q ← S A`, `T ← Aᵀ R`
//!
//! with the leading n columns of A. D is zero but for a few entries, and nothing has the size F×F.

use super::factors::{Fit, Multiplier, combine, follow, narrow, outer};
use super::linear::{eigen, extend, product};
use faer::Mat;
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::Result;

/// Iterations until all vertices are looked at again.
const ITERATIONS: usize = 8;
/// Vectors are pulled a little further than to the bound: then finitely many iterations suffice. A smaller
/// number needs fewer iterations. But with 0.9, a head's animation needs 47 targets, and with 0.93 or 0.95 it
/// needs 46.
const CLIP_TO: f32 = 0.93;
/// The fewest vertices that a thread works on.
const LEAST: usize = 64;

/// What is near the bound or beyond it.
pub(super) struct Active {
    /// In ascending order.
    pub vertices: Vec<ActiveVertex>,
    /// Pairs of a vertex and a frame beyond the bound. Pairs for which there was no memory count too.
    pub over: usize,
    /// Whether there was memory for all that are beyond the bound.
    pub complete: bool,
}

/// A vertex with frames in which it is near the bound or beyond it.
pub(super) struct ActiveVertex {
    pub vertex: usize,
    /// In the order of frames.
    pub places: Vec<Place>,
}

/// Where a vertex should be in a frame.
pub(super) struct Place {
    pub frame: u32,
    /// The entry of Y.
    pub y: Vec3,
    /// The multiplier; 0 where there is none.
    pub u: Vec3,
}

/// A vertex that is pulled, or was pulled in the iteration before.
struct Pulled {
    /// Its index among the active ones.
    index: usize,
    /// The entries of D.
    entries: Vec<Entry>,
    /// Its columns of P, 3n numbers.
    p: Vec<f32>,
    /// In how many frames it is beyond the bound.
    over: usize,
}

/// The entry of D of a vertex in a frame.
struct Entry {
    frame: usize,
    d: Vec3,
}

/// Some iterations in which what is not active just follows.
///
/// # Errors
/// As [`eigen`].
pub(super) fn improve(fit: &mut Fit, active: Active, bound: f32) -> Result<()> {
    let n = fit.q.ncols();
    let mut vertices = active.vertices;
    let mut t: Vec<f32> =
        vertices.iter().flat_map(|active| &fit.t[3 * active.vertex * n..][..3 * n]).copied().collect();
    // T Tᵀ of all vertices.
    let mut of_t = outer(&fit.t, n);
    let mut turn = Mat::<f64>::identity(n, n);
    for _ in 0..ITERATIONS {
        let pulled = pull(&fit.q, &t, &mut vertices, bound);
        if pulled.iter().all(|pulled| pulled.over == 0) {
            break;
        }
        let b = b(&fit.q, &pulled);
        let s = extend(&fit.q, (0..n).map(|j| b.col(j)), fit.q.nrows());
        let r = extended(&s, n, &pulled);
        let before: Vec<f32> =
            pulled.iter().flat_map(|pulled| &t[3 * pulled.index * n..][..3 * n]).copied().collect();
        // R Rᵀ: of the vertices that are not pulled, R has the columns of T, with zeros below.
        let mut gram = outer(&r, s.ncols());
        let rest = &of_t - outer(&before, n);
        for j in 0..n {
            for i in 0..n {
                gram[(i, j)] += rest[(i, j)];
            }
        }
        let step = leading(&gram, n)?;
        fit.q = product(s.as_ref(), step.transpose());
        of_t = product(product(step.as_ref(), gram.as_ref()).as_ref(), step.transpose());
        let of_others = step.subcols(0, n).to_owned();
        follow(&mut t, &of_others, n);
        turn = product(of_others.as_ref(), turn.as_ref());
        let of_pulled = combine(&narrow(&step), &r);
        for (pulled, columns) in pulled.iter().zip(of_pulled.chunks(3 * n)) {
            t[3 * pulled.index * n..][..3 * n].copy_from_slice(columns);
        }
    }
    follow(&mut fit.t, &turn, n);
    for (ActiveVertex { vertex, places }, t) in vertices.iter().zip(t.chunks(3 * n)) {
        fit.t[3 * vertex * n..][..3 * n].copy_from_slice(t);
        let pulled = places.iter().filter(|place| place.u != Vec3::ZERO);
        fit.multipliers[*vertex] = pulled.map(|&Place { frame, u, .. }| Multiplier { frame, u }).collect();
    }
    Ok(())
}

/// Aᵀ, n×s. The constant direction stays the first and does not count as one of the others.
fn leading(gram: &Mat<f64>, n: usize) -> Result<Mat<f64>> {
    let s = gram.nrows();
    let axes = eigen(&gram.submatrix(1, 1, s - 1, s - 1).to_owned())?.vectors;
    Ok(Mat::from_fn(n, s, |i, j| match (i, j) {
        (0, _) | (_, 0) => f64::from(u8::from(i == j)),
        _ => axes[(j - 1, i - 1)],
    }))
}

/// One step of ADMM: new multipliers, and D for the vertices that are pulled. `t` has the active vertices'
/// columns of T.
fn pull(q: &Mat<f64>, t: &[f32], vertices: &mut [ActiveVertex], bound: f32) -> Vec<Pulled> {
    let n = q.ncols();
    let rows: Vec<f32> = (0..q.nrows()).flat_map(|i| (0..n).map(move |j| q[(i, j)] as f32)).collect();
    let arch = Arch::new();
    let rows = &rows[..];
    let pull = |(index, (vertex, t))| arch.dispatch(Pull { vertex, index, rows, t, bound });
    vertices
        .par_iter_mut()
        .zip(t.par_chunks(3 * n))
        .enumerate()
        .with_min_len(LEAST)
        .map(pull)
        .filter(|pulled| !pulled.entries.is_empty())
        .collect()
}

/// One step of ADMM for a vertex, with the widest vectors of the processor.
struct Pull<'a> {
    vertex: &'a mut ActiveVertex,
    /// Its index among the active ones.
    index: usize,
    /// Q, row by row.
    rows: &'a [f32],
    /// The vertex's columns of T.
    t: &'a [f32],
    bound: f32,
}

impl WithSimd for Pull<'_> {
    type Output = Pulled;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Pulled {
        let Self { vertex, index, rows, t, bound } = self;
        let n = t.len() / 3;
        let (x, others) = t.split_at(n);
        let (y, z) = others.split_at(n);
        let mut pulled = Pulled { index, entries: Vec::new(), p: Vec::new(), over: 0 };
        for place in &mut vertex.places {
            let q = &rows[place.frame as usize * n..][..n];
            let m = Vec3::new(dot(q, x), dot(q, y), dot(q, z));
            pulled.entries.extend(place.pull(m, bound, &mut pulled.over));
        }
        if pulled.entries.is_empty() {
            return pulled;
        }
        pulled.p = t.to_vec();
        for entry in &pulled.entries {
            let q = &rows[entry.frame * n..][..n];
            for (p, d) in pulled.p.chunks_exact_mut(n).zip(entry.d.to_array()) {
                p.iter_mut().zip(q).for_each(|(p, q)| *p += d * q);
            }
        }
        pulled
    }
}

/// The sum of the products.
#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    // Several sums, so that none waits for another one.
    let mut sums = [0.0_f32; 16];
    let (a, a_rest) = a.as_chunks::<16>();
    let (b, b_rest) = b.as_chunks::<16>();
    for (a, b) in a.iter().zip(b) {
        for i in 0..16 {
            sums[i] += a[i] * b[i];
        }
    }
    let mut half = sums.len() / 2;
    while half > 0 {
        for i in 0..half {
            sums[i] += sums[i + half];
        }
        half /= 2;
    }
    let mut sum = sums[0];
    for (a, b) in a_rest.iter().zip(b_rest) {
        sum += a * b;
    }
    sum
}

impl Place {
    /// The step for the vertex that is at `m`.
    #[inline(always)]
    fn pull(&mut self, m: Vec3, bound: f32, over: &mut usize) -> Option<Entry> {
        let radius = CLIP_TO * bound;
        let square = (self.y - m).length_squared();
        *over += usize::from(square > bound * bound);
        if square <= radius * radius && self.u == Vec3::ZERO {
            return None;
        }
        let old = self.u;
        let r = self.y - m - old;
        self.u = -r * (1.0 - radius / r.length()).max(0.0);
        Some(Entry { frame: self.frame as usize, d: old - 2.0 * self.u })
    }
}

/// Fills a vertex's columns of R, with the widest vectors of the processor.
struct Extend<'a> {
    pulled: &'a Pulled,
    /// The columns, `width` numbers for each.
    r: &'a mut [f32],
    /// S₂, row by row, `new` numbers for each frame.
    rows: &'a [f32],
    width: usize,
    new: usize,
}

impl WithSimd for Extend<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { pulled, r, rows, width, new } = self;
        let n = width - new;
        for (r, p) in r.chunks_exact_mut(width).zip(pulled.p.chunks_exact(n)) {
            r[..n].copy_from_slice(p);
        }
        for entry in &pulled.entries {
            let s = &rows[entry.frame * new..][..new];
            for (r, d) in r.chunks_exact_mut(width).zip(entry.d.to_array()) {
                r[n..].iter_mut().zip(s).for_each(|(r, s)| *r += d * s);
            }
        }
    }
}

/// B = D Pᵀ, F×n.
fn b(q: &Mat<f64>, pulled: &[Pulled]) -> Mat<f64> {
    let (f, n) = (q.nrows(), q.ncols());
    let mut rows = vec![0.0; f * n];
    for pulled in pulled {
        for entry in &pulled.entries {
            let row = &mut rows[entry.frame * n..][..n];
            for (p, d) in pulled.p.chunks_exact(n).zip(entry.d.to_array()) {
                row.iter_mut().zip(p).for_each(|(b, p)| *b += f64::from(d * p));
            }
        }
    }
    Mat::from_fn(f, n, |i, j| rows[i * n + j])
}

/// The columns of R of the vertices that are pulled, s×3 for each.
fn extended(s: &Mat<f64>, n: usize, pulled: &[Pulled]) -> Vec<f32> {
    let width = s.ncols();
    let new = width - n;
    let rows: Vec<f32> = (0..s.nrows()).flat_map(|i| (n..width).map(move |j| s[(i, j)] as f32)).collect();
    let mut r = vec![0.0; pulled.len() * 3 * width];
    let (arch, rows) = (Arch::new(), &rows[..]);
    r.par_chunks_mut(3 * width).zip(pulled).with_min_len(LEAST).for_each(|(r, pulled)| {
        arch.dispatch(Extend { pulled, r, rows, width, new });
    });
    r
}
