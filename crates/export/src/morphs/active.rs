//! The vertices near the bound or beyond it, which ADMM multipliers (see [`super::fit`]).
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

use super::factors::{Fit, Multiplier, combine, distances, follow, narrow, outer};
use super::linear::{eigen, extend, product};
use faer::Mat;
use glam::Vec3;
use rayon::prelude::*;
use rhytid_core::Result;

/// Iterations until all vertices are looked at again.
const ITERATIONS: usize = 8;
/// Vectors are pulled a little further than to the bound: then finitely many iterations suffice. A smaller
/// number needs fewer iterations. But with 0.9, a head's animation needs 47 targets, and with 0.93 or 0.95 it
/// needs 46.
const CLIP_TO: f32 = 0.93;
/// Parts that the vertices are divided into: sums over a part are added in order, so that threads do not
/// matter.
const PARTS: usize = 64;
/// Vertices that are looked at together.
const GROUP: usize = 32;

/// Vertices near the bound or beyond it.
pub(super) struct Active {
    /// In ascending order.
    pub vertices: Vec<usize>,
    /// Their columns of Y, 3F numbers each.
    pub y: Vec<f32>,
    /// Pairs of vertex and frame beyond the bound. Vertices for which there was no memory count too.
    pub over: usize,
    /// Whether there was memory for all that are beyond the bound.
    pub complete: bool,
}

/// The entries of D of one vertex in one frame.
struct Entry {
    /// Counted among the active ones of the part.
    vertex: usize,
    frame: usize,
    d: Vec3,
}

/// The result of pulling the vertices of one part.
struct Part {
    entries: Vec<Entry>,
    /// Their part of B, row-major F×n.
    b: Vec<f32>,
    over: usize,
}

