//! Frames as combinations of n columns, so that no vertex is further than a bound from its place.
//!
//! Wanted is a matrix M = Q T of rank n (F×3V; Q: F×n, orthonormal, its first column constant; T: n×3V) within the
//! bound of Y, the centred positions, for each vertex of each frame. ADMM (Boyd et al. 2011, sections 5.1 and 9.1)
//! projects in turn onto the matrices near Y (each 3-vector for itself, pulled to the ball around its place) and onto
//! those of rank n (the leading directions), with multipliers U that remember how hard each 3-vector had to be pulled.
//! With Z the pulled M + U:
//!
//! `U ← M + U − Z`, `M ← rank n of Z − U`
//!
//! Only what is near the bound is pulled, so `Z − U` differs from M in few numbers, D. Vertices that are far from the
//! bound just follow Q meanwhile ([`super::active`] has the others); all are looked at every few iterations, those that
//! have come near the bound join, and nothing is returned before all vertices of all frames were found within it.

use super::active::{Active, Pull, improve};
use super::frames::{Attribute, Centred, Frames, Gram, TASK};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use rhytid_core::Result;

/// Times that all vertices are looked at.
pub(super) const ROUNDS: usize = 16;
/// So many numbers of (vertex, frame) beyond the bound, foreseen for the last round, are too many to go on. The last
/// few go faster than those before them: where 6 were foreseen, the rank has succeeded after all.
const HOPELESS: f64 = 10.0;
/// Vertices with an error above this part of the bound are looked at in every iteration.
const NEAR: f32 = 0.75;
/// Memory for these, in bytes. If more vertices are beyond the bound, there are too few columns.
const ACTIVE_BYTES: usize = 1 << 30;

/// A factorisation `Y ≈ Q T`.
#[derive(Clone)]
pub(super) struct Fit {
    /// F×n, orthonormal, the first column constant. The others explain the less the further behind they are.
    pub q: Mat<f64>,
    /// Column-major n×3V.
    pub t: Vec<f32>,
    /// For each vertex, the multipliers that are not zero, in the order of frames.
    pub pulls: Vec<Vec<Pull>>,
}

impl Fit {
    /// The frames' projection on the columns of `q`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Io`].
    pub(super) fn on(frames: &mut Frames, gram: &Gram, q: Mat<f64>) -> Result<Self> {
        let t = project(frames, Attribute::Positions, &gram.center, &q)?;
        Ok(Self { q, t, pulls: vec![Vec::new(); frames.vertices()] })
    }

    /// The first n columns. The multipliers stay: what was hard to reach stays so.
    pub(super) fn first(&self, n: usize) -> Self {
        let t = self.t.chunks(self.q.ncols()).flat_map(|t| &t[..n]).copied().collect();
        Self { q: self.q.subcols(0, n).to_owned(), t, pulls: self.pulls.clone() }
    }
}

/// Improves a fit until it is within the bound; none if its number of columns does not seem to suffice. `tick` is
/// called once a round.
///
/// # Errors
/// [`rhytid_core::Error::Io`], and what `tick` returns.
pub(super) fn fit(
    centred: &mut Centred<'_>,
    mut fit: Fit,
    bound: f64,
    tick: &mut dyn FnMut(usize) -> Result<()>,
) -> Result<Option<Fit>> {
    let bound = bound as f32;
    let mut history = Vec::new();
    for round in 0..ROUNDS {
        tick(round)?;
        let active = examine(centred, &fit, bound)?;
        if active.over == 0 {
            return Ok(Some(fit));
        }
        history.push(active.over);
        if !active.complete || hopeless(&history) {
            return Ok(None);
        }
        improve(&mut fit, &active, bound)?;
    }
    Ok(None)
}

/// Whether too much will be left beyond the bound after all rounds if each takes away the part that the last two took.
/// Few numbers come and go, so that they may grow.
fn hopeless(history: &[usize]) -> bool {
    let &[.., before, _, now] = history else { return false };
    let (before, now) = (before as f64, now as f64);
    let left = ROUNDS - history.len();
    now * (now / before).min(1.0).powf(left as f64 / 2.0) > HOPELESS
}

/// Qᵀ times an attribute less `center`, column-major n×3V.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn project(
    frames: &mut Frames,
    attribute: Attribute,
    center: &[f32],
    q: &Mat<f64>,
) -> Result<Vec<f32>> {
    let (f, n) = (q.nrows(), q.ncols());
    let q = narrow(q);
    let mut t = vec![0.0; n * 3 * frames.vertices()];
    for first in frames.blocks() {
        let block = frames.block(attribute, first, center)?;
        t[3 * first * n..][..3 * block.count * n]
            .par_chunks_mut(3 * TASK * n)
            .zip(block.values.par_chunks(3 * TASK * f))
            .for_each(|(t, y)| {
                let columns = t.len() / n;
                let y = MatRef::from_column_major_slice(y, f, columns);
                let t = MatMut::from_column_major_slice_mut(t, n, columns);
                matmul(t, Accum::Replace, q.transpose(), y, 1.0, Par::Seq);
            });
    }
    Ok(t)
}

