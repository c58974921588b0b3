//! The weights of all frames, for shapes that were found for some of them.
//!
//! The start is what is known of a frame from the search before, or least squares. If it leaves vertices of a
//! frame beyond the bound, the weights of that frame are moved until all are within it, by the least motion
//! of the other vertices. That is a step of Newton's method for `Σ_v max(0, |r_v| − radius)² + λ |T δ|²`,
//! where r_v is how far vertex v is from its place, and δ the change of the weights. The steps look at the
//! vertices near the bound. All vertices are looked at after some steps. A frame counts as met only if all
//! its vertices are within the bound.

use super::factors::Fit;
use super::frames::{Attribute, Frames};
use super::linear::{eigen, product, solve};
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
const RADIUS: f32 = 0.94;
/// λ.
const DAMPING: f64 = 1e-4;

/// Weights of all frames for some shapes, which may be those of an earlier search.
pub(super) struct Known {
    /// F×n; NaN for frames of which nothing is known. The first column is constant.
    pub weights: Mat<f64>,
    /// n×3V, column by column.
    pub t: Vec<f32>,
    /// 3V: the mean that the positions are relative to.
    pub center: Vec<f32>,
}

/// What is found of some frames.
pub(super) struct Weights {
    /// f×m, for the orthonormal rows of [`Shapes`].
    pub weights: Mat<f64>,
    /// How far the worst vertex of each frame is from its place.
    pub errors: Vec<f64>,
}

/// The shapes of a fit. T's rows but the first are turned to another basis, in which the motions of unit
/// weights are orthonormal.
pub(super) struct Shapes {
    /// m×3V, column by column.
    t: Vec<f32>,
    m: usize,
    /// 3V: what the constant column adds to.
    base: Vec<f32>,
    /// What turns weights of this basis to weights of T, m×(n−1).
    back: Mat<f64>,
    /// The first column of the weights.
    constant: f64,
}

impl Shapes {
    /// Those of a fit. `center` is the mean that its positions are relative to.
    ///
    /// # Errors
    /// As [`eigen`].
    pub(super) fn new(fit: &Fit, center: &[f32]) -> Result<Self> {
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
        Ok(Self { t, m, base, back, constant })
    }

    /// The weights for these shapes, F×m, that come nearest to what `known` has; NaN where it has nothing.
    pub(super) fn carried(&self, known: &Known) -> Mat<f64> {
        let (n, m) = (known.weights.ncols(), self.m);
        let mut between = Mat::<f64>::zeros(n, m);
        let mut offset = vec![0.0; m];
        let columns = known.t.chunks(n).zip(self.t.chunks(m.max(1)));
        for ((from, to), (center, base)) in columns.zip(known.center.iter().zip(&self.base)) {
            for (j, &to) in to.iter().enumerate() {
                let to = f64::from(to);
                offset[j] += to * f64::from(center - base);
                between
                    .col_as_slice_mut(j)
                    .iter_mut()
                    .zip(from)
                    .for_each(|(sum, &t)| *sum += to * f64::from(t));
            }
        }
        let mut carried = product(known.weights.as_ref(), between.as_ref());
        for (j, offset) in offset.into_iter().enumerate() {
            carried.col_as_slice_mut(j).iter_mut().for_each(|weight| *weight += offset);
        }
        carried
    }

    /// Weights of the rows of T, F×n, for weights of the orthonormal ones, F×m.
    pub(super) fn turned_back(&self, weights: &Mat<f64>) -> Mat<f64> {
        let turned = product(weights.as_ref(), self.back.as_ref());
        let n = turned.ncols() + 1;
        Mat::from_fn(turned.nrows(), n, |i, j| if j == 0 { self.constant } else { turned[(i, j - 1)] })
    }

    /// Finds the weights of the frames that are chosen. `start` has weights for all frames of the take, F×m,
    /// to begin with, and NaN where nothing is known.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Io`]; [`rhytid_core::Error::Cancelled`].
    pub(super) fn weights(
        &self,
        frames: &mut Frames,
        chosen: &[usize],
        start: Option<&Mat<f64>>,
        bound: f64,
        progress: &dyn Progress,
    ) -> Result<Weights> {
        const NAME: &str = "fit all frames";
        let (m, numbers, all) = (self.m, self.base.len(), chosen.len());
        let mut weights = Vec::with_capacity(all * m);
        let mut errors = Vec::with_capacity(all);
        let mut values = Vec::new();
        for batch in frames.batches() {
            progress.step(NAME, batch.start as u64, all as u64)?;
            frames.batch(Attribute::Positions, batch.clone(), &mut values)?;
            let groups = values.par_chunks_mut(GROUP * numbers).zip(chosen[batch].par_chunks(GROUP));
            let found: Vec<Group<'_>> = groups
                .map(|(y, frames)| {
                    let mut group = Group::new(self, y, frames, start);
                    group.meet(bound);
                    group
                })
                .collect();
            for group in found {
                weights.extend(group.best);
                errors.extend(group.errors.into_iter().map(f64::from));
            }
        }
        progress.step(NAME, all as u64, all as u64)?;
        Ok(Weights { weights: Mat::from_fn(all, m, |i, j| f64::from(weights[i * m + j])), errors })
    }
}

/// Some frames whose weights are looked for.
struct Group<'a> {
    shapes: &'a Shapes,
    /// What the weights leave of the frames' positions, 3V for each.
    rest: &'a mut [f32],
    /// m for each frame.
    weights: Vec<f32>,
    /// Whether a frame began with weights that were known.
    is_known: Vec<bool>,
    /// The best weights so far, m for each frame.
    best: Vec<f32>,
    /// How far the worst vertex of each frame is from its place with the best weights.
    errors: Vec<f32>,
}

