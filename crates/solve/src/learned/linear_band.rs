//! The linear band (step 6 of the learned method).
//!
//! It is the residual of the examples after the shell, as a linear function of the relative movements of the
//! nearby handles.
use super::neighborhoods::LinearInfluences;
use super::reach::Beyond;
use super::vector_strains::VectorStrains;
use crate::vectors::widest;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::{Mat, Par};
use glam::DMat3;
use rayon::prelude::*;
use rhytid_core::{Error, Progress, Result, Table, VertexId};

/// The number of vertices between two reports of progress.
const VERTICES_AT_ONCE: usize = 1 << 16;

/// The settings of the linear band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearSettings {
    /// s in [0, 1]: the share of the kernel that learns each axis by itself.
    pub(crate) share: f64,
    /// λ > 0: the addition to the diagonal, as a part of its mean.
    pub(crate) ridge: f64,
    /// σ_m ≥ 0: the standard deviation of a marker's noise per axis, in mesh units.
    pub(crate) marker_noise: f64,
    /// The length up to which a vector strain is followed, as a multiple of its greatest length in the
    /// examples. Infinite where there is no limit.
    pub(crate) reach: f64,
}

/// The system of one vertex. Its memory serves the next vertex too.
pub(crate) struct VertexSystem {
    size: usize,
    kernel: Mat<f64>,
    factor: Mat<f64>,
    inverse: Mat<f64>,
    scratch: MemBuffer,
    /// κ, P×P.
    kappa: Vec<f64>,
    trace: f64,
    noise: f64,
    /// ρ_p, P.
    noise_ridges: Vec<f64>,
}

impl VertexSystem {
    /// For P examples.
    pub(crate) fn new(examples: usize) -> Self {
        let size = 3 * examples;
        let factor = llt::factor::cholesky_in_place_scratch::<f64>(size, Par::Seq, Default::default());
        let inverse = llt::inverse::inverse_scratch::<f64>(size, Par::Seq);
        Self {
            size,
            kernel: Mat::zeros(size, size),
            factor: Mat::zeros(size, size),
            inverse: Mat::zeros(size, size),
            scratch: MemBuffer::new(factor.or(inverse)),
            kappa: vec![0.0; examples * examples],
            trace: 0.0,
            noise: 0.0,
            noise_ridges: vec![0.0; examples],
        }
    }

