//! The choice of columns to store: a fit's, turned so that rounding the targets does the least harm.
//!
//! The errors of rounded targets reach a frame through its weights. If the errors are independent and of the
//! same size in all targets, their variance in frame f is the squared length of row f of the weights. The
//! D-optimal design gives each frame a weight. The columns that are orthonormal under the design make the
//! largest of these variances as small as possible. Among those columns, the principal axes of the targets
//! are stored, because they need the fewest levels.

use super::factors::{Fit, follow, outer};
use super::linear::{cholesky, eigen, product, solve_lower};
use faer::Mat;
use rhytid_core::Result;

/// Steps of the multiplicative algorithm for the design; it gets within a percent of the best.
const STEPS: usize = 200;

/// `Y ≈ W T`; the first column of W is 1.
pub(super) struct Basis {
    /// F×n: orthonormal columns that span those of W.
    pub q: Mat<f64>,
    /// n×n: with this times Qᵀ X, W comes as near as possible to any X.
    pub turn: Mat<f64>,
    /// F×n.
    pub weights: Mat<f64>,
    /// Column-major n×3V.
    pub t: Vec<f32>,
}

/// Turns a fit. `all` has the weights of all frames, for the fit's T. The fit may be for some of the frames:
/// the design needs the most different ones only.
///
/// # Errors
/// As [`eigen`].
pub(super) fn turn(fit: Fit, all: &Mat<f64>) -> Result<Basis> {
    let Fit { q, mut t, .. } = fit;
    let n = q.ncols();
    let l = cholesky(&moment(&q, &design(&q)));
    // The first column of L stands for the mean; the others are turned among themselves.
    let tt = product(product(l.transpose(), outer(&t, n).as_ref()).as_ref(), l.as_ref());
    let axes = eigen(&Mat::from_fn(n - 1, n - 1, |i, j| tt[(i + 1, j + 1)]))?.vectors;
    let axes = Mat::from_fn(n, n, |i, j| match (i, j) {
        (0, _) | (_, 0) => f64::from(u8::from(i == j)),
        _ => axes[(i - 1, j - 1)],
    });
    let turn = product(axes.transpose(), l.transpose());
    let weights = product(solve_lower(&l, all).as_ref(), axes.as_ref());
    follow(&mut t, &turn, n);
    let c = cholesky(&product(all.transpose(), all.as_ref()));
    let (q, turn) = (solve_lower(&c, all), solve_lower(&c, &turn));
    Ok(Basis { q, turn, weights, t })
}

/// `Qᵀ diag(d) Q`.
fn moment(q: &Mat<f64>, d: &[f64]) -> Mat<f64> {
    let scaled = Mat::from_fn(q.nrows(), q.ncols(), |i, j| d[i] * q[(i, j)]);
    product(q.transpose(), scaled.as_ref())
}

/// The D-optimal design for the rows of Q: a weight for each frame, 1 in sum.
fn design(q: &Mat<f64>) -> Vec<f64> {
    let (f, n) = (q.nrows(), q.ncols());
    let mut d = vec![1.0 / f as f64; f];
    for _ in 0..STEPS {
        let w = solve_lower(&cholesky(&moment(q, &d)), q);
        for (i, d) in d.iter_mut().enumerate() {
            let square: f64 = (0..n).map(|j| w[(i, j)] * w[(i, j)]).sum();
            *d *= square / n as f64;
        }
    }
    d
}
