//! A low-rank model of a take's own motion: probabilistic principal components (Tipping and Bishop, 1999).
//! The model is trained on the frames with their gaps. Missing values are imputed until they no longer
//! change.
use crate::tracks::{Tracks, seen};
use faer::{
    Mat, Side,
    linalg::solvers::{Llt, Solve},
};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rhytid_core::numbers::dot;

/// `x = mean + W c + noise`, with as many independent `c` of variance 1 as W has columns.
pub(crate) struct Model {
    mean: Vec<f64>,
    /// W: 3M × rank, row by row.
    weights: Vec<f64>,
    /// Wᵀ W, of which the lower half is used: rank × rank, row by row.
    gram: Vec<f64>,
    rank: usize,
    /// The noise's variance per coordinate.
    noise: f64,
}

/// How much is learned from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Frames that are learned from.
    pub frames: usize,
    /// Iterations at the most.
    pub iterations: usize,
}

/// A take with a handful of gaps needs a dozen iterations. A take that lacks a marker for a third of its
/// length needs a hundred.
pub(crate) const WHOLE: Effort = Effort { frames: 4000, iterations: 200 };

const LARGEST_RANK: usize = 40;

impl Model {
    /// Learns from frames of positions or displacements with at most this `effort`. `noise` is the least
    /// standard deviation per coordinate. `None` where there is nothing to learn from.
    pub(crate) fn learn(tracks: &Tracks, noise: f64, effort: Effort) -> Option<Self> {
        let frames = tracks.frames();
        // Of each short stretch the fullest frame.
        let stretch = frames.div_ceil(effort.frames).max(1);
        let seen_in = |f: usize| tracks.columns.iter().filter(|c| seen(c[f])).count();
        let sampled: Vec<usize> = (0..frames)
            .step_by(stretch)
            .filter_map(|start| {
                let fullest = (start..(start + stretch).min(frames))
                    .max_by_key(|&f| (seen_in(f), std::cmp::Reverse(f)))?;
                (seen_in(fullest) > 0).then_some(fullest)
            })
            .collect();
        let n = sampled.len();
        let dimensions = 3 * tracks.columns.len();
        let rank = LARGEST_RANK.min(dimensions / 2).min(n / 4);
        if rank == 0 {
            return None;
        }
        let known: Vec<Vec<f64>> = sampled.iter().map(|&f| frame(tracks, f)).collect();
        let mut data = interpolated(&known);
        let mut model = None;
        for _ in 0..effort.iterations {
            let fitted = Self::fit(&data, dimensions, rank, noise)?;
            let changes: Vec<f64> = data
                .par_iter_mut()
                .zip(&known)
                .filter(|(_, known)| known.iter().any(|x| x.is_nan()))
                .map(|(data, known)| {
                    let (mut worst, guess) = (0.0_f64, fitted.complete(known));
                    for ((x, known), guess) in data.iter_mut().zip(known).zip(guess) {
                        if known.is_nan() {
                            worst = worst.max((*x - guess).abs());
                            *x = guess;
                        }
                    }
                    worst
                })
                .collect();
            model = Some(fitted);
            if changes.into_iter().fold(0.0, f64::max) < 0.1 * noise {
                break;
            }
        }
        model
    }

    /// The principal components of complete frames.
    fn fit(data: &[Vec<f64>], dimensions: usize, rank: usize, noise: f64) -> Option<Self> {
        let n = data.len() as f64;
        let mean: Vec<f64> = (0..dimensions).map(|i| data.iter().map(|x| x[i]).sum::<f64>() / n).collect();
        let centred = Mat::from_fn(data.len(), dimensions, |f, i| data[f][i] - mean[i]);
        let covariance = centred.transpose() * &centred;
        let eigen = covariance.self_adjoint_eigen(Side::Lower).ok()?;
        let (values, vectors) = (eigen.S(), eigen.U());
        let variance = |k: usize| (values[dimensions - 1 - k] / n).max(0.0);
        let rest: f64 = (rank..dimensions).map(variance).sum();
        let noise = (rest / (dimensions - rank) as f64).max(noise * noise).max(f64::MIN_POSITIVE);
        let scale: Vec<f64> = (0..rank).map(|k| (variance(k) - noise).max(0.0).sqrt()).collect();
        let weights: Vec<f64> = (0..dimensions)
            .flat_map(|i| (0..rank).map(move |k| (i, k)))
            .map(|(i, k)| vectors[(i, dimensions - 1 - k)] * scale[k])
            .collect();
        let mut gram = vec![0.0; rank * rank];
        weights.chunks(rank).for_each(|row| add_square(&mut gram, row, 1.0));
        Some(Self { mean, weights, gram, rank, noise })
    }

