//! The wrinkles (step 9 of the learned method). The kernel is the chapter's, made zero at the rest pose, over
//! vector strains or strain lengths.
use super::neighborhoods::{EdgeInfluences, LinearInfluences};
use super::vector_strains::VectorStrains;
use crate::noise::LEAST_VARIANCE;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Error, Progress, Result, StrainEdgeId, Table};
use rhytid_kernels::detail;

/// The weights of the wrinkles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wrinkles {
    /// w, V×N in mesh units: `Σ w_p` for the rest pose and `−w_p` for the examples.
    pub weights: Table<[f64; 3]>,
    /// `b = Σ_p ‖p‖ w_p`, V×3 in mesh units: the constant part, from the examples' distances from the rest
    /// pose.
    pub constants: Vec<[f64; 3]>,
}

/// How loosely the wrinkles fit the examples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ridges<'a> {
    /// μ > 0.
    pub ridge: f64,
    /// σ_p, P in mesh units: the noise of the examples.
    pub noise: &'a [f64],
}

/// The wrinkles of strain lengths, as in the chapter. The distances are ‖f_p‖ and ‖f_p − f_q‖.
///
/// `pose_features` is N×F with the rest pose first, 0; `detail` is P×V.
///
/// # Errors
/// [`Error::Internal`] if a matrix is not positive definite, which μ > 0 excludes. [`Error::Cancelled`].
pub(crate) fn length_wrinkles(
    pose_features: &Table<f64>,
    influences: &EdgeInfluences,
    detail: &Table<[f64; 3]>,
    ridges: Ridges,
    progress: &dyn Progress,
) -> Result<Wrinkles> {
    let f = |j: usize| pose_features.row(j);
    let systems = Systems { vertices: influences.edges.height(), examples: detail.height(), ridges };
    systems.solve(progress, |v, system| {
        for (d, detail) in system.weights.iter_mut().zip(detail.rows()) {
            *d = DVec3::from_array(detail[v]);
        }
        let (e, alpha) = (StrainEdgeId::numbers(influences.edges.row(v)), influences.weights.row(v));
        system.measure(|p, q| detail::feature_distance(e, alpha, f(p), f(q)));
    })
}

/// The wrinkles of vector strains. The distances are ‖D_p‖ and ‖D_p − D_q‖ with ω.
///
/// `left` is the residual of the examples after the shell and ΔB, V×P in mesh units. The remaining part of
/// the linear band is subtracted from it. `strain_edges` is F. A vertex that only anchors influence has no
/// wrinkles.
///
/// # Errors
/// As [`length_wrinkles`].
pub(crate) fn vector_wrinkles(
    strains: &VectorStrains,
    influences: &LinearInfluences,
    strain_edges: u32,
    left: &Table<[f64; 3]>,
    example_weights: &Table<[f64; 3]>,
    ridges: Ridges,
    progress: &dyn Progress,
) -> Result<Wrinkles> {
    let examples = strains.examples();
    let systems = Systems { vertices: left.height(), examples, ridges };
    systems.solve(progress, |v, system| {
        let terms = influences.at(v);
        system.weights.fill(DVec3::ZERO);
        if terms.clone().all(|(e, omega)| e >= strain_edges || omega == 0.0) {
            return;
        }
        strains.common(terms, &mut system.common);
        let kappa = |p: usize, q: usize| system.common[p.max(q) * examples + p.min(q)];
        for (p, (d, left)) in system.weights.iter_mut().zip(left.row(v)).enumerate() {
            let mut sum = DVec3::from_array(*left);
            let c = example_weights.row(v).iter().enumerate();
            c.for_each(|(q, c)| sum -= kappa(p, q) * DVec3::from_array(*c));
            *d = sum;
        }
        let common = std::mem::take(&mut system.common);
        system.measure(|p, q| match (p, q) {
            (0, _) | (_, 0) => common[(p.max(q) - 1) * (examples + 1)].sqrt(),
            _ => {
                let at = |p: usize, q: usize| common[(p - 1) * examples + q - 1];
                (at(p, p) + at(q, q) - 2.0 * at(p.max(q), p.min(q))).max(0.0).sqrt()
            }
        });
        system.common = common;
    })
}

/// A vertex does not see the examples move if their mean distance from rest is up to this, as a strain. A
/// marker would move by 0.15 µm on 15 mm then, and a frame's rounding and noise would be taken for an
/// example.
const STILL: f64 = 1e-5;

