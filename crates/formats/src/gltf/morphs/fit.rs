//! Frames as combinations of n columns, so that no vertex is further than a bound from its place.
//!
//! Wanted is a matrix M = Q T of rank n (F×3V; Q: F×n, orthonormal, its first column constant; T: n×3V) within the
//! bound of Y, the centred positions, for each vertex of each frame. ADMM projects in turn onto the matrices near Y
//! (each 3-vector for itself, pulled to the ball around its place) and onto those of rank n (the leading directions),
//! with multipliers U that remember how hard each 3-vector had to be pulled. With Z the pulled M + U:
//!
//! `U ← M + U − Z`, `M ← rank n of Z − U`
//!
//! Only what is near the bound is pulled, so `Z − U` differs from M in few numbers, D. What is far from the bound is
//! looked at only every few iterations, and the Gram matrix of `Q T + D` is put together from small matrices.

use super::frames::{Attribute, Frames, Gram, TASK};
use super::linear::{leading, product};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use rhytid_core::Result;

/// Times that all vertices are looked at.
pub const ROUNDS: usize = 16;
/// Iterations in between.
const ITERATIONS: usize = 8;
/// What is pulled is pulled a little further than to the bound: then finitely many iterations suffice.
const PULL_TO: f32 = 0.95;
/// Vertices with an error above this part of the bound are looked at in every iteration.
const NEAR: f32 = 0.75;
/// Memory for these, in bytes. If more vertices are beyond the bound, there are too few columns.
const ACTIVE_BYTES: usize = 1 << 30;
/// Vertices of a task of an iteration.
const ACTIVE_TASK: usize = 32;

/// A factorisation `Y ≈ Q T`.
pub struct Fit {
    /// F×n.
    pub q: Mat<f64>,
    /// Column-major n×3V.
    pub t: Vec<f32>,
}

/// Vertices near the bound or beyond it.
struct Active {
    vertices: Vec<usize>,
    /// Their columns of Y, F numbers each.
    y: Vec<f32>,
    /// Their columns of U.
    u: Vec<f32>,
    /// Numbers of (vertex, frame) beyond the bound, those of vertices for which there was no memory included.
    over: usize,
    /// Whether there was memory for all that are beyond the bound.
    complete: bool,
}

/// A number of D: column of the active ones, frame and value.
type Entry = (usize, usize, f32);

/// Starts from the columns `q` and returns none if that many do not seem to suffice. `tick` is called once a round.
///
/// # Errors
/// [`rhytid_core::Error::Io`], and what `tick` returns.
pub fn fit(
    frames: &mut Frames,
    gram: &Gram,
    q: Mat<f64>,
    bound: f64,
    tick: &mut dyn FnMut(usize) -> Result<()>,
) -> Result<Option<Fit>> {
    let bound = bound as f32;
    let t = project(frames, Attribute::Positions, &gram.center, &q)?;
    let mut fit = Fit { q, t };
    let mut active = Active { vertices: Vec::new(), y: Vec::new(), u: Vec::new(), over: 0, complete: true };
    let mut history = Vec::new();
    for round in 0..ROUNDS {
        tick(round)?;
        active = examine(frames, gram, &fit, bound, &active)?;
        if active.over == 0 {
            return Ok(Some(fit));
        }
        history.push(active.over);
        if !active.complete || stalled(&history) {
            return Ok(None);
        }
        improve(&mut fit, &mut active, bound)?;
    }
    Ok(None)
}

/// Whether two rounds did not take away much of what is beyond the bound.
fn stalled(history: &[usize]) -> bool {
    let n = history.len();
    n > 3 && history[n - 1] > 3 && history[n - 1] * 5 > history[n - 3] * 3
}

/// Qᵀ times an attribute less `center`, column-major n×3V.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub fn project(frames: &mut Frames, attribute: Attribute, center: &[f32], q: &Mat<f64>) -> Result<Vec<f32>> {
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

fn narrow(m: &Mat<f64>) -> Mat<f32> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] as f32)
}