/// Some iterations in which the vertices that are not active just follow.
///
/// # Errors
/// As [`eigen`].
pub(super) fn improve(fit: &mut Fit, active: &Active, bound: f32) -> Result<()> {
    let n = fit.q.ncols();
    let mut t: Vec<f32> =
        active.vertices.iter().flat_map(|&v| &fit.t[3 * v * n..][..3 * n]).copied().collect();
    let mut multipliers: Vec<Vec<Multiplier>> =
        active.vertices.iter().map(|&v| std::mem::take(&mut fit.multipliers[v])).collect();
    // T Tᵀ of those that follow.
    let mut rest = outer(&fit.t, n) - outer(&t, n);
    let mut turn = Mat::<f64>::identity(n, n);
    for _ in 0..ITERATIONS {
        let mut p = t.clone();
        let parts = update(&fit.q, &mut p, &active.y, &mut multipliers, bound);
        if parts.iter().all(|part| part.over == 0) {
            break;
        }
        let b = sum(&fit.q, &parts);
        let s = extend(&fit.q, (0..n).map(|j| b.col(j)), fit.q.nrows());
        let r = extended(&s, &p, n, &parts);
        let mut gram = outer(&r, s.ncols());
        for j in 0..n {
            for i in 0..n {
                gram[(i, j)] += rest[(i, j)];
            }
        }
        let step = leading(&gram, n)?;
        fit.q = product(s.as_ref(), step.transpose());
        t = combine(&narrow(&step), &r);
        let step = step.subcols(0, n);
        rest = product(product(step, rest.as_ref()).as_ref(), step.transpose());
        turn = product(step, turn.as_ref());
    }
    follow(&mut fit.t, &turn, n);
    for ((&v, t), multipliers) in active.vertices.iter().zip(t.chunks(3 * n)).zip(multipliers) {
        fit.t[3 * v * n..][..3 * n].copy_from_slice(t);
        fit.multipliers[v] = multipliers;
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

/// Active vertices of a part.
fn part(active: usize) -> usize {
    active.div_ceil(PARTS).next_multiple_of(GROUP)
}

/// New multipliers for all active vertices. `t` has their columns of T and becomes P.
fn update(
    q: &Mat<f64>,
    t: &mut [f32],
    y: &[f32],
    multipliers: &mut [Vec<Multiplier>],
    bound: f32,
) -> Vec<Part> {
    let (f, n) = (q.nrows(), q.ncols());
    let rows: Vec<f32> = (0..f).flat_map(|i| (0..n).map(move |j| q[(i, j)] as f32)).collect();
    let q = narrow(q);
    let size = part(multipliers.len());
    multipliers
        .par_chunks_mut(size)
        .zip(y.par_chunks(size * 3 * f))
        .zip(t.par_chunks_mut(size * 3 * n))
        .map(|((multipliers, y), t)| {
            let mut part = Part { entries: Vec::new(), b: vec![0.0; f * n], over: 0 };
            let mut squares = vec![0.0; f];
            for first in (0..multipliers.len()).step_by(GROUP) {
                let count = GROUP.min(multipliers.len() - first);
                let m = combine(&q, &t[3 * first * n..][..3 * count * n]);
                for (i, m) in m.chunks(3 * f).enumerate() {
                    let y = &y[3 * (first + i) * f..][..3 * f];
                    distances(y, m, &mut squares);
                    part.update(first + i, y, m, &squares, &mut multipliers[first + i], bound);
                }
            }
            for group in part.entries.chunk_by(|a, b| a.vertex == b.vertex) {
                let t = &mut t[3 * group[0].vertex * n..][..3 * n];
                for entry in group {
                    let q = &rows[entry.frame * n..][..n];
                    for (t, d) in t.chunks_exact_mut(n).zip(entry.d.to_array()) {
                        t.iter_mut().zip(q).for_each(|(t, q)| *t += d * q);
                    }
                }
                for entry in group {
                    let b = &mut part.b[entry.frame * n..][..n];
                    for (t, d) in t.chunks_exact(n).zip(entry.d.to_array()) {
                        b.iter_mut().zip(t).for_each(|(b, t)| *b += d * t);
                    }
                }
            }
            part
        })
        .collect()
}

impl Part {
    /// One step of ADMM for one vertex: `m` is where it is, `squares` how far from where it should be.
    fn update(
        &mut self,
        vertex: usize,
        y: &[f32],
        m: &[f32],
        squares: &[f32],
        multipliers: &mut Vec<Multiplier>,
        bound: f32,
    ) {
        let f = squares.len();
        let radius = CLIP_TO * bound;
        let before = std::mem::take(multipliers);
        let mut before = before.iter().peekable();
        for (frame, &square) in squares.iter().enumerate() {
            let old = before
                .next_if(|multiplier| multiplier.frame as usize == frame)
                .map(|multiplier| multiplier.u);
            if square <= radius * radius && old.is_none() {
                continue;
            }
            self.over += usize::from(square > bound * bound);
            let old = old.unwrap_or_default();
            let at = |x: &[f32]| Vec3::new(x[frame], x[f + frame], x[2 * f + frame]);
            let r = at(y) - at(m) - old;
            let beyond = (1.0 - radius / r.length()).max(0.0);
            let u = -r * beyond;
            if beyond > 0.0 {
                multipliers.push(Multiplier { frame: frame as u32, u });
            }
            self.entries.push(Entry { vertex, frame, d: old - 2.0 * u });
        }
    }
}

/// B, F×n.
fn sum(q: &Mat<f64>, parts: &[Part]) -> Mat<f64> {
    let n = q.ncols();
    let mut b = Mat::<f64>::zeros(q.nrows(), n);
    for part in parts {
        for (i, row) in part.b.chunks(n).enumerate() {
            for (j, &x) in row.iter().enumerate() {
                b[(i, j)] += f64::from(x);
            }
        }
    }
    b
}

/// R for the active vertices, column-major s×3A, from P.
fn extended(s: &Mat<f64>, p: &[f32], n: usize, parts: &[Part]) -> Vec<f32> {
    let (f, width) = (s.nrows(), s.ncols());
    let new = width - n;
    let rows: Vec<f32> = (0..f).flat_map(|i| (n..width).map(move |j| s[(i, j)] as f32)).collect();
    let mut r = vec![0.0; p.len() / n * width];
    let size = 3 * part(p.len() / (3 * n));
    r.par_chunks_mut(size * width).zip(p.par_chunks(size * n)).zip(parts).for_each(|((r, p), part)| {
        for (r, p) in r.chunks_exact_mut(width).zip(p.chunks_exact(n)) {
            r[..n].copy_from_slice(p);
        }
        for entry in &part.entries {
            let s = &rows[entry.frame * new..][..new];
            for (r, d) in
                r[3 * entry.vertex * width..][..3 * width].chunks_exact_mut(width).zip(entry.d.to_array())
            {
                r[n..].iter_mut().zip(s).for_each(|(r, s)| *r += d * s);
            }
        }
    });
    r
}