/// One vertex's system.
struct System {
    /// Lower triangle, row-major, P×P.
    matrix: Vec<f64>,
    /// The distances of the examples from the rest pose.
    lengths: Vec<f64>,
    /// d, then w.
    weights: Vec<DVec3>,
    /// κ of the examples: lower triangle, row-major, P×P.
    common: Vec<f64>,
}

impl System {
    /// Computes `G_pq = ‖p‖ + ‖q‖ − ‖p − q‖`. `distance` is that of two centres, of which the first is the
    /// rest pose.
    fn measure(&mut self, distance: impl Fn(usize, usize) -> f64) {
        let examples = self.lengths.len();
        for (p, length) in self.lengths.iter_mut().enumerate() {
            *length = distance(p + 1, 0);
        }
        for p in 0..examples {
            for q in 0..=p {
                let between = if p == q { 0.0 } else { distance(p + 1, q + 1) };
                self.matrix[p * examples + q] = self.lengths[p] + self.lengths[q] - between;
            }
        }
    }
}

/// The systems of all vertices.
struct Systems<'a> {
    vertices: usize,
    /// P.
    examples: usize,
    ridges: Ridges<'a>,
}

impl Systems<'_> {
    /// Solves `(G + tr G/P · diag(μ + ρ_p)) w = d` for each vertex by Cholesky's factorisation. Where d is 0,
    /// or the examples are [`STILL`], w is 0. `assemble` puts d and G of a vertex into the system.
    ///
    /// ρ_p is what the noise of an example adds: σ_p² as a part of the variance of d without noise. Where d
    /// is no larger than noise, w is nearly 0.
    fn solve(
        &self,
        progress: &dyn Progress,
        assemble: impl Fn(usize, &mut System) + Sync + Send,
    ) -> Result<Wrinkles> {
        let Self { vertices, examples, ridges: Ridges { ridge, noise } } = *self;
        let mean_noise = noise.iter().map(|sigma| sigma * sigma).sum::<f64>() / examples as f64;
        let centers = examples + 1;
        let mut wrinkles = Wrinkles {
            weights: Table::filled(vertices, centers, [0.0; 3]),
            constants: vec![[0.0; 3]; vertices],
        };
        if examples == 0 {
            return Ok(wrinkles);
        }
        progress.step("wrinkles", 0, 1)?;
        let rows = wrinkles.weights.par_rows_mut().zip(&mut wrinkles.constants);
        let scratch = || System {
            matrix: vec![0.0; examples * examples],
            lengths: vec![0.0; examples],
            weights: vec![DVec3::ZERO; examples],
            common: vec![0.0; examples * examples],
        };
        rows.enumerate()
            .map_init(scratch, |system, (v, (weights, constant))| {
                system.matrix.fill(0.0);
                assemble(v, system);
                let trace: f64 = (0..examples).map(|p| system.matrix[p * centers]).sum();
                let is_still = trace <= 2.0 * STILL * examples as f64;
                if is_still || system.weights.iter().all(|d| *d == DVec3::ZERO) {
                    return Ok(());
                }
                let squares = system.weights.iter().map(|d| d.length_squared()).sum::<f64>();
                let variance = squares / (3 * examples) as f64 - mean_noise;
                for (p, sigma) in noise.iter().enumerate() {
                    let of_noise = match sigma * sigma {
                        0.0 => 0.0,
                        square => square / variance.max(LEAST_VARIANCE * mean_noise),
                    };
                    system.matrix[p * centers] += (ridge + of_noise) * trace / examples as f64;
                }
                if !solve(&mut system.matrix, &mut system.weights) {
                    return Err(Error::Internal(format!("the wrinkles of vertex {v} have no solution")));
                }
                for (p, w) in system.weights.iter().enumerate() {
                    for c in 0..3 {
                        weights[0][c] += w[c];
                        weights[p + 1][c] = -w[c];
                        constant[c] += system.lengths[p] * w[c];
                    }
                }
                Ok(())
            })
            .collect::<Result<()>>()?;
        progress.step("wrinkles", 1, 1)?;
        Ok(wrinkles)
    }
}

/// Solves `A x = b` by Cholesky's factorisation. `matrix` is A's lower triangle, row-major, and `x` contains
/// b before. False where A is not positive definite.
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