    /// Computes K1 and κ of a vertex, which `features` influence with the weights ω. They do not depend on
    /// the settings.
    pub(crate) fn assemble(&mut self, strains: &VectorStrains, features: &[u32], weights: &[f64]) {
        let size = self.size;
        self.kernel.fill(0.0);
        self.noise = 0.0;
        self.noise_ridges.copy_from_slice(strains.noise_ridges());
        let Self { kernel, noise, .. } = self;
        widest(
            #[inline(always)]
            || {
                for (&e, &w) in features.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
                    let d = strains.feature(e);
                    *noise += w * strains.noise(e);
                    for (j, dj) in d.iter().enumerate() {
                        let wd = w * dj;
                        for (to, di) in kernel.col_as_slice_mut(j)[j..].iter_mut().zip(&d[j..]) {
                            *to += wd * di;
                        }
                    }
                }
            },
        );
        self.trace = (0..size).map(|i| self.kernel[(i, i)]).sum();
        let examples = size / 3;
        for p in 0..examples {
            for q in 0..=p {
                let sum = (0..3).map(|c| self.kernel[(3 * p + c, 3 * q + c)]).sum();
                self.kappa[p * examples + q] = sum;
                self.kappa[q * examples + p] = sum;
            }
        }
    }

    /// Solves `(((1−s) K1 + s K3)/τ + diag(λ + n/τ + ρ_p)) z = Ŵ`, where `smooth` is Ŵ, 3P.
    ///
    /// Where no example moves the features of the vertex, z is 0 and the result is false. After this,
    /// [`VertexSystem::leave_one_out`] can be called.
    ///
    /// # Errors
    /// [`Error::Internal`] if the matrix is not positive definite, which λ > 0 excludes.
    pub(crate) fn solve(&mut self, settings: LinearSettings, smooth: &[f64], z: &mut [f64]) -> Result<bool> {
        z.fill(0.0);
        if !self.factorize(settings)? {
            return Ok(false);
        }
        z.copy_from_slice(smooth);
        self.substitute(z);
        Ok(true)
    }

    /// Computes the factor of the matrix of [`VertexSystem::solve`]. False where there is none.
    ///
    /// # Errors
    /// As [`VertexSystem::solve`].
    pub(crate) fn factorize(&mut self, settings: LinearSettings) -> Result<bool> {
        let tau = self.tau();
        if tau <= 0.0 {
            return Ok(false);
        }
        let (size, examples) = (self.size, self.size / 3);
        let s = settings.share;
        let diagonal = self.diagonal(settings);
        for j in 0..size {
            for i in j..size {
                let shared = if i % 3 == j % 3 { self.kappa[i / 3 * examples + j / 3] } else { 0.0 };
                self.factor[(i, j)] = ((1.0 - s) * self.kernel[(i, j)] + s * shared) / tau;
            }
            self.factor[(j, j)] += diagonal + self.noise_ridges[j / 3];
        }
        llt::factor::cholesky_in_place(
            self.factor.as_mut(),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        )
        .map_err(|e| Error::Internal(format!("a vertex's linear band has no solution: {e:?}")))?;
        Ok(true)
    }

    /// What the band leaves of Ŵ: `(λ + n/τ + ρ_p) z`.
    pub(crate) fn left(&self, settings: LinearSettings, z: &[f64], left: &mut [f64]) {
        let diagonal = self.diagonal(settings);
        for (i, (left, z)) in left.iter_mut().zip(z).enumerate() {
            *left = (diagonal + self.noise_ridges[i / 3]) * z;
        }
    }

    /// λ + n/τ.
    fn diagonal(&self, settings: LinearSettings) -> f64 {
        settings.ridge + settings.marker_noise.powi(2) * self.noise / self.tau()
    }

    /// The factor's lower triangle, column by column.
    pub(crate) fn factor(&self) -> Vec<f64> {
        (0..self.size).flat_map(|j| &self.factor.col_as_slice(j)[j..]).copied().collect()
    }

    /// The traces of the inverses of A's 3×3 diagonal blocks, P. They are the variances of left-out examples,
    /// in units of s_v².
    pub(crate) fn left_out(&mut self) -> Vec<f64> {
        self.invert();
        (0..self.size / 3)
            .map(|p| {
                let inverse = self.block(p, p).inverse();
                (0..3).map(|c| inverse.col(c)[c]).sum()
            })
            .collect()
    }

    /// Solves L Lᵀ y = x and writes y in place of x.
    fn substitute(&self, x: &mut [f64]) {
        let size = self.size;
        for j in 0..size {
            let column = self.factor.col_as_slice(j);
            x[j] /= column[j];
            let xj = x[j];
            for (x, l) in x[j + 1..].iter_mut().zip(&column[j + 1..]) {
                *x -= l * xj;
            }
        }
        for j in (0..size).rev() {
            let column = self.factor.col_as_slice(j);
            let sum: f64 = x[j + 1..].iter().zip(&column[j + 1..]).map(|(x, l)| x * l).sum();
            x[j] = (x[j] - sum) / column[j];
        }
    }

    /// The error of each example if it is left out: `e_p = (A_pp)⁻¹ z_p`, P×3 in mesh units.
    ///
    /// A is the inverse of the matrix with which [`VertexSystem::solve`] gave `z`. What the others would do
    /// beyond their reach is added: `1/τ Σ_q ((1 − s) beyond_pq + s tr(beyond_pq)) (z_q − A_qp e_p)`. There
    /// `z_q − A_qp e_p` are the weights of the others without the example. `beyond` is from
    /// [`Beyond::of_vertex`].
    pub(crate) fn leave_one_out(
        &mut self,
        settings: LinearSettings,
        z: &[f64],
        beyond: &Table<DMat3>,
        errors: &mut [[f64; 3]],
    ) {
        self.invert();
        let z = |q: usize| glam::DVec3::from_slice(&z[3 * q..][..3]);
        for (p, error) in errors.iter_mut().enumerate() {
            let alone = self.block(p, p).inverse() * z(p);
            let beyond = beyond.row(p).iter().enumerate();
            let of_others = beyond.filter(|(q, beyond)| *q != p && **beyond != DMat3::ZERO);
            let added: glam::DVec3 = of_others
                .map(|(q, beyond)| {
                    let weights = z(q) - self.block(q, p) * alone;
                    let trace = beyond.x_axis.x + beyond.y_axis.y + beyond.z_axis.z;
                    (1.0 - settings.share) * (*beyond * weights) + settings.share * trace * weights
                })
                .sum();
            *error = (alone + added / self.tau()).to_array();
        }
    }

    /// Computes A from the factor.
    fn invert(&mut self) {
        let scratch = MemStack::new(&mut self.scratch);
        llt::inverse::inverse(self.inverse.as_mut(), self.factor.as_ref(), Par::Seq, scratch);
    }

    /// A_pq.
    fn block(&self, p: usize, q: usize) -> DMat3 {
        // Only the lower triangle is stored.
        let a = |i: usize, j: usize| self.inverse[(i.max(j), i.min(j))];
        DMat3::from_cols_array(&std::array::from_fn(|i| a(3 * p + i % 3, 3 * q + i / 3)))
    }

    /// n for a marker noise of variance 1.
    pub(crate) fn noise(&self) -> f64 {
        self.noise
    }

    /// τ: the mean of K1's diagonal.
    pub(crate) fn tau(&self) -> f64 {
        self.trace / self.size as f64
    }
}

