//! The weights of all frames, for shapes that were found for some of them.
//!
//! The start is what is known of a frame from the search before, or least squares. If it leaves vertices of a
//! frame beyond the bound, [`super::steps`] moves the weights of that frame. The steps look at some vertices
//! only: the hard ones, which the search had to pull, and those that were found beyond the bound since. After
//! the steps, all vertices are looked at. If further ones are beyond the bound, they join the hard ones, and
//! there are more steps. A frame counts as met only if all its vertices are within the bound.

use super::factors::Fit;
use super::frames::{Attribute, Frames};
use super::linear::{eigen, product};
use super::steps::{Hard, square, subtract, worst};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use rhytid_core::{Progress, Result};

/// Frames that a thread works on at once.
const GROUP: usize = 32;
/// How many times all vertices of a frame are looked at.
const LOOKS: usize = 6;

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
    /// The vertices that the fit had to pull, in ascending order.
    pulled: Vec<usize>,
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
        let is_pulled = |&v: &usize| !fit.multipliers[v].is_empty();
        let pulled = (0..fit.multipliers.len()).filter(is_pulled).collect();
        Ok(Self { t, m, base, back, constant, pulled })
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
        let mut hard = self.hard(self.pulled.clone());
        for batch in frames.batches() {
            progress.step(NAME, batch.start as u64, all as u64)?;
            frames.batch(Attribute::Positions, batch.clone(), &mut values)?;
            let groups = values.par_chunks_mut(GROUP * numbers).zip(chosen[batch].par_chunks(GROUP));
            let found: Vec<Group<'_>> = groups
                .map(|(y, frames)| {
                    let mut group = Group::new(self, y, frames, start);
                    group.meet(&hard, bound);
                    group
                })
                .collect();
            let mut further = Vec::new();
            for group in found {
                weights.extend(group.best);
                errors.extend(group.errors.into_iter().map(f64::from));
                further.extend(group.further);
            }
            if !further.is_empty() {
                hard = self.hard(union(&hard.vertices, &further));
            }
        }
        log::debug!("{} of {} vertices are hard", hard.vertices.len(), numbers / 3);
        progress.step(NAME, all as u64, all as u64)?;
        Ok(Weights { weights: Mat::from_fn(all, m, |i, j| f64::from(weights[i * m + j])), errors })
    }

    /// These vertices with their shapes.
    fn hard(&self, vertices: Vec<usize>) -> Hard {
        Hard::new(vertices, &self.t, self.m)
    }

    /// T, m×3V.
    fn t(&self) -> MatRef<'_, f32> {
        MatRef::from_column_major_slice(&self.t, self.m, self.base.len())
    }
}

/// All numbers of both, in ascending order.
fn union(a: &[usize], b: &[usize]) -> Vec<usize> {
    let mut both = [a, b].concat();
    both.sort_unstable();
    both.dedup();
    both
}

/// Some frames whose weights are looked for.
struct Group<'a> {
    shapes: &'a Shapes,
    /// What the weights leave of the frames' positions, 3V for each.
    rest: &'a mut [f32],
    /// m for each frame.
    weights: Vec<f32>,
    /// What is known of the weights, m for each frame that begins with it.
    known: Vec<Option<Vec<f32>>>,
    /// The best weights so far, m for each frame.
    best: Vec<f32>,
    /// How far the worst vertex of each frame is from its place with the best weights.
    errors: Vec<f32>,
    /// Vertices that were found beyond the bound and are not among the hard ones.
    further: Vec<usize>,
}

impl<'a> Group<'a> {
    /// The frames with no weights. `y` has their positions.
    fn new(shapes: &'a Shapes, y: &'a mut [f32], frames: &[usize], start: Option<&Mat<f64>>) -> Self {
        let m = shapes.m;
        for y in y.chunks_mut(shapes.base.len()) {
            y.iter_mut().zip(&shapes.base).for_each(|(y, base)| *y -= base);
        }
        let known = |&frame: &usize| {
            let known: Vec<f32> =
                (0..m).map(|j| start.map_or(f64::NAN, |start| start[(frame, j)]) as f32).collect();
            (start.is_some() && known.iter().all(|w| w.is_finite())).then_some(known)
        };
        let count = frames.len();
        Self {
            shapes,
            rest: y,
            weights: vec![0.0; count * m],
            known: frames.iter().map(known).collect(),
            best: vec![0.0; count * m],
            errors: vec![f32::INFINITY; count],
            further: Vec::new(),
        }
    }

