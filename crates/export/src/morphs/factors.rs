//! The factors of frames, Q and T, and what is computed with them in float32.

use super::frames::{Attribute, Frames, Gram, TASK};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use glam::Vec3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::Result;

/// A factorisation `Y ≈ Q T`.
#[derive(Clone)]
pub(super) struct Fit {
    /// F×n, orthonormal, the first column constant. The further behind a column is, the less it explains.
    pub q: Mat<f64>,
    /// Column-major n×3V.
    pub t: Vec<f32>,
    /// For each vertex, the multipliers that are not zero, in the order of frames.
    pub multipliers: Vec<Vec<Multiplier>>,
}

impl Fit {
    /// The frames' projection on the columns of `q`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Io`].
    pub(super) fn on(frames: &mut Frames, gram: &Gram, q: Mat<f64>) -> Result<Self> {
        let t = project(frames, Attribute::Positions, &gram.center, &q)?;
        Ok(Self { q, t, multipliers: vec![Vec::new(); frames.vertices()] })
    }

    /// The first n columns. The multipliers stay, because a place that was hard to reach stays so.
    pub(super) fn first(&self, n: usize) -> Self {
        let t = self.t.chunks(self.q.ncols()).flat_map(|t| &t[..n]).copied().collect();
        Self { q: self.q.subcols(0, n).to_owned(), t, multipliers: self.multipliers.clone() }
    }
}

/// The multiplier of a vertex in a frame.
#[derive(Clone, Copy)]
pub(super) struct Multiplier {
    pub frame: u32,
    pub u: Vec3,
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
    let n = q.ncols();
    let numbers = 3 * frames.vertices();
    let q = narrow(q);
    let mut t = vec![0.0; n * numbers];
    let mut values = Vec::new();
    for range in frames.batches() {
        frames.batch(attribute, range.clone(), &mut values)?;
        values.par_chunks_mut(numbers.max(1)).for_each(|frame| {
            frame.iter_mut().zip(center).for_each(|(x, center)| *x -= center);
        });
        let y = MatRef::from_row_major_slice(&values, range.len(), numbers);
        let q = q.subrows(range.start, range.len());
        t.par_chunks_mut(3 * TASK * n).enumerate().for_each(|(task, t)| {
            let columns = t.len() / n;
            let y = y.subcols(task * 3 * TASK, columns);
            let t = MatMut::from_column_major_slice_mut(t, n, columns);
            matmul(t, Accum::Add, q.transpose(), y, 1.0, Par::Seq);
        });
    }
    Ok(t)
}

/// In float32.
pub(super) fn narrow(m: &Mat<f64>) -> Mat<f32> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] as f32)
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

/// The squared distances of a vertex (3F numbers, component by component) from where it should be, for each
/// frame. Returns the largest.
pub(super) fn distances(arch: Arch, y: &[f32], m: &[f32], squares: &mut [f32]) -> f32 {
    arch.dispatch(Distances { y, m, squares })
}

/// [`distances`], with the widest vectors of the processor.
struct Distances<'a> {
    y: &'a [f32],
    m: &'a [f32],
    squares: &'a mut [f32],
}

impl WithSimd for Distances<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f32 {
        let Self { y, m, squares } = self;
        let f = squares.len();
        for (c, (y, m)) in y.chunks_exact(f).zip(m.chunks_exact(f)).enumerate() {
            for ((square, y), m) in squares.iter_mut().zip(y).zip(m) {
                let d = y - m;
                *square = if c == 0 { d * d } else { *square + d * d };
            }
        }
        // Several maxima, so that none waits for another one.
        let mut most = [0.0_f32; 16];
        let (groups, others) = squares.as_chunks::<16>();
        for group in groups {
            most.iter_mut().zip(group).for_each(|(most, square)| *most = most.max(*square));
        }
        most.iter().chain(others).fold(0.0, |most, square| most.max(*square))
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
