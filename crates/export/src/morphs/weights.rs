//! The weights of all frames, for shapes that were found for some of them.
//!
//! Least squares is the start. If it leaves vertices of a frame beyond the bound, the weights of that frame
//! are moved until all are within it, by the least motion of the other vertices. That is a step of Newton's
//! method for `Σ_v max(0, |r_v| − radius)² + λ |T δ|²`, where r_v is how far vertex v is from its place, and
//! δ the change of the weights. The steps look at the vertices near the bound. All vertices are looked at
//! after some steps. A frame counts as met only if all its vertices are within the bound.

use super::factors::Fit;
use super::frames::{Attribute, Frames};
use super::linear::{eigen, product};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use rhytid_core::{Progress, Result};

/// Frames that a thread works on at once.
const GROUP: usize = 32;
/// How many times all vertices of a frame are looked at.
const ROUNDS: usize = 6;
/// Steps between two looks at all vertices.
const STEPS: usize = 8;
/// Vertices with an error above this part of the bound take part in the steps.
const NEAR: f32 = 0.7;
/// Vertices are moved to this part of the bound.
const RADIUS: f64 = 0.94;
/// λ.
const DAMPING: f64 = 1e-4;

/// All frames as combinations of the rows of a fit's T.
pub(super) struct Weights {
    /// F×n; the first column is constant.
    pub weights: Mat<f64>,
    /// How far the worst vertex of each frame is from its place.
    pub errors: Vec<f64>,
}

/// T in another basis, in which the motions of unit weights are orthonormal.
struct Orthonormal {
    /// m×3V, column by column.
    t: Vec<f32>,
    m: usize,
    /// 3V: what the constant column adds to.
    base: Vec<f32>,
}

/// Finds the weights of all frames. `center` is the mean that the fit's positions are relative to.
///
/// # Errors
/// [`rhytid_core::Error::Io`]; [`rhytid_core::Error::Cancelled`]; as [`eigen`].
pub(super) fn weights(
    frames: &mut Frames,
    fit: &Fit,
    center: &[f32],
    bound: f64,
    progress: &dyn Progress,
) -> Result<Weights> {
    const NAME: &str = "fit all frames";
    let n = fit.q.ncols();
    let constant = fit.q[(0, 0)];
    let (basis, back) = orthonormal(fit, center)?;
    let m = basis.m;
    let all = frames.frames();
    let mut weights = Vec::with_capacity(all * m);
    let mut errors = Vec::with_capacity(all);
    for batch in frames.batches() {
        progress.step(NAME, batch.start as u64, all as u64)?;
        let mut values = frames.batch(Attribute::Positions, batch)?;
        let found: Vec<(Vec<f32>, Vec<f32>)> =
            values.par_chunks_mut(GROUP * basis.base.len()).map(|y| of_group(&basis, y, bound)).collect();
        for (some, worst) in found {
            weights.extend(some);
            errors.extend(worst.into_iter().map(f64::from));
        }
    }
    progress.step(NAME, all as u64, all as u64)?;
    let weights = Mat::from_fn(all, m, |i, j| f64::from(weights[i * m + j]));
    let weights = product(weights.as_ref(), back.as_ref());
    let weights = Mat::from_fn(all, n, |i, j| if j == 0 { constant } else { weights[(i, j - 1)] });
    Ok(Weights { weights, errors })
}

/// The rows of T but the first in an orthonormal basis, and what turns weights of that basis to weights of T.
fn orthonormal(fit: &Fit, center: &[f32]) -> Result<(Orthonormal, Mat<f64>)> {
    let n = fit.q.ncols();
    let gram = super::factors::outer(&fit.t, n);
    let axes = eigen(&gram.submatrix(1, 1, n - 1, n - 1).to_owned())?;
    let largest = axes.values.first().copied().unwrap_or(0.0);
    // Directions below float32's precision are of no use.
    let m = axes.values.iter().take_while(|&&value| value > 1e-12 * largest && value > 0.0).count();
    // T' = diag(λ)^-½ Aᵀ T and w = w' diag(λ)^-½ Aᵀ.
    let back = Mat::from_fn(m, n - 1, |i, j| axes.vectors[(j, i)] / axes.values[i].sqrt());
    let turn = Mat::from_fn(m, n, |i, j| if j == 0 { 0.0 } else { back[(i, j - 1)] as f32 });
    let constant = fit.q[(0, 0)];
    let base = fit
        .t
        .par_chunks(n)
        .zip(center)
        .map(|(t, center)| (f64::from(*center) + constant * f64::from(t[0])) as f32);
    let base = base.collect();
    let t = fit.t.par_chunks(n * 1024).flat_map_iter(|t| super::factors::combine(&turn, t)).collect();
    Ok((Orthonormal { t, m, base }, back))
}