impl<'a> Group<'a> {
    /// The frames with the weights that are known, or least squares. `y` has the frames' positions.
    fn new(shapes: &'a Shapes, y: &'a mut [f32], frames: &[usize], start: Option<&Mat<f64>>) -> Self {
        let m = shapes.m;
        for y in y.chunks_mut(shapes.base.len()) {
            y.iter_mut().zip(&shapes.base).for_each(|(y, base)| *y -= base);
        }
        let of_frame = |frame: usize, j: usize| start.map_or(f64::NAN, |start| start[(frame, j)]) as f32;
        let first = |frame: usize| (0..m).map(move |j| of_frame(frame, j));
        let is_known: Vec<bool> =
            frames.iter().map(|&frame| first(frame).all(f32::is_finite) && start.is_some()).collect();
        let count = frames.len();
        let mut group = Self {
            shapes,
            rest: y,
            weights: vec![0.0; count * m],
            best: vec![0.0; count * m],
            errors: vec![f32::INFINITY; count],
            is_known,
        };
        let (known, unknown): (Vec<usize>, Vec<usize>) = (0..count).partition(|&i| group.is_known[i]);
        let steps: Vec<f32> = known.iter().flat_map(|&i| first(frames[i])).collect();
        group.go(&known, &steps);
        group.least_squares(&unknown);
        group
    }

    /// Brings the frames within the bound, as far as that is found. Where known weights are no good start,
    /// least squares is another one.
    fn meet(&mut self, bound: f64) {
        let count = self.errors.len();
        let open = self.improve((0..count).collect(), bound);
        let again: Vec<usize> = open.into_iter().filter(|&i| self.is_known[i]).collect();
        self.least_squares(&again);
        self.improve(again, bound);
    }

    /// Moves the weights of these frames until all their vertices are within the bound. Returns the frames
    /// that are not.
    fn improve(&mut self, mut open: Vec<usize>, bound: f64) -> Vec<usize> {
        let (m, numbers) = (self.shapes.m, self.shapes.base.len());
        for _ in 0..ROUNDS {
            open.retain(|&i| f64::from(self.errors[i]) > bound);
            let mut steps = vec![0.0_f32; open.len() * m];
            for (&i, step) in open.iter().zip(steps.chunks_mut(m.max(1))) {
                improve(self.shapes, &self.rest[i * numbers..][..numbers], bound, step);
            }
            self.go(&open, &steps);
        }
        open.retain(|&i| f64::from(self.errors[i]) > bound);
        open
    }

    /// Moves the weights of these frames to those of least squares.
    fn least_squares(&mut self, frames: &[usize]) {
        let (m, numbers) = (self.shapes.m, self.shapes.base.len());
        let t = MatRef::from_column_major_slice(&self.shapes.t, m, numbers);
        let mut steps = vec![0.0_f32; frames.len() * m];
        self.with_rests(frames, |rests| {
            let to = MatMut::from_column_major_slice_mut(&mut steps, m, frames.len());
            let rests = MatRef::from_column_major_slice(rests, numbers, frames.len());
            matmul(to, Accum::Replace, t, rests, 1.0, Par::Seq);
        });
        self.go(frames, &steps);
    }

    /// Adds `steps`, m for each of these frames, to their weights.
    fn go(&mut self, frames: &[usize], steps: &[f32]) {
        let (m, numbers) = (self.shapes.m, self.shapes.base.len());
        let t = MatRef::from_column_major_slice(&self.shapes.t, m, numbers);
        self.with_rests(frames, |rests| subtract(t, rests, steps));
        for (&i, step) in frames.iter().zip(steps.chunks(m.max(1))) {
            let weights = &mut self.weights[i * m..][..m];
            weights.iter_mut().zip(step).for_each(|(w, step)| *w += step);
            let error = worst(&self.rest[i * numbers..][..numbers]);
            if error < self.errors[i] {
                self.errors[i] = error;
                self.best[i * m..][..m].copy_from_slice(weights);
            }
        }
    }

    /// Does something with the rests of these frames, which follow each other there.
    fn with_rests(&mut self, frames: &[usize], act: impl FnOnce(&mut [f32])) {
        let numbers = self.shapes.base.len();
        if frames.is_empty() {
            return;
        }
        if frames.len() == self.errors.len() {
            return act(self.rest);
        }
        let mut rests = Vec::with_capacity(frames.len() * numbers);
        frames.iter().for_each(|&i| rests.extend_from_slice(&self.rest[i * numbers..][..numbers]));
        act(&mut rests);
        for (&i, rest) in frames.iter().zip(rests.chunks(numbers)) {
            self.rest[i * numbers..][..numbers].copy_from_slice(rest);
        }
    }
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

/// A change of the weights that brings the vertices near the bound within it, or nearer.
fn improve(shapes: &Shapes, rest: &[f32], bound: f64, change: &mut [f32]) {
    let m = shapes.m;
    let near = (NEAR * bound as f32).powi(2);
    let vectors = rest.as_chunks::<3>().0;
    let active: Vec<usize> = (0..vectors.len()).filter(|&v| square(&vectors[v]) > near).collect();
    // The columns of T of the active vertices, three for each.
    let mut columns: Vec<f32> = Vec::with_capacity(active.len() * 3 * m);
    active.iter().for_each(|&v| columns.extend(&shapes.t[3 * v * m..][..3 * m]));
    let t = MatRef::from_column_major_slice(&columns, m, 3 * active.len());
    let (bound, radius) = (bound as f32, RADIUS * bound as f32);
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