    /// The expected frame (3M numbers), given those of its numbers that are not NaN.
    pub(crate) fn complete(&self, frame: &[f64]) -> Vec<f64> {
        let rank = self.rank;
        let row = |i: usize| &self.weights[i * rank..(i + 1) * rank];
        let known = |i: &usize| !frame[*i].is_nan();
        let missing = frame.iter().filter(|x| x.is_nan()).count();
        let mut right = vec![0.0; rank];
        for i in (0..frame.len()).filter(known) {
            let off = frame[i] - self.mean[i];
            right.iter_mut().zip(row(i)).for_each(|(right, w)| *right += w * off);
        }
        // WᵀW over the known rows. If fewer rows are missing than known, the missing ones are subtracted from
        // the whole.
        let precision = if 2 * missing < frame.len() {
            let mut precision = self.gram.clone();
            (0..frame.len()).filter(|i| !known(i)).for_each(|i| add_square(&mut precision, row(i), -1.0));
            precision
        } else {
            let mut precision = vec![0.0; rank * rank];
            (0..frame.len()).filter(known).for_each(|i| add_square(&mut precision, row(i), 1.0));
            precision
        };
        let matrix = Mat::from_fn(rank, rank, |k, l| {
            precision[k.max(l) * rank + k.min(l)] + if k == l { self.noise } else { 0.0 }
        });
        let right = Mat::from_fn(rank, 1, |k, _| right[k]);
        let coefficients = match Llt::new(matrix.as_ref(), Side::Lower) {
            Ok(factor) => factor.solve(&right),
            Err(_) => Mat::zeros(rank, 1),
        };
        let mean = self.mean.iter().enumerate();
        mean.map(|(i, mean)| {
            mean + row(i).iter().enumerate().map(|(k, w)| w * coefficients[(k, 0)]).sum::<f64>()
        })
        .collect()
    }

    /// The expected positions in one frame of `tracks`.
    pub(crate) fn frame(&self, tracks: &Tracks, f: usize) -> Vec<DVec3> {
        self.complete(&frame(tracks, f)).as_chunks().0.iter().copied().map(DVec3::from_array).collect()
    }

    /// The expected position of one marker as if it had not been seen in frame `f`.
    pub(crate) fn without(&self, tracks: &Tracks, f: usize, marker: usize) -> DVec3 {
        let mut frame = frame(tracks, f);
        frame[3 * marker..3 * marker + 3].fill(f64::NAN);
        DVec3::from_slice(&self.complete(&frame)[3 * marker..])
    }
}

/// How far each marker of a frame is from where all the others put it.
///
/// Let `x ~ N(mean, C)` with `C = W Wᵀ + σ² I`. Marker j differs from its expectation given all other markers
/// by `(C⁻¹)ⱼⱼ⁻¹ (C⁻¹ (x − mean))ⱼ`. With `G = (σ² I + Wᵀ W)⁻¹`, `σ² C⁻¹ = I − W G Wᵀ`.
pub(crate) struct LeaveOneOut<'a> {
    model: &'a Model,
    /// G: rank × rank, row by row.
    inverse: Vec<f64>,
    /// `(I − Wⱼ G Wⱼᵀ)⁻¹` of each marker.
    blocks: Vec<DMat3>,
}

impl<'a> LeaveOneOut<'a> {
    pub(crate) fn new(model: &'a Model) -> Self {
        let rank = model.rank;
        let gram = Mat::from_fn(rank, rank, |k, l| {
            model.gram[k.max(l) * rank + k.min(l)] + if k == l { model.noise } else { 0.0 }
        });
        let inverse = match Llt::new(gram.as_ref(), Side::Lower) {
            Ok(factor) => factor.solve(Mat::<f64>::identity(rank, rank)),
            Err(_) => Mat::zeros(rank, rank),
        };
        let inverse: Vec<f64> = (0..rank * rank).map(|i| inverse[(i / rank, i % rank)]).collect();
        let row = |i: usize| &model.weights[i * rank..(i + 1) * rank];
        let block = |j: usize| {
            let through = [0, 1, 2].map(|c| times(&inverse, row(3 * j + c)));
            let entry = |a: usize, b: usize| f64::from(u8::from(a == b)) - dot(row(3 * j + a), &through[b]);
            DMat3::from_cols_array_2d(&[0, 1, 2].map(|b| [0, 1, 2].map(|a| entry(a, b)))).inverse()
        };
        let blocks = (0..model.mean.len() / 3).map(block).collect();
        Self { model, inverse, blocks }
    }

    /// The error of each marker in frame `f`; NaN for markers that are not seen there.
    pub(crate) fn errors(&self, tracks: &Tracks, f: usize) -> Vec<DVec3> {
        let (model, rank) = (self.model, self.model.rank);
        let known = frame(tracks, f);
        let whole = if known.iter().any(|x| x.is_nan()) { model.complete(&known) } else { known.clone() };
        let off: Vec<f64> = whole.iter().zip(&model.mean).map(|(x, mean)| x - mean).collect();
        let mut right = vec![0.0; rank];
        for (x, row) in off.iter().zip(model.weights.chunks(rank)) {
            right.iter_mut().zip(row).for_each(|(right, w)| *right += w * x);
        }
        let coefficients = times(&self.inverse, &right);
        let left: Vec<f64> =
            off.iter().zip(model.weights.chunks(rank)).map(|(x, row)| x - dot(row, &coefficients)).collect();
        let errors = left.as_chunks::<3>().0.iter().zip(&self.blocks);
        errors
            .zip(known.as_chunks::<3>().0)
            .map(
                |((left, block), known)| {
                    if known[0].is_nan() { DVec3::NAN } else { *block * DVec3::from_array(*left) }
                },
            )
            .collect()
    }
}