/// The weights of some frames, and the errors of their worst vertices. `y` has their positions, and becomes
/// what is left of them.
fn of_group(basis: &Orthonormal, y: &mut [f32], bound: f64) -> (Vec<f32>, Vec<f32>) {
    let (m, numbers) = (basis.m, basis.base.len());
    let count = y.len() / numbers;
    for y in y.chunks_mut(numbers) {
        y.iter_mut().zip(&basis.base).for_each(|(y, base)| *y -= base);
    }
    let t = MatRef::from_column_major_slice(&basis.t, m, numbers);
    let mut weights = vec![0.0_f32; count * m];
    let to = MatMut::from_column_major_slice_mut(&mut weights, m, count);
    matmul(to, Accum::Replace, t, MatRef::from_column_major_slice(y, numbers, count), 1.0, Par::Seq);
    subtract(t, y, &weights);
    let mut errors: Vec<f32> = y.chunks(numbers).map(worst).collect();
    let mut best = weights.clone();
    let mut open: Vec<usize> = (0..count).filter(|&i| f64::from(errors[i]) > bound).collect();
    for _ in 0..ROUNDS {
        if open.is_empty() {
            break;
        }
        let mut steps = vec![0.0_f32; open.len() * m];
        for (&i, step) in open.iter().zip(steps.chunks_mut(m.max(1))) {
            improve(basis, &y[i * numbers..][..numbers], bound, step);
        }
        let mut rests: Vec<f32> = open.iter().flat_map(|&i| &y[i * numbers..][..numbers]).copied().collect();
        subtract(t, &mut rests, &steps);
        for ((&i, step), rest) in open.iter().zip(steps.chunks(m.max(1))).zip(rests.chunks(numbers)) {
            y[i * numbers..][..numbers].copy_from_slice(rest);
            let weights = &mut weights[i * m..][..m];
            weights.iter_mut().zip(step).for_each(|(w, step)| *w += step);
            let error = worst(rest);
            if error < errors[i] {
                errors[i] = error;
                best[i * m..][..m].copy_from_slice(weights);
            }
        }
        open.retain(|&i| f64::from(errors[i]) > bound);
    }
    (best, errors)
}

/// `rest −= Tᵀ weights`.
fn subtract(t: MatRef<'_, f32>, rest: &mut [f32], weights: &[f32]) {
    let (m, numbers) = (t.nrows(), t.ncols());
    if m == 0 || numbers == 0 {
        return;
    }
    let count = rest.len() / numbers;
    let weights = MatRef::from_column_major_slice(weights, m, count);
    let rest = MatMut::from_column_major_slice_mut(rest, numbers, count);
    matmul(rest, Accum::Add, t.transpose(), weights, -1.0, Par::Seq);
}

fn square(r: &[f32; 3]) -> f32 {
    r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
}

/// The length of the longest vector.
fn worst(rest: &[f32]) -> f32 {
    rest.as_chunks::<3>().0.iter().map(square).fold(0.0, f32::max).sqrt()
}

/// A change of the weights that brings the vertices near the bound within it, or nearer.
fn improve(basis: &Orthonormal, rest: &[f32], bound: f64, change: &mut [f32]) {
    let m = basis.m;
    let near = (NEAR * bound as f32).powi(2);
    let vectors = rest.as_chunks::<3>().0.iter().enumerate();
    let active: Vec<(usize, [f32; 3])> =
        vectors.filter(|(_, r)| square(r) > near).map(|(v, r)| (v, *r)).collect();
    let radius = RADIUS * bound;
    let mut total = vec![0.0_f64; m];
    for _ in 0..STEPS {
        let mut rows: Vec<f64> = Vec::new();
        let mut excess = Vec::new();
        let mut beyond = false;
        for (v, r) in &active {
            let t: [&[f32]; 3] = std::array::from_fn(|c| &basis.t[(3 * v + c) * m..][..m]);
            let mut at = r.map(f64::from);
            for (at, t) in at.iter_mut().zip(t) {
                *at -= total.iter().zip(t).map(|(w, t)| w * f64::from(*t)).sum::<f64>();
            }
            let length = (at[0] * at[0] + at[1] * at[1] + at[2] * at[2]).sqrt();
            if length > radius {
                beyond |= length > bound;
                let d = at.map(|x| x / length);
                rows.extend((0..m).map(|j| (0..3).map(|c| d[c] * f64::from(t[c][j])).sum::<f64>()));
                excess.push(length - radius);
            }
        }
        if !beyond {
            break;
        }
        step(&rows, &excess, &mut total);
    }
    change.iter_mut().zip(total).for_each(|(change, total)| *change = total as f32);
}

/// Adds the δ of least `|A δ − excess|² + λ |δ|²` to the weights. `rows` has A, row by row.
fn step(rows: &[f64], excess: &[f64], weights: &mut [f64]) {
    let (count, m) = (excess.len(), weights.len());
    let a = MatRef::from_column_major_slice(rows, m, count);
    if count <= m {
        // δ = Aᵀ (A Aᵀ + λ)⁻¹ excess.
        let mut gram = product(a.transpose(), a);
        (0..count).for_each(|i| gram[(i, i)] += DAMPING);
        let x = solve(gram, excess.to_vec());
        for (row, x) in rows.chunks(m).zip(x) {
            weights.iter_mut().zip(row).for_each(|(w, a)| *w += a * x);
        }
    } else {
        let mut gram = product(a, a.transpose());
        (0..m).for_each(|i| gram[(i, i)] += DAMPING);
        let mut right = vec![0.0; m];
        for (row, e) in rows.chunks(m).zip(excess) {
            right.iter_mut().zip(row).for_each(|(r, a)| *r += a * e);
        }
        for (w, x) in weights.iter_mut().zip(solve(gram, right)) {
            *w += x;
        }
    }
}

/// The solution of a positive definite system, by Cholesky's method.
pub(super) fn solve(mut l: Mat<f64>, mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len();
    for j in 0..n {
        for k in 0..j {
            let factor = l[(j, k)];
            for i in j..n {
                l[(i, j)] -= l[(i, k)] * factor;
            }
        }
        let diagonal = l[(j, j)].max(f64::MIN_POSITIVE).sqrt();
        for i in j..n {
            l[(i, j)] /= diagonal;
        }
    }
    for i in 0..n {
        for k in 0..i {
            x[i] -= l[(i, k)] * x[k];
        }
        x[i] /= l[(i, i)];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            x[i] -= l[(k, i)] * x[k];
        }
        x[i] /= l[(i, i)];
    }
    x
}
