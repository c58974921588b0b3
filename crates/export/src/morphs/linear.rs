//! The linear algebra that is needed here, with one order of every sum.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltRegularization, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::traits::RealField;
use faer::{Accum, Mat, MatMut, MatRef, Par};
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
pub(super) fn product<T: RealField>(a: MatRef<'_, T>, b: MatRef<'_, T>) -> Mat<T> {
    let mut result = Mat::zeros(a.nrows(), b.ncols());
    matmul(result.as_mut(), Accum::Replace, a, b, T::one_impl(), Par::Seq);
    result
}

/// The lower triangle L with `L Lᵀ = h`, for a positive definite h. Pivots that are zero but for rounding are
/// 1e-14 of the largest number of the diagonal.
pub(super) fn cholesky(h: &Mat<f64>) -> Mat<f64> {
    let n = h.nrows();
    let largest = (0..n).map(|i| h[(i, i)]).fold(f64::MIN_POSITIVE, f64::max);
    let least = LltRegularization {
        dynamic_regularization_delta: 1e-14 * largest,
        dynamic_regularization_epsilon: 1e-14 * largest,
    };
    let mut l = h.clone();
    let scratch = cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
    let stack = &mut MemBuffer::new(scratch);
    match cholesky_in_place(l.as_mut(), least, Par::Seq, MemStack::new(stack), Default::default()) {
        Ok(_) => Mat::from_fn(n, n, |i, j| if j > i { 0.0 } else { l[(i, j)] }),
        // A number of h is NaN.
        Err(_) => Mat::full(n, n, f64::NAN),
    }
}

/// `Q L⁻ᵀ`.
pub(super) fn solve_lower(l: &Mat<f64>, q: &Mat<f64>) -> Mat<f64> {
    let mut w = q.clone();
    solve_lower_triangular_in_place(l.as_ref(), w.as_mut().transpose_mut(), Par::Seq);
    w
}

/// The x with `h x = b`, for a positive definite h.
pub(super) fn solve(h: &Mat<f64>, mut b: Vec<f64>) -> Vec<f64> {
    let l = cholesky(h);
    let n = b.len();
    let mut x = MatMut::from_column_major_slice_mut(&mut b, n, 1);
    solve_lower_triangular_in_place(l.as_ref(), x.as_mut(), Par::Seq);
    solve_upper_triangular_in_place(l.transpose(), x, Par::Seq);
    b
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

/// The constant column, and then the principal directions of the frames, those that explain most first:
/// all F − 1 others.
///
/// # Errors
/// As [`eigen`].
pub(super) fn principal(gram: &Mat<f64>) -> Result<Eigen> {
    let n = gram.nrows();
    principal_after(gram, &Mat::from_fn(n, 1, |_, _| 1.0 / (n as f64).sqrt()))
}

/// The orthonormal columns of `first`, and then the principal directions of what these leave of the frames,
/// those that explain most first: F in all. `values[k]` belongs to column k after those of `first`.
///
/// # Errors
/// As [`eigen`].
pub(super) fn principal_after(gram: &Mat<f64>, first: &Mat<f64>) -> Result<Eigen> {
    let n = gram.nrows();
    let away = Mat::<f64>::identity(n, n) - product(first.as_ref(), first.transpose());
    let left = product(product(away.as_ref(), gram.as_ref()).as_ref(), away.as_ref());
    let Eigen { values, vectors } = eigen(&left)?;
    let vectors = extend(first, (0..n).map(|j| vectors.col(j)), n);
    Ok(Eigen { values, vectors })
}
