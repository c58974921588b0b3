//! Steps that bring a frame's hardest vertices within the bound, by the least motion of the other vertices.
//!
//! A step is one of Newton's method for `Σ_v max(0, |r_v| − radius)² + λ |T δ|²`. r_v is how far vertex v is
//! from its place, and δ the change of the weights. The motions of unit weights are orthonormal.

use super::linear::{product, solve};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// How many times the vertices near the bound are chosen anew.
const ROUNDS: usize = 6;
/// Steps between two such choices.
const STEPS: usize = 8;
/// Vertices with an error above this part of the bound take part in the steps.
const NEAR: f32 = 0.7;
/// Vertices are moved to this part of the bound.
const RADIUS: f32 = 0.94;
/// λ.
const DAMPING: f64 = 1e-4;

/// The vertices that the steps look at. Most vertices are far within the bound in all frames.
pub(super) struct Hard {
    /// In ascending order.
    pub vertices: Vec<usize>,
    /// Their columns of T, m×3h.
    t: Vec<f32>,
    m: usize,
}

impl Hard {
    /// These vertices, in ascending order, of the shapes `t`, m×3V.
    pub(super) fn new(vertices: Vec<usize>, t: &[f32], m: usize) -> Self {
        let t = vertices.iter().flat_map(|&v| &t[3 * v * m..][..3 * m]).copied().collect();
        Self { vertices, t, m }
    }

    /// Moves `steps`, m for each of `count` frames, until all hard vertices are within the bound, or nearer
    /// to it. `rests` has what is left of the frames without these steps, 3h for each. Returns how far the
    /// worst hard vertex of each frame is from its place.
    pub(super) fn improve(
        &self,
        count: usize,
        mut rests: Vec<f32>,
        steps: &mut [f32],
        bound: f64,
    ) -> Vec<f32> {
        let (m, numbers) = (self.m, 3 * self.vertices.len());
        if numbers == 0 {
            return vec![0.0; count];
        }
        let t = MatRef::from_column_major_slice(&self.t, m, numbers);
        subtract(t, &mut rests, steps);
        let mut errors: Vec<f32> = rests.chunks(numbers).map(worst).collect();
        let mut now = steps.to_vec();
        let mut open: Vec<usize> = (0..errors.len()).collect();
        for _ in 0..ROUNDS {
            // The rests of the frames that are left follow each other.
            let is_open: Vec<bool> = open.iter().map(|&i| f64::from(errors[i]) > bound).collect();
            let mut left = 0;
            for (place, _) in is_open.iter().enumerate().filter(|(_, is_open)| **is_open) {
                rests.copy_within(place * numbers..(place + 1) * numbers, left * numbers);
                open[left] = open[place];
                left += 1;
            }
            open.truncate(left);
            rests.truncate(left * numbers);
            let mut changes = vec![0.0_f32; left * m];
            for (rest, change) in rests.chunks(numbers).zip(changes.chunks_mut(m.max(1))) {
                improve(&self.t, rest, bound as f32, change);
            }
            subtract(t, &mut rests, &changes);
            for ((&i, rest), change) in open.iter().zip(rests.chunks(numbers)).zip(changes.chunks(m.max(1))) {
                let now = &mut now[i * m..][..m];
                now.iter_mut().zip(change).for_each(|(now, change)| *now += change);
                let error = worst(rest);
                if error < errors[i] {
                    errors[i] = error;
                    steps[i * m..][..m].copy_from_slice(now);
                }
            }
        }
        errors
    }
}

/// `rest −= Tᵀ weights`.
pub(super) fn subtract(t: MatRef<'_, f32>, rest: &mut [f32], weights: &[f32]) {
    let (m, numbers) = (t.nrows(), t.ncols());
    if m == 0 || numbers == 0 {
        return;
    }
    let count = rest.len() / numbers;
    let weights = MatRef::from_column_major_slice(weights, m, count);
    let rest = MatMut::from_column_major_slice_mut(rest, numbers, count);
    matmul(rest, Accum::Add, t.transpose(), weights, -1.0, Par::Seq);
}