/// The parts of the linear band.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LinearBand {
    /// g, V×(K + 8) as the features are: ΔB is `Σ_e g_ve D_e`.
    pub feature_gains: Table<f64>,
    /// c, V×P in mesh units; without columns where s = 0.
    pub example_weights: Table<[f64; 3]>,
    /// `s_v² = Ŵᵀz/3P`, V in mesh units squared.
    pub variances: Vec<f64>,
}

/// Solves the linear band of every vertex, and adds ΔB to `basis`, V×H.
///
/// `smooth` is Ŵ, V×P. It is 0 at handles, where nothing is learned. `kept` says how much of the band each
/// vertex has, V in 0..1.
///
/// # Errors
/// As [`VertexSystem::solve`], and [`Error::Cancelled`].
pub(crate) fn linear_band(
    strains: &VectorStrains,
    influences: &LinearInfluences,
    smooth: &Table<[f64; 3]>,
    settings: LinearSettings,
    kept: &[f64],
    basis: &mut Table<f64>,
    progress: &dyn Progress,
) -> Result<LinearBand> {
    let examples = strains.examples();
    let (vertices, per_vertex) = (influences.weights.height(), influences.weights.columns());
    let c = if settings.share > 0.0 { examples } else { 0 };
    let mut band = LinearBand {
        feature_gains: Table::filled(vertices, per_vertex, 0.0),
        example_weights: Table::filled(vertices, c, [0.0; 3]),
        variances: vec![0.0; vertices],
    };
    if examples == 0 {
        return Ok(band);
    }
    for first in (0..vertices).step_by(VERTICES_AT_ONCE) {
        progress.step("linear band", first as u64, vertices as u64)?;
        let end = vertices.min(first + VERTICES_AT_ONCE);
        let these = || first..end;
        // Empty rows cannot be iterated: without c, each vertex gets an empty slice.
        let weights: Vec<&mut [[f64; 3]]> = match c {
            0 => these().map(|_| Default::default()).collect(),
            _ => band.example_weights.rows_mut().skip(first).take(end - first).collect(),
        };
        basis
            .par_rows_mut()
            .skip(first)
            .take(end - first)
            .zip(band.feature_gains.par_rows_mut().skip(first))
            .zip(weights.into_par_iter().zip(&mut band.variances[these()]))
            .zip(these().into_par_iter().map(|v| smooth.row(v)))
            .enumerate()
            .map_init(
                || (VertexSystem::new(examples), vec![0.0; 3 * examples]),
                |(system, z), (i, (((row, gains), (c, variance)), smooth))| {
                    let smooth = smooth.as_flattened();
                    if smooth.iter().all(|w| *w == 0.0) {
                        return Ok(());
                    }
                    let v = first + i;
                    let (features, omega) = (influences.features.row(v), influences.weights.row(v));
                    system.assemble(strains, features, omega);
                    if !system.solve(settings, smooth, z)? {
                        return Ok(());
                    }
                    *variance = smooth.iter().zip(&*z).map(|(w, z)| w * z).sum::<f64>() / z.len() as f64;
                    z.iter_mut().for_each(|z| *z *= kept[v]);
                    let scale = (1.0 - settings.share) / system.tau();
                    if scale > 0.0 {
                        let terms = features.iter().zip(omega).zip(gains).filter(|((_, w), _)| **w > 0.0);
                        for ((&e, &w), gain) in terms {
                            let sum: f64 = z.iter().zip(strains.feature(e)).map(|(z, d)| z * d).sum();
                            *gain = scale * w * sum;
                            strains.add_to_row(e, *gain, row);
                        }
                    }
                    for (c, z) in c.iter_mut().zip(z.as_chunks::<3>().0) {
                        *c = z.map(|z| settings.share / system.tau() * z);
                    }
                    Ok(())
                },
            )
            .collect::<Result<()>>()?;
    }
    progress.step("linear band", vertices as u64, vertices as u64)?;
    Ok(band)
}