/// Looks at all vertices, and takes along what `before` knows of its own.
fn examine(frames: &mut Frames, gram: &Gram, fit: &Fit, bound: f32, before: &Active) -> Result<Active> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let q = narrow(&fit.q);
    let most = ACTIVE_BYTES / (24 * f);
    let mut active = Active { vertices: Vec::new(), y: Vec::new(), u: Vec::new(), over: 0, complete: true };
    for first in frames.blocks() {
        let block = frames.block(Attribute::Positions, first, &gram.center)?;
        let found: Vec<Vec<(f32, usize)>> = block
            .values
            .par_chunks(3 * TASK * f)
            .zip(fit.t[3 * first * n..].par_chunks(3 * TASK * n))
            .map(|(y, t)| {
                let m = combine(&q, &t[..y.len() / f * n]);
                y.chunks(3 * f).zip(m.chunks(3 * f)).map(|(y, m)| largest(y, m, f, bound)).collect()
            })
            .collect();
        for (i, (error, over)) in found.into_iter().flatten().enumerate() {
            let vertex = first + i;
            let known =
                before.vertices.binary_search(&vertex).ok().map(|at| &before.u[at * 3 * f..][..3 * f]);
            let pulled = known.is_some_and(|u| u.iter().any(|&u| u != 0.0));
            active.over += over;
            if error <= NEAR * bound && !pulled {
                continue;
            }
            if active.vertices.len() >= most {
                active.complete &= over == 0;
                continue;
            }
            active.vertices.push(vertex);
            active.y.extend(&block.values[i * 3 * f..][..3 * f]);
            match known {
                Some(u) => active.u.extend(u),
                None => active.u.resize(active.y.len(), 0.0),
            }
        }
    }
    Ok(active)
}

/// Q times columns of T: F numbers each.
fn combine(q: &Mat<f32>, t: &[f32]) -> Vec<f32> {
    let (f, n) = (q.nrows(), q.ncols());
    let columns = t.len() / n;
    let mut m = vec![0.0; f * columns];
    let t = MatRef::from_column_major_slice(t, n, columns);
    let out = MatMut::from_column_major_slice_mut(&mut m, f, columns);
    matmul(out, Accum::Replace, q.as_ref(), t, 1.0, Par::Seq);
    m
}

/// The largest error of a vertex, and in how many frames it is beyond the bound.
fn largest(y: &[f32], m: &[f32], f: usize, bound: f32) -> (f32, usize) {
    let mut most = 0.0_f32;
    let mut over = 0;
    for i in 0..f {
        let d = [0, f, 2 * f].map(|c| y[c + i] - m[c + i]);
        let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        most = most.max(square);
        over += usize::from(square > bound * bound);
    }
    (most.sqrt(), over)
}

/// Some iterations in which the vertices that are not active just follow.
fn improve(fit: &mut Fit, active: &mut Active, bound: f32) -> Result<()> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let mut t: Vec<f32> =
        active.vertices.iter().flat_map(|&v| &fit.t[3 * v * n..][..3 * n]).copied().collect();
    let mut tt = outer(&fit.t, n);
    let mut turn = Mat::<f64>::identity(n, n);
    for _ in 0..ITERATIONS {
        let (entries, over) = pull(&fit.q, &t, active, bound);
        if over == 0 {
            break;
        }
        let g = gram_of(&fit.q, &tt, &t, &entries);
        let q = leading(&g, &fit.q)?;
        let step = product(q.transpose(), fit.q.as_ref());
        tt = product(product(q.transpose(), g.as_ref()).as_ref(), q.as_ref());
        follow(&mut t, &step, n);
        for &(column, frame, d) in &entries {
            for (k, t) in t[column * n..][..n].iter_mut().enumerate() {
                *t += d * q[(frame, k)] as f32;
            }
        }
        turn = product(step.as_ref(), turn.as_ref());
        fit.q = q;
    }
    debug_assert_eq!(fit.q.nrows(), f);
    follow(&mut fit.t, &turn, n);
    for (&v, t) in active.vertices.iter().zip(t.chunks(3 * n)) {
        fit.t[3 * v * n..][..3 * n].copy_from_slice(t);
    }
    Ok(())
}