/// In float32.
pub(super) fn narrow(m: &Mat<f64>) -> Mat<f32> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] as f32)
}

/// Looks at all vertices.
fn examine(centred: &mut Centred<'_>, fit: &Fit, bound: f32) -> Result<Active> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let q = narrow(&fit.q);
    let most = ACTIVE_BYTES / (24 * f);
    let mut active = Active { vertices: Vec::new(), y: Vec::new(), over: 0, complete: true };
    for first in centred.frames.blocks() {
        let block = centred.block(first)?;
        let found: Vec<Vec<(f32, usize)>> = block
            .values
            .par_chunks(3 * TASK * f)
            .zip(fit.t[3 * first * n..].par_chunks(3 * TASK * n))
            .map(|(y, t)| {
                let mut squares = vec![0.0; f];
                let m = combine(&q, &t[..y.len() / f * n]);
                let largest = |(y, m)| {
                    distances(y, m, &mut squares);
                    let most = squares.iter().fold(0.0, |most: f32, &square| most.max(square)).sqrt();
                    (most, squares.iter().filter(|&&square| square > bound * bound).count())
                };
                y.chunks(3 * f).zip(m.chunks(3 * f)).map(largest).collect()
            })
            .collect();
        let vertices = found.into_iter().flatten().zip(block.values.chunks_exact(3 * f));
        for (vertex, ((error, over), y)) in (first..).zip(vertices) {
            active.over += over;
            if error <= NEAR * bound && fit.pulls[vertex].is_empty() {
                continue;
            }
            if active.vertices.len() >= most {
                active.complete &= over == 0;
                continue;
            }
            active.vertices.push(vertex);
            active.y.extend(y);
        }
    }
    Ok(active)
}

/// The largest distance of a vertex from its place in any frame.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn worst(centred: &mut Centred<'_>, fit: &Fit) -> Result<f64> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let q = narrow(&fit.q);
    let mut worst = 0.0_f32;
    for first in centred.frames.blocks() {
        let block = centred.block(first)?;
        let found =
            block.values.par_chunks(3 * TASK * f).zip(fit.t[3 * first * n..].par_chunks(3 * TASK * n));
        let largest = found.map(|(y, t)| {
            let mut squares = vec![0.0; f];
            let m = combine(&q, &t[..y.len() / f * n]);
            let most = |(y, m)| {
                distances(y, m, &mut squares);
                squares.iter().fold(0.0, |most: f32, &square| most.max(square))
            };
            y.chunks(3 * f).zip(m.chunks(3 * f)).map(most).fold(0.0, f32::max)
        });
        worst = worst.max(largest.reduce(|| 0.0, f32::max));
    }
    Ok(f64::from(worst).sqrt())
}

/// Q times columns of T: F numbers each.
pub(super) fn combine(q: &Mat<f32>, t: &[f32]) -> Vec<f32> {
    let (f, n) = (q.nrows(), q.ncols());
    let columns = t.len() / n;
    let mut m = vec![0.0; f * columns];
    let t = MatRef::from_column_major_slice(t, n, columns);
    let out = MatMut::from_column_major_slice_mut(&mut m, f, columns);
    matmul(out, Accum::Replace, q.as_ref(), t, 1.0, Par::Seq);
    m
}

/// The squared distances of a vertex (3F numbers, component by component) from where it should be, for each frame.
pub(super) fn distances(y: &[f32], m: &[f32], squares: &mut [f32]) {
    let f = squares.len();
    for (c, (y, m)) in y.chunks_exact(f).zip(m.chunks_exact(f)).enumerate() {
        for ((square, y), m) in squares.iter_mut().zip(y).zip(m) {
            let d = y - m;
            *square = if c == 0 { d * d } else { *square + d * d };
        }
    }
}

/// T Tᵀ; only its lower half is computed.
pub(super) fn outer(t: &[f32], n: usize) -> Mat<f64> {
    let mut sum = Mat::zeros(n, n);
    for part in t.chunks(64 * 3 * TASK * n) {
        let sums: Vec<Mat<f64>> = part
            .par_chunks(3 * TASK * n)
            .map(|t| {
                let t: Vec<f64> = t.iter().copied().map(f64::from).collect();
                let t = MatRef::from_column_major_slice(&t, n, t.len() / n);
                let mut sum = Mat::zeros(n, n);
                let (lower, full) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
                let to = sum.as_mut();
                triangular::matmul(to, lower, Accum::Replace, t, full, t.transpose(), full, 1.0, Par::Seq);
                sum
            })
            .collect();
        for part in &sums {
            sum += part;
        }
    }
    for j in 0..n {
        for i in 0..j {
            sum[(i, j)] = sum[(j, i)];
        }
    }
    sum
}

/// `T ← turn T`.
pub(super) fn follow(t: &mut [f32], turn: &Mat<f64>, n: usize) {
    let turn = narrow(turn);
    t.par_chunks_mut(3 * TASK * n).for_each(|t| {
        let turned = combine(&turn, t);
        t.copy_from_slice(&turned);
    });
}