/// The error of each example at each of `vertices` if it is left out, in mesh units: a row of P for each
/// vertex.
///
/// # Errors
/// As [`VertexSystem::solve`].
pub(crate) fn leave_one_out(
    strains: &VectorStrains,
    influences: &LinearInfluences,
    smooth: &Table<[f64; 3]>,
    settings: LinearSettings,
    vertices: &[VertexId],
) -> Result<Table<[f64; 3]>> {
    let examples = strains.examples();
    let mut errors = Table::filled(vertices.len(), examples, [0.0; 3]);
    let beyond = Beyond::new(strains, settings.reach);
    errors
        .par_rows_mut()
        .zip(vertices)
        .map_init(
            || {
                (
                    VertexSystem::new(examples),
                    vec![0.0; 3 * examples],
                    Table::filled(examples, examples, DMat3::ZERO),
                )
            },
            |(system, z, of_vertex), (errors, &v)| {
                let v = v.index();
                let (features, omega) = (influences.features.row(v), influences.weights.row(v));
                let smooth = smooth.row(v);
                system.assemble(strains, features, omega);
                if system.solve(settings, smooth.as_flattened(), z)? {
                    beyond.of_vertex(strains, features, omega, of_vertex);
                    system.leave_one_out(settings, z, of_vertex, errors);
                } else {
                    errors.copy_from_slice(smooth);
                }
                Ok(())
            },
        )
        .collect::<Result<()>>()?;
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::HandleId;

    /// Numbers without a pattern, in −1..1.
    fn number(i: usize) -> f64 {
        ((i as f64 * 12.9898).sin() * 43758.5453).fract()
    }

    /// The matrix by its definition, for the features `features` with the weights ω.
    fn matrix(
        strains: &VectorStrains,
        features: &[u32],
        omega: &[f64],
        settings: LinearSettings,
    ) -> Mat<f64> {
        let (size, s) = (3 * strains.examples(), settings.share);
        let d = |e: u32, p: usize, c: usize| strains.feature(e)[3 * p + c];
        let k1 = |p: usize, c: usize, q: usize, e: usize| -> f64 {
            features.iter().zip(omega).map(|(&f, w)| w * d(f, p, c) * d(f, q, e)).sum()
        };
        let kappa = |p: usize, q: usize| (0..3).map(|c| k1(p, c, q, c)).sum::<f64>();
        let tau = (0..strains.examples()).map(|p| kappa(p, p)).sum::<f64>() / size as f64;
        let noise: f64 = features.iter().zip(omega).map(|(&f, w)| w * strains.noise(f)).sum();
        let diagonal = settings.ridge + settings.marker_noise.powi(2) * noise / tau;
        Mat::from_fn(size, size, |i, j| {
            let (p, c, q, e) = (i / 3, i % 3, j / 3, j % 3);
            let shared = if c == e { kappa(p, q) } else { 0.0 };
            let ridge = if i == j { diagonal } else { 0.0 };
            ((1.0 - s) * k1(p, c, q, e) + s * shared) / tau + ridge
        })
    }

    #[test]
    fn leaving_an_example_out_is_as_if_it_had_never_been() {
        use faer::linalg::solvers::Solve;
        let (examples, handles) = (5, 6);
        let displacements: Vec<Vec<[f64; 3]>> = (0..examples)
            .map(|p| (0..handles).map(|h| [0, 1, 2].map(|c| number(100 * p + 10 * h + c))).collect())
            .collect();
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0]].map(|pair| pair.map(HandleId));
        let strains = VectorStrains::new(&displacements, &edges, &[1.0, 1.5, 0.7, 1.0, 2.0, 1.2], 1.1);
        let (features, omega) = ([0, 1, 2, 7, 9], [0.4, 0.3, 0.2, 0.06, 0.04]);
        let smooth: Vec<f64> = (0..3 * examples).map(|i| number(1000 + i)).collect();
        let shares_and_reaches =
            [(0.0, f64::INFINITY), (0.2, f64::INFINITY), (1.0, f64::INFINITY), (0.2, 0.4), (1.0, 0.8)];
        for (share, reach) in shares_and_reaches {
            let settings = LinearSettings { share, ridge: 1e-3, marker_noise: 0.02, reach };
            let mut system = VertexSystem::new(examples);
            let (mut z, mut errors) = (vec![0.0; 3 * examples], vec![[0.0; 3]; examples]);
            let mut beyond = Table::filled(examples, examples, DMat3::ZERO);
            system.assemble(&strains, &features, &omega);
            assert!(system.solve(settings, &smooth, &mut z).unwrap());
            Beyond::new(&strains, reach).of_vertex(&strains, &features, &omega, &mut beyond);
            system.leave_one_out(settings, &z, &beyond, &mut errors);
            assert_eq!(beyond.as_slice().iter().any(|x| *x != DMat3::ZERO), reach.is_finite());

            let whole = matrix(&strains, &features, &omega, settings);
            for (p, error) in errors.iter().enumerate() {
                let others: Vec<usize> = (0..3 * examples).filter(|i| i / 3 != p).collect();
                let of_others =
                    Mat::from_fn(others.len(), others.len(), |i, j| whole[(others[i], others[j])]);
                let right = Mat::from_fn(others.len(), 1, |i, _| smooth[others[i]]);
                let without = of_others.partial_piv_lu().solve(&right);
                // The example as a frame is followed: no longer than the longest of the others.
                let followed = |e: u32| {
                    let d = strains.feature(e).as_chunks::<3>().0;
                    let others = d.iter().enumerate().filter(|(q, _)| *q != p);
                    let size = |d: &[f64; 3]| d.iter().map(|x| x * x).sum::<f64>().sqrt();
                    let limit = others.map(|(_, d)| reach * size(d)).fold(0.0, f64::max);
                    d[p].map(|x| x * (limit / size(&d[p])).min(1.0))
                };
                for c in 0..3 {
                    let row = 3 * p + c;
                    let mut predicted = 0.0;
                    for (i, &j) in others.iter().enumerate() {
                        let kernel = features.iter().zip(&omega).map(|(&e, w)| {
                            let (d, frame) = (strains.feature(e), followed(e));
                            let dot: f64 = (0..3).map(|axis| frame[axis] * d[j - j % 3 + axis]).sum();
                            w * ((1.0 - share) * frame[c] * d[j] + if j % 3 == c { share * dot } else { 0.0 })
                        });
                        predicted += kernel.sum::<f64>() / system.tau() * without[(i, 0)];
                    }
                    let expected = smooth[row] - predicted;
                    assert!(
                        (error[c] - expected).abs() < 1e-9,
                        "{share} {reach} {p} {c}: {error:?}, not {expected}"
                    );
                }
            }
        }
    }
}