/// One step of ADMM for the active vertices: new multipliers, the entries of D in the order of columns, and how many
/// (vertex, frame) are beyond the bound.
fn pull(q: &Mat<f64>, t: &[f32], active: &mut Active, bound: f32) -> (Vec<Entry>, usize) {
    let (f, n) = (q.nrows(), q.ncols());
    let q = narrow(q);
    let radius = PULL_TO * bound;
    let task = 3 * ACTIVE_TASK;
    let parts: Vec<(Vec<Entry>, usize)> = active
        .u
        .par_chunks_mut(task * f)
        .zip(active.y.par_chunks(task * f))
        .zip(t.par_chunks(task * n))
        .enumerate()
        .map(|(part, ((u, y), t))| {
            let m = combine(&q, t);
            let mut entries = Vec::new();
            let mut over = 0;
            for v in 0..u.len() / (3 * f) {
                for i in 0..f {
                    let at = [0, 1, 2].map(|c| (3 * v + c) * f + i);
                    let r = at.map(|j| y[j] - m[j]);
                    over += usize::from(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] > bound * bound);
                    let old = at.map(|j| u[j]);
                    let r = [r[0] - old[0], r[1] - old[1], r[2] - old[2]];
                    let length = (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]).sqrt();
                    let beyond = if length > radius { 1.0 - radius / length } else { 0.0 };
                    if beyond == 0.0 && old == [0.0; 3] {
                        continue;
                    }
                    for c in 0..3 {
                        let new = -r[c] * beyond;
                        u[at[c]] = new;
                        entries.push((part * task + 3 * v + c, i, old[c] - 2.0 * new));
                    }
                }
            }
            entries.sort_unstable_by_key(|&(column, frame, _)| (column, frame));
            (entries, over)
        })
        .collect();
    let over = parts.iter().map(|part| part.1).sum();
    (parts.into_iter().flat_map(|part| part.0).collect(), over)
}

/// The Gram matrix of `Q T + D`, F×F, from `tt` = T Tᵀ; `t` has the active columns of T.
fn gram_of(q: &Mat<f64>, tt: &Mat<f64>, t: &[f32], entries: &[Entry]) -> Mat<f64> {
    let (f, n) = (q.nrows(), q.ncols());
    let mut td = Mat::<f64>::zeros(n, f);
    let mut g = product(product(q.as_ref(), tt.as_ref()).as_ref(), q.transpose());
    for column in entries.chunk_by(|a, b| a.0 == b.0) {
        let t = &t[column[0].0 * n..][..n];
        for &(_, frame, d) in column {
            for (k, &t) in t.iter().enumerate() {
                td[(k, frame)] += f64::from(t) * f64::from(d);
            }
            for &(_, other, e) in column {
                g[(other, frame)] += f64::from(d) * f64::from(e);
            }
        }
    }
    let mixed = product(q.as_ref(), td.as_ref());
    Mat::from_fn(f, f, |i, j| g[(i, j)] + mixed[(i, j)] + mixed[(j, i)])
}

/// T Tᵀ.
pub fn outer(t: &[f32], n: usize) -> Mat<f64> {
    let mut sum = Mat::zeros(n, n);
    for part in t.chunks(64 * 3 * TASK * n) {
        let sums: Vec<Mat<f64>> = part
            .par_chunks(3 * TASK * n)
            .map(|t| {
                let t: Vec<f64> = t.iter().copied().map(f64::from).collect();
                let t = MatRef::from_column_major_slice(&t, n, t.len() / n);
                product(t, t.transpose())
            })
            .collect();
        for part in &sums {
            sum += part;
        }
    }
    sum
}

/// `T ← turn T`.
pub fn follow(t: &mut [f32], turn: &Mat<f64>, n: usize) {
    let turn = narrow(turn);
    t.par_chunks_mut(3 * TASK * n).for_each(|t| {
        let turned = combine(&turn, t);
        t.copy_from_slice(&turned);
    });
}
