//! Section 7: the weights of the radial basis functions.
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, Par};
use rayon::prelude::*;
use rhytid_core::{Error, Influences, Progress, Result, StrainEdgeId, Table};
use rhytid_kernels::detail::feature_distance;

/// Eigenvalues below this part of the largest absolute one count as zero. They come from poses that are the
/// same at a vertex.
const RANK_TOLERANCE: f64 = 1e-6;

/// Vertices between two reports of progress.
const VERTICES_AT_ONCE: usize = 1 << 14;

/// Memory for one N×N eigenvalue problem, reused from vertex to vertex.
struct Workspace {
    matrix: Mat<f64>,
    values: Mat<f64>,
    vectors: Mat<f64>,
    scratch: MemBuffer,
}

impl Workspace {
    fn new(n: usize) -> Self {
        let scratch =
            self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
        Self {
            matrix: Mat::zeros(n, n),
            values: Mat::zeros(n, 1),
            vectors: Mat::zeros(n, n),
            scratch: MemBuffer::new(scratch),
        }
    }
}

/// w, V×N: for each vertex the minimum-norm solution of `Φ w = d` with `Φ[i, j] = ‖f_i − f_j‖_v`.
///
/// `pose_features` is N×F with the rest pose first; `detail` is P×V, P = N − 1. The detail of the rest pose
/// is zero.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn rbf_weights(
    pose_features: &Table<f64>,
    influences: &Influences<f64>,
    detail: &Table<[f64; 3]>,
    progress: &dyn Progress,
) -> Result<Table<[f64; 3]>> {
    let (vertices, centers) = (influences.edges.height(), pose_features.height());
    let mut weights = Table::filled(vertices, centers, [0.0; 3]);
    if centers == 1 || influences.per_vertex() == 0 {
        return Ok(weights);
    }
    let total = vertices as u64;
    for (chunk, out) in weights.as_mut_slice().chunks_mut(VERTICES_AT_ONCE * centers).enumerate() {
        let first = chunk * VERTICES_AT_ONCE;
        progress.step("weights", first as u64, total)?;
        out.par_chunks_mut(centers)
            .enumerate()
            .map_init(
                || Workspace::new(centers),
                |workspace, (i, w)| {
                    let v = first + i;
                    let d = |j: usize| if j == 0 { [0.0; 3] } else { detail.row(j - 1)[v] };
                    if (0..centers).all(|j| d(j) == [0.0; 3]) {
                        return Ok(());
                    }
                    let (e, alpha) =
                        (StrainEdgeId::numbers(influences.edges.row(v)), influences.weights.row(v));
                    let f = |j: usize| pose_features.row(j);
                    for i in 0..centers {
                        for j in 0..i {
                            let r = feature_distance(e, alpha, f(i), f(j));
                            workspace.matrix[(i, j)] = r;
                            workspace.matrix[(j, i)] = r;
                        }
                    }
                    minimum_norm(workspace, d, w)
                },
            )
            .collect::<Result<()>>()?;
    }
    progress.step("weights", total, total)?;
    Ok(weights)
}

/// `w = Σ q (qᵀ d) / λ` over the eigenpairs of the symmetric matrix that count.
fn minimum_norm(workspace: &mut Workspace, d: impl Fn(usize) -> [f64; 3], w: &mut [[f64; 3]]) -> Result<()> {
    let Workspace { matrix, values, vectors, scratch } = workspace;
    self_adjoint_evd(
        matrix.as_ref(),
        values.as_mut().col_mut(0).as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(scratch),
        Default::default(),
    )
    .map_err(|e| Error::Internal(format!("an eigenvalue problem did not converge: {e:?}")))?;
    let lambda = values.col(0);
    let largest = lambda.iter().fold(0.0, |m: f64, l| m.max(l.abs()));
    w.fill([0.0; 3]);
    for (i, &l) in lambda.iter().enumerate() {
        if l.abs() < RANK_TOLERANCE * largest || l == 0.0 {
            continue;
        }
        let mut projected = [0.0; 3];
        for j in 0..w.len() {
            let d = d(j);
            for c in 0..3 {
                projected[c] += vectors[(j, i)] * d[c];
            }
        }
        for (j, w) in w.iter_mut().enumerate() {
            for c in 0..3 {
                w[c] += vectors[(j, i)] * (projected[c] / l);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    /// The weights of one vertex that all K strain edges influence.
    fn weights<const K: usize>(
        features: &[[f64; K]],
        alpha: &[f64; K],
        detail: &[[f64; 3]],
    ) -> Vec<[f64; 3]> {
        let features = Table::new(features.len(), K, features.as_flattened().to_vec());
        let influences = Influences {
            edges: Table::new(1, K, (0..K).map(StrainEdgeId::from_index).collect()),
            weights: Table::new(1, K, alpha.to_vec()),
            beta: 0.0,
        };
        let detail = Table::new(detail.len(), 1, detail.to_vec());
        rbf_weights(&features, &influences, &detail, &NoProgress).unwrap().into_vec()
    }

    #[test]
    fn interpolates_every_center() {
        let features = [[0.0, 0.0], [0.3, 0.1], [-0.2, 0.4]];
        let detail = [[1.0, 2.0, 3.0], [-1.0, 0.5, 0.0]];
        let alpha = [1.0, 0.5];
        let w = weights(&features, &alpha, &detail);
        for i in 0..3 {
            let expected = if i == 0 { [0.0; 3] } else { detail[i - 1] };
            for c in 0..3 {
                let sum: f64 = (0..3)
                    .map(|j| w[j][c] * feature_distance(&[0, 1], &alpha, &features[i], &features[j]))
                    .sum();
                assert!((sum - expected[c]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn equal_poses_share_their_mean_at_minimum_norm() {
        let features = [[0.0], [0.5], [0.5]];
        let detail = [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        let w = weights(&features, &[1.0], &detail);
        // The equations are 0.5 (w1 + w2) = 0 at the rest pose, and 0.5 w0 = 2 at the examples, the mean of 1
        // and 3.
        for (w, expected) in w.iter().zip([4.0, 0.0, 0.0]) {
            assert!((w[0] - expected).abs() < 1e-12, "{w:?}");
        }
    }
}
