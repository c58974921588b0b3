//! The folds (step 9 of the learned method): the chapter's kernel made zero at the rest pose.
use super::neighborhoods::EdgeInfluences;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Error, Progress, Result};
use rhytid_kernels::detail::feature_distance;

/// The weights of the folds.
#[derive(Debug, Clone, PartialEq)]
pub struct Folds {
    /// w, V×N×3 in mesh units: `Σ w_p` for the rest pose and `−w_p` for the examples.
    pub weights: Vec<[f64; 3]>,
    /// `b = Σ_p ‖f_p‖ w_p`, V×3 in mesh units.
    pub constants: Vec<[f64; 3]>,
}

/// Per vertex `(G + μ tr G/P · I) w = d`, `G_pq = ‖f_p‖ + ‖f_q‖ − ‖f_p − f_q‖`, by Cholesky; nothing where G is 0.
///
/// `pose_features` is N×F with the rest pose first, 0; `detail` is P×V, example after example; `fold_ridge` is μ > 0.
///
/// # Errors
/// [`Error::Internal`] if a matrix is not positive definite, which a μ above 0 forbids.
pub(crate) fn folds(
    pose_features: &[f64],
    examples: usize,
    influences: &EdgeInfluences,
    detail: &[[f64; 3]],
    vertices: usize,
    fold_ridge: f64,
    progress: &dyn Progress,
) -> Result<Folds> {
    let centers = examples + 1;
    let mut folds =
        Folds { weights: vec![[0.0; 3]; vertices * centers], constants: vec![[0.0; 3]; vertices] };
    let k = influences.edges.len().checked_div(vertices).unwrap_or(0);
    if examples == 0 || k == 0 {
        return Ok(folds);
    }
    let edges = pose_features.len() / centers;
    progress.step("folds", 0, 1)?;
    let rows = folds.weights.par_chunks_mut(centers).zip(&mut folds.constants);
    rows.enumerate()
        .map_init(
            || (vec![0.0; examples * examples], vec![0.0; examples], vec![DVec3::ZERO; examples]),
            |(matrix, lengths, w), (v, (weights, constant))| {
                for (p, w) in w.iter_mut().enumerate() {
                    *w = DVec3::from_array(detail[p * vertices + v]);
                }
                if w.iter().all(|d| *d == DVec3::ZERO) {
                    return Ok(());
                }
                let (e, alpha) = (&influences.edges[v * k..][..k], &influences.weights[v * k..][..k]);
                let f = |j: usize| &pose_features[j * edges..][..edges];
                for (p, length) in lengths.iter_mut().enumerate() {
                    *length = feature_distance(e, alpha, f(p + 1), f(0));
                }
                for p in 0..examples {
                    for q in 0..=p {
                        let between =
                            if p == q { 0.0 } else { feature_distance(e, alpha, f(p + 1), f(q + 1)) };
                        matrix[p * examples + q] = lengths[p] + lengths[q] - between;
                    }
                }
                let trace: f64 = (0..examples).map(|p| matrix[p * examples + p]).sum();
                if trace <= 0.0 {
                    return Ok(());
                }
                for p in 0..examples {
                    matrix[p * examples + p] += fold_ridge * trace / examples as f64;
                }
                if !solve(matrix, w) {
                    return Err(Error::Internal(format!("the folds of vertex {v} have no solution")));
                }
                for (p, w) in w.iter().enumerate() {
                    for c in 0..3 {
                        weights[0][c] += w[c];
                        weights[p + 1][c] = -w[c];
                        constant[c] += lengths[p] * w[c];
                    }
                }
                Ok(())
            },
        )
        .collect::<Result<()>>()?;
    progress.step("folds", 1, 1)?;
    Ok(folds)
}

/// `A x = b` by Cholesky's factorisation; `matrix` is A's lower triangle, row-major, and `x` is b before it. False where A
/// is not positive definite.
fn solve(matrix: &mut [f64], x: &mut [DVec3]) -> bool {
    let n = x.len();
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let rest = matrix[i * n + j] - dot;
            if i == j {
                if rest.is_nan() || rest <= 0.0 {
                    return false;
                }
                matrix[i * n + i] = rest.sqrt();
            } else {
                matrix[i * n + j] = rest / matrix[j * n + j];
            }
        }
        let dot: DVec3 = (0..i).map(|k| matrix[i * n + k] * x[k]).sum();
        x[i] = (x[i] - dot) / matrix[i * n + i];
    }
    for i in (0..n).rev() {
        let dot: DVec3 = (i + 1..n).map(|k| matrix[k * n + i] * x[k]).sum();
        x[i] = (x[i] - dot) / matrix[i * n + i];
    }
    true
}
