//! The plan of scans: the frames of a take that, as examples, leave the least uncertainty. It needs markers
//! alone.
use super::confidence::{self, HandlePoses};
use super::vector_strains::VectorStrains;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;
use rhytid_core::numbers::dot;
use rhytid_core::{Error, Progress, Result, Rig, VertexId};
use rhytid_kernels::Real;

/// The number of vertices in the sample.
const SAMPLES: usize = 600;

/// λ for a rig without examples, which has no λ of its own.
const RIDGE: f64 = 1e-2;

/// A frame to scan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedScan {
    /// The frame, an index into the given frames.
    pub frame: usize,
    /// The standard deviation that is left with this scan and those before it, over all frames and vertices.
    ///
    /// It is a part of the standard deviation without any example: 0..1.
    pub left: f64,
    /// The reduction of the variance by this scan at each of [`ScanPlan::vertices`], as a part of the
    /// variance without any example. The mean over the vertices is the reduction as a whole.
    pub gains: Vec<f64>,
}

/// The scans to make, the most useful first.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanPlan {
    /// The vertices of the sample, S of them.
    pub vertices: Vec<VertexId>,
    /// [`PlannedScan::left`] before the first scan: 1 where the rig has no example.
    pub left: f64,
    /// The variance before the first scan at each of the vertices, as a part of that without any example. The
    /// mean over the vertices is `left` squared.
    pub variances: Vec<f64>,
    /// The scans, fewer than asked for if there are no more candidates.
    pub scans: Vec<PlannedScan>,
}

/// The features of the frames at a vertex.
///
/// The kernel `κ(u, u') = Σ_e ω_ve D_e·D'_e` is a product of vectors √ω D, with three numbers for each
/// feature that influences the vertex.
struct OfVertex {
    /// 3·features × frames, divided by √τ, so that the mean variance of the frames is 1.
    frames: Mat<f64>,
    /// The mean products of all pairs of rows of `frames`.
    gram: Mat<f64>,
    /// The part of the identity that the scans so far have left.
    left: Mat<f64>,
    /// λ + n_v/τ.
    noise: f64,
}

/// Chooses `count` of the frames `candidates` for scans, one after the other.
///
/// `frames` are frames × H positions of the handles in the rig's order, and `candidates` are indices into
/// them. Each scan is the candidate that takes most variance from all `frames`:
/// `argmax_j Σ_v Σ_i cov_v(i, j)²/(var_v(j) + λ)`. The rig's examples and the scans before it are given. Of
/// equal candidates, the first is chosen. A candidate that `are_alike` says is like a scan before it is left
/// out; it receives two indices into `frames`.
///
/// Only the handles of the rig's examples count, so a rig without examples works too. All vertices count
/// alike. A few hundred frames are enough, because neighbouring frames are alike.
///
/// # Errors
/// [`Error::Input`] if the rig is not of the learned method; [`Error::Cancelled`].
pub fn plan_scans<T: Real>(
    rig: &Rig<T>,
    frames: &[[f64; 3]],
    candidates: &[usize],
    count: usize,
    are_alike: &dyn Fn(usize, usize) -> bool,
    progress: &dyn Progress,
) -> Result<ScanPlan> {
    let Some(learned) = rig.learned() else {
        return Err(Error::rig_lacks(
            "scans are planned by the influences of the learned method, which this rig does not have; solve \
             it again with method = \"learned\"",
        ));
    };
    let vertices = confidence::sample(rig, SAMPLES);
    let poses = HandlePoses::from_rig(rig);
    let (examples, frames) = (poses.strains(rig.examples().handles.as_slice()), poses.strains(frames));
    let ridge = if rig.examples().is_empty() { RIDGE } else { learned.ridge };
    progress.step("plan", 0, count as u64)?;
    let mut of_vertices: Vec<OfVertex> = vertices
        .par_iter()
        .map(|&v| {
            let influences = confidence::influences(rig, v.index());
            let columns = |strains: &VectorStrains| {
                Mat::from_fn(3 * influences.len(), strains.examples(), |i, pose| {
                    let (e, w) = influences[i / 3];
                    w.sqrt() * strains.feature(e)[3 * pose + i % 3]
                })
            };
            let noise: f64 = influences.iter().map(|&(e, w)| w * frames.noise(e)).sum();
            OfVertex::new(columns(&frames), columns(&examples), ridge, learned.marker_noise.powi(2) * noise)
        })
        .collect();
    let variance = |of_vertices: &[OfVertex]| {
        of_vertices.iter().map(OfVertex::variance).sum::<f64>() / of_vertices.len().max(1) as f64
    };
    let mut plan = ScanPlan {
        vertices,
        left: variance(&of_vertices).sqrt(),
        variances: of_vertices.iter().map(OfVertex::variance).collect(),
        scans: Vec::new(),
    };
    let mut open = candidates.to_vec();
    while plan.scans.len() < count {
        progress.step("plan", plan.scans.len() as u64, count as u64)?;
        let gains: Vec<Vec<f64>> = of_vertices.par_iter().map(|of_vertex| of_vertex.gains(&open)).collect();
        let total = |i: usize| gains.iter().map(|of_vertex| of_vertex[i]).sum::<f64>();
        let best = (0..open.len()).map(|i| (i, total(i))).reduce(|a, b| if b.1 > a.1 { b } else { a });
        let Some((i, _)) = best else { break };
        let frame = open.remove(i);
        open.retain(|other| !are_alike(frame, *other));
        of_vertices.par_iter_mut().for_each(|of_vertex| {
            let OfVertex { frames, left, noise, .. } = of_vertex;
            scan(left, frames.col_as_slice(frame), *noise);
        });
        let gains = gains.iter().map(|of_vertex| of_vertex[i]).collect();
        plan.scans.push(PlannedScan { frame, left: variance(&of_vertices).sqrt(), gains });
    }
    progress.step("plan", count as u64, count as u64)?;
    Ok(plan)
}