/// The squared length.
pub(super) fn square(r: &[f32; 3]) -> f32 {
    r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
}

/// The length of the longest vector.
pub(super) fn worst(rest: &[f32]) -> f32 {
    // Several maxima, so that none waits for another one.
    let mut most = [0.0_f32; 16];
    let (groups, others) = rest.as_chunks::<48>();
    for group in groups {
        for (most, r) in most.iter_mut().zip(group.as_chunks::<3>().0) {
            *most = most.max(square(r));
        }
    }
    let others = others.as_chunks::<3>().0.iter().map(square);
    most.into_iter().chain(others).fold(0.0, f32::max).sqrt()
}

/// A change of the weights that brings the vertices near the bound within it, or nearer. `t` is m×3h.
fn improve(t: &[f32], rest: &[f32], bound: f32, change: &mut [f32]) {
    let m = change.len();
    let (near, radius) = ((NEAR * bound).powi(2), RADIUS * bound);
    let vectors = rest.as_chunks::<3>().0;
    let active: Vec<usize> = (0..vectors.len()).filter(|&v| square(&vectors[v]) > near).collect();
    // The columns of T of the active vertices, three for each.
    let mut columns: Vec<f32> = Vec::with_capacity(active.len() * 3 * m);
    active.iter().for_each(|&v| columns.extend(&t[3 * v * m..][..3 * m]));
    let t = MatRef::from_column_major_slice(&columns, m, 3 * active.len());
    let mut moved = vec![0.0_f32; 3 * active.len()];
    let (mut rows, mut excess): (Vec<f32>, Vec<f32>) = (Vec::new(), Vec::new());
    for _ in 0..STEPS {
        rows.clear();
        excess.clear();
        let mut beyond = false;
        let places = active.iter().zip(moved.as_chunks::<3>().0).zip(columns.chunks(3 * m));
        for ((&v, moved), columns) in places {
            let at: [f32; 3] = std::array::from_fn(|c| vectors[v][c] - moved[c]);
            let length = square(&at).sqrt();
            if length > radius {
                beyond |= length > bound;
                let d = at.map(|x| x / length);
                let (x, others) = columns.split_at(m);
                let (y, z) = others.split_at(m);
                rows.extend(x.iter().zip(y).zip(z).map(|((x, y), z)| d[0] * x + d[1] * y + d[2] * z));
                excess.push(length - radius);
            }
        }
        if !beyond {
            break;
        }
        step(&rows, &excess, change);
        let to = MatMut::from_column_major_slice_mut(&mut moved, 3 * active.len(), 1);
        let change = MatRef::from_column_major_slice(change, m, 1);
        matmul(to, Accum::Replace, t.transpose(), change, 1.0, Par::Seq);
    }
}

/// Adds the δ of least `|A δ − excess|² + λ |δ|²` to the weights. `rows` has A, row by row.
fn step(rows: &[f32], excess: &[f32], weights: &mut [f32]) {
    let (count, m) = (excess.len(), weights.len());
    let a = MatRef::from_column_major_slice(rows, m, count);
    let damped = |gram: Mat<f32>| {
        let n = gram.nrows();
        Mat::from_fn(n, n, |i, j| f64::from(gram[(i, j)]) + if i == j { DAMPING } else { 0.0 })
    };
    if count <= m {
        // δ = Aᵀ (A Aᵀ + λ)⁻¹ excess.
        let excess = excess.iter().copied().map(f64::from).collect();
        let x = solve(&damped(product(a.transpose(), a)), excess);
        for (row, x) in rows.chunks(m).zip(x) {
            weights.iter_mut().zip(row).for_each(|(w, a)| *w += a * x as f32);
        }
    } else {
        let mut right = vec![0.0; m];
        for (row, &e) in rows.chunks(m).zip(excess) {
            right.iter_mut().zip(row).for_each(|(r, a)| *r += f64::from(a * e));
        }
        let x = solve(&damped(product(a, a.transpose())), right);
        weights.iter_mut().zip(x).for_each(|(w, x)| *w += x as f32);
    }
}
