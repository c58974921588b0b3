//! The linear algebra that is needed here, with one order of every sum.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rhytid_core::numbers::dot;
use rhytid_core::{Error, Result};

/// Eigenvalues with their vectors as columns, the largest first.
pub(super) struct Eigen {
    pub values: Vec<f64>,
    pub vectors: Mat<f64>,
}

/// The eigenpairs of a symmetric matrix.
///
/// # Errors
/// [`Error::Internal`] if the iteration does not converge.
pub(super) fn eigen(matrix: &Mat<f64>) -> Result<Eigen> {
    let n = matrix.nrows();
    if n == 0 {
        return Ok(Eigen { values: Vec::new(), vectors: Mat::zeros(0, 0) });
    }
    let (mut values, mut vectors) = (Mat::zeros(n, 1), Mat::zeros(n, n));
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    self_adjoint_evd(
        matrix.as_ref(),
        values.as_mut().col_mut(0).as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .map_err(|e| Error::Internal(format!("an eigenvalue problem did not converge: {e:?}")))?;
    Ok(Eigen {
        values: (0..n).rev().map(|i| values[(i, 0)]).collect(),
        vectors: Mat::from_fn(n, n, |i, j| vectors[(i, n - 1 - j)]),
    })
}

/// `a b`.
pub(super) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut result = Mat::zeros(a.nrows(), b.ncols());
    matmul(result.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    result
}

/// The orthonormal columns of `first`, and then the new directions in the columns of `from`: orthonormal, at
/// most `most` in all. Columns that add nothing are left out.
pub(super) fn extend<'a>(
    first: &Mat<f64>,
    from: impl Iterator<Item = faer::ColRef<'a, f64>>,
    most: usize,
) -> Mat<f64> {
    let mut columns: Vec<Vec<f64>> =
        first.col_iter().map(|column| column.iter().copied().collect()).collect();
    for column in from {
        if columns.len() == most {
            break;
        }
        let mut column: Vec<f64> = column.iter().copied().collect();
        let before = dot(&column, &column).sqrt();
        // Twice is enough for orthogonality to rounding.
        for _ in 0..2 {
            for other in &columns {
                let along = dot(&column, other);
                column.iter_mut().zip(other).for_each(|(x, o)| *x -= along * o);
            }
        }
        let length = dot(&column, &column).sqrt();
        if length > 1e-9 * before {
            column.iter_mut().for_each(|x| *x /= length);
            columns.push(column);
        }
    }
    Mat::from_fn(first.nrows(), columns.len(), |i, j| columns[j][i])
}

/// The principal directions of the frames: the constant column first, then all F − 1 others, those that
/// explain most first. `values[k]` belongs to `vectors[k + 1]`.
///
/// # Errors
/// As [`eigen`].
pub(super) fn principal(gram: &Mat<f64>) -> Result<Eigen> {
    let n = gram.nrows();
    let Eigen { values, vectors } = eigen(gram)?;
    let constant = Mat::from_fn(n, 1, |_, _| 1.0 / (n as f64).sqrt());
    let vectors = extend(&constant, (0..n).map(|j| vectors.col(j)), n);
    Ok(Eigen { values, vectors })
}