/// A square matrix, row by row, times a vector.
fn times(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    matrix.chunks(vector.len()).map(|row| dot(row, vector)).collect()
}

/// Adds `sign` times the lower half of `row`ᵀ `row`.
fn add_square(to: &mut [f64], row: &[f64], sign: f64) {
    for (k, wk) in row.iter().enumerate() {
        let line = &mut to[k * row.len()..k * row.len() + k + 1];
        line.iter_mut().zip(row).for_each(|(to, wl)| *to += sign * wk * wl);
    }
}

fn frame(tracks: &Tracks, f: usize) -> Vec<f64> {
    tracks.columns.iter().flat_map(|column| column[f].to_array()).collect()
}

/// Replaces each NaN by linear interpolation between its neighbours in time; 0 where a number is never known.
fn interpolated(frames: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut out = frames.to_vec();
    for i in 0..frames.first().map_or(0, Vec::len) {
        let known: Vec<usize> = (0..frames.len()).filter(|&f| !frames[f][i].is_nan()).collect();
        for (f, frame) in out.iter_mut().enumerate().filter(|(f, _)| frames[*f][i].is_nan()) {
            let at = known.partition_point(|&k| k < f);
            frame[i] = match (at.checked_sub(1).map(|a| known[a]), known.get(at)) {
                (Some(a), Some(&b)) => {
                    let s = (f - a) as f64 / (b - a) as f64;
                    frames[a][i] + s * (frames[b][i] - frames[a][i])
                }
                (Some(k), None) => frames[k][i],
                (None, Some(&k)) => frames[k][i],
                (None, None) => 0.0,
            };
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_take_of_low_rank_is_completed() {
        // Three motions of ten markers.
        let wave = |f: usize, k: usize| (f as f64 * [0.05, 0.13, 0.031][k]).sin() / (k + 1) as f64;
        let shape = |j: usize, c: usize, k: usize| ((j * 7 + c * 3 + k * 5) as f64).sin();
        let at = |j: usize, f: usize| {
            DVec3::from_array(std::array::from_fn(|c| (0..3).map(|k| wave(f, k) * shape(j, c, k)).sum()))
        };
        let truth: Vec<Vec<DVec3>> = (0..10).map(|j| (0..800).map(|f| at(j, f)).collect()).collect();
        let mut tracks = Tracks { columns: truth.clone(), rate: 120.0 };
        for j in 0..10 {
            tracks.columns[j][60 * j + 20..60 * j + 120].fill(DVec3::NAN);
        }
        let model = Model::learn(&tracks, 1e-4, WHOLE).unwrap();
        for f in (0..800).step_by(7) {
            for (j, found) in model.frame(&tracks, f).into_iter().enumerate() {
                assert!(found.distance(truth[j][f]) < 5e-3, "{j} {f} {}", found.distance(truth[j][f]));
            }
        }
    }

    #[test]
    fn each_marker_is_left_out_at_once() {
        let wave = |f: usize, k: usize| (f as f64 * [0.05, 0.13, 0.031][k]).sin() / (k + 1) as f64;
        let at = |j: usize, f: usize| {
            let shape = |c: usize| (0..3).map(|k| wave(f, k) * ((j * 7 + c * 3 + k * 5) as f64).sin()).sum();
            DVec3::from_array([0, 1, 2].map(shape)) + 0.05 * ((f * 13 + j * 5) as f64).sin()
        };
        let columns = (0..10).map(|j| (0..800).map(|f| at(j, f)).collect()).collect();
        let mut tracks = Tracks { columns, rate: 120.0 };
        tracks.columns[3][40] = DVec3::NAN;
        let model = Model::learn(&tracks, 1e-2, WHOLE).unwrap();
        let alone = LeaveOneOut::new(&model);
        for f in [0, 17, 400] {
            for (j, off) in alone.errors(&tracks, f).into_iter().enumerate() {
                let expected = tracks.columns[j][f] - model.without(&tracks, f, j);
                assert!(off.distance(expected) < 1e-9, "{j} {f}: {off} {expected}");
            }
        }
        assert!(alone.errors(&tracks, 40)[3].is_nan());
    }

    #[test]
    fn nothing_to_learn_from() {
        assert!(
            Model::learn(&Tracks { columns: vec![vec![DVec3::NAN; 9]; 5], rate: 30.0 }, 0.1, WHOLE).is_none()
        );
        assert!(
            Model::learn(&Tracks { columns: vec![vec![DVec3::ONE; 3]; 5], rate: 30.0 }, 0.1, WHOLE).is_none()
        );
    }
}