impl OfVertex {
    /// The data of a vertex, from the frames' and examples' columns.
    fn new(mut frames: Mat<f64>, mut examples: Mat<f64>, ridge: f64, noise: f64) -> Self {
        let features = frames.nrows();
        let count = frames.ncols().max(1) as f64;
        let tau = frames.squared_norm_l2() / count;
        let mut of_vertex = Self {
            gram: Mat::zeros(features, features),
            left: Mat::identity(features, features),
            // Where nothing moves, scans say nothing.
            noise: if tau > 0.0 { ridge + noise / tau } else { 1.0 },
            frames: Mat::new(),
        };
        if tau > 0.0 {
            for columns in [&mut frames, &mut examples] {
                *columns *= faer::Scale(1.0 / tau.sqrt());
            }
        }
        product(&mut of_vertex.gram, frames.as_ref(), frames.transpose(), 1.0 / count);
        of_vertex.frames = frames;
        for example in 0..examples.ncols() {
            scan(&mut of_vertex.left, examples.col_as_slice(example), of_vertex.noise);
        }
        of_vertex
    }

    /// The mean variance of the frames.
    fn variance(&self) -> f64 {
        let size = self.left.nrows();
        let columns = (0..size).map(|i| dot(self.left.col_as_slice(i), self.gram.col_as_slice(i)));
        columns.sum()
    }

    /// The reduction of the mean variance by a scan of each of the frames `open`.
    fn gains(&self, open: &[usize]) -> Vec<f64> {
        let size = self.left.nrows();
        let (mut half, mut whole) = (Mat::zeros(size, size), Mat::zeros(size, size));
        product(&mut half, self.left.as_ref(), self.gram.as_ref(), 1.0);
        product(&mut whole, half.as_ref(), self.left.as_ref(), 1.0);
        let asked = Mat::from_fn(size, open.len(), |i, j| self.frames[(i, open[j])]);
        let (mut taken, mut own) = (Mat::zeros(size, open.len()), Mat::zeros(size, open.len()));
        product(&mut taken, whole.as_ref(), asked.as_ref(), 1.0);
        product(&mut own, self.left.as_ref(), asked.as_ref(), 1.0);
        let gain = |j: usize| {
            let frame = asked.col_as_slice(j);
            dot(frame, taken.col_as_slice(j)) / (dot(frame, own.col_as_slice(j)) + self.noise)
        };
        (0..open.len()).map(gain).collect()
    }
}

/// Subtracts the variance that a scan of `frame` explains from `left`.
fn scan(left: &mut Mat<f64>, frame: &[f64], noise: f64) {
    // `left` is symmetric.
    let told: Vec<f64> = (0..frame.len()).map(|i| dot(left.col_as_slice(i), frame)).collect();
    let variance = dot(&told, frame) + noise;
    for (j, column) in told.iter().enumerate() {
        for (left, row) in left.col_as_slice_mut(j).iter_mut().zip(&told) {
            *left -= row * column / variance;
        }
    }
}

/// `to = scale · a b`, on this thread.
fn product(to: &mut Mat<f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, scale: f64) {
    matmul(to.as_mut(), Accum::Replace, a, b, scale, Par::Seq);
}