    /// Brings the frames within the bound, as far as that is found. It begins with the weights that are
    /// known, or with least squares. Where known weights are no good start, least squares is another one.
    fn meet(&mut self, hard: &Hard, bound: f64) {
        let m = self.shapes.m;
        let (known, unknown): (Vec<usize>, Vec<usize>) =
            (0..self.errors.len()).partition(|&i| self.known[i].is_some());
        let steps = known.iter().flat_map(|&i| self.known[i].clone().unwrap_or_default()).collect();
        let again = self.go_on(known, steps, hard, bound);
        for frames in [unknown, again] {
            let mut steps = vec![0.0_f32; frames.len() * m];
            let t = self.shapes.t();
            self.with_rests(&frames, |rests| {
                let to = MatMut::from_column_major_slice_mut(&mut steps, m, frames.len());
                let rests = MatRef::from_column_major_slice(rests, t.ncols(), frames.len());
                matmul(to, Accum::Replace, t, rests, 1.0, Par::Seq);
            });
            self.go_on(frames, steps, hard, bound);
        }
    }

    /// Moves the weights of these frames by `steps`, m for each, and on until all their vertices are within
    /// the bound. Returns the frames that are not.
    fn go_on(&mut self, frames: Vec<usize>, mut steps: Vec<f32>, hard: &Hard, bound: f64) -> Vec<usize> {
        let m = self.shapes.m;
        let mut open = frames.clone();
        let mut own = None;
        for _ in 0..LOOKS {
            let hard = own.as_ref().unwrap_or(hard);
            let of_hard = self.improve(&open, &mut steps, hard, bound);
            self.go(&open, &steps);
            // Where not even the hard vertices come within the bound, no further ones are looked for.
            let is_met = |error: f32| f64::from(error) <= bound;
            let met = open.into_iter().zip(of_hard).filter(|(_, error)| is_met(*error));
            open = met.map(|(i, _)| i).filter(|&i| !is_met(self.errors[i])).collect();
            let further = self.further(&open, hard, bound);
            if further.is_empty() {
                break;
            }
            steps = vec![0.0; open.len() * m];
            own = Some(self.shapes.hard(union(&hard.vertices, &further)));
            self.further.extend(further);
        }
        frames.into_iter().filter(|&i| f64::from(self.errors[i]) > bound).collect()
    }

    /// Moves `steps`, m for each of these frames, until all hard vertices are within the bound, or nearer to
    /// it. Returns how far the worst hard vertex of each frame is from its place.
    fn improve(&self, frames: &[usize], steps: &mut [f32], hard: &Hard, bound: f64) -> Vec<f32> {
        let numbers = self.shapes.base.len();
        let mut rests = Vec::with_capacity(frames.len() * 3 * hard.vertices.len());
        for &i in frames {
            let rest = self.rest[i * numbers..][..numbers].as_chunks::<3>().0;
            hard.vertices.iter().for_each(|&v| rests.extend_from_slice(&rest[v]));
        }
        hard.improve(frames.len(), rests, steps, bound)
    }

    /// The vertices that are beyond the bound in one of these frames and not hard, in ascending order.
    fn further(&self, frames: &[usize], hard: &Hard, bound: f64) -> Vec<usize> {
        let numbers = self.shapes.base.len();
        let most = (bound as f32).powi(2);
        let mut is_found = vec![false; numbers / 3];
        for &i in frames {
            let rest = self.rest[i * numbers..][..numbers].as_chunks::<3>().0;
            is_found.iter_mut().zip(rest).for_each(|(found, r)| *found |= square(r) > most);
        }
        hard.vertices.iter().for_each(|&v| is_found[v] = false);
        (0..is_found.len()).filter(|&v| is_found[v]).collect()
    }

    /// Adds `steps`, m for each of these frames, to their weights.
    fn go(&mut self, frames: &[usize], steps: &[f32]) {
        let (m, numbers) = (self.shapes.m, self.shapes.base.len());
        let t = self.shapes.t();
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
