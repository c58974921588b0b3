//! The prior: what the expressions of other faces leave of their shells, as a linear function of vector
//! strains. All of it goes into the basis, so a frame costs nothing more.
use super::neighborhoods::LinearInfluences;
use super::vector_strains::VectorStrains;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rayon::prelude::*;
use rhytid_core::{Error, Result, Table};

/// λ of the prior. On pairs of heads, a tenth or ten times of it changes the error by less than 5 %.
const RIDGE: f64 = 1e-3;

/// What a prior adds to the basis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PriorBand {
    /// The vector strains of the expressions.
    pub(crate) strains: VectorStrains,
    /// g, V×(K + 8) as the features are: ΔB is `Σ_e g_ve D_e`.
    gains: Table<f64>,
    /// What ΔB adds to the shell in the face's own examples, V×P in mesh units.
    pub(crate) predicted: Table<[f64; 3]>,
}

impl PriorBand {
    /// Learns from the smooth residual of the expressions after the shell, Ŵ (V×G in mesh units).
    ///
    /// The three axes move alike. So the kernel is K1 of the linear band, and the gains of a vertex are
    /// `g = √ω ĝ` with `(ΦᵀΦ + τ(λ + n/τ) I) ĝ = Φᵀ Ŵ` and `Φ_(pc),e = √ω_e D_pec`. This system is as large
    /// as the features of a vertex are many, whatever the number of expressions is.
    ///
    /// `of_examples` are the vector strains of the face's own examples, and `marker_noise` is σ_m in mesh
    /// units.
    ///
    /// # Errors
    /// [`Error::Internal`] if a system has no solution in floating point.
    pub(crate) fn learn(
        strains: VectorStrains,
        of_examples: &VectorStrains,
        influences: &LinearInfluences,
        smooth: &Table<[f64; 3]>,
        marker_noise: f64,
    ) -> Result<Self> {
        let mut gains = Table::filled(smooth.height(), influences.weights.columns(), 0.0);
        gains
            .par_rows_mut()
            .enumerate()
            .map(|(v, gains)| {
                let smooth = smooth.row(v).as_flattened();
                let (features, omega) = (influences.features.row(v), influences.weights.row(v));
                let phi = Mat::from_fn(smooth.len(), features.len(), |i, e| {
                    if omega[e] > 0.0 { omega[e].sqrt() * strains.feature(features[e])[i] } else { 0.0 }
                });
                let trace = phi.squared_norm_l2();
                if trace == 0.0 || smooth.iter().all(|w| *w == 0.0) {
                    return Ok(());
                }
                let noise: f64 = features.iter().zip(omega).map(|(&e, w)| w * strains.noise(e)).sum();
                let diagonal = RIDGE * trace / smooth.len() as f64 + marker_noise.powi(2) * noise;
                let mut matrix = phi.transpose() * &phi;
                (0..features.len()).for_each(|e| matrix[(e, e)] += diagonal);
                let right = phi.transpose() * Mat::from_fn(smooth.len(), 1, |i, _| smooth[i]);
                let factor = matrix.llt(Side::Lower).map_err(|e| {
                    Error::Internal(format!("the prior of vertex {v} has no solution: {e:?}"))
                })?;
                let found = factor.solve(&right);
                for (e, (gain, omega)) in gains.iter_mut().zip(omega).enumerate() {
                    *gain = omega.sqrt() * found[(e, 0)];
                }
                Ok(())
            })
            .collect::<Result<()>>()?;
        let predicted = predicted(&gains, of_examples, influences);
        Ok(Self { strains, gains, predicted })
    }

    /// Takes only this part of it.
    pub(crate) fn scale(&mut self, weight: f64) {
        let predicted = self.predicted.as_mut_slice().as_flattened_mut();
        self.gains.as_mut_slice().iter_mut().chain(predicted).for_each(|x| *x *= weight);
    }

    /// Subtracts what it adds in the examples from their smooth residual, V×P.
    pub(crate) fn subtract_from(&self, smooth: &mut Table<[f64; 3]>) {
        let (to, from) = (smooth.as_mut_slice().as_flattened_mut(), self.predicted.as_slice().as_flattened());
        to.iter_mut().zip(from).for_each(|(to, from)| *to -= from);
    }

    /// Adds ΔB to the basis (V×H), and its gains to `feature_gains`.
    pub(crate) fn add_to(
        &self,
        influences: &LinearInfluences,
        basis: &mut Table<f64>,
        feature_gains: &mut Table<f64>,
    ) {
        let rows = basis.par_rows_mut().zip(feature_gains.par_rows_mut());
        rows.enumerate().for_each(|(v, (row, feature_gains))| {
            let features = influences.features.row(v);
            for ((&e, gain), sum) in features.iter().zip(self.gains.row(v)).zip(feature_gains) {
                if *gain != 0.0 {
                    self.strains.add_to_row(e, *gain, row);
                    *sum += gain;
                }
            }
        });
    }
}

/// What `Σ_e g_ve D_e` is in the examples of `strains`, V×P in mesh units.
fn predicted(gains: &Table<f64>, strains: &VectorStrains, influences: &LinearInfluences) -> Table<[f64; 3]> {
    let mut predicted = Table::filled(gains.height(), strains.examples(), [0.0; 3]);
    predicted.par_rows_mut().enumerate().for_each(|(v, predicted)| {
        let predicted = predicted.as_flattened_mut();
        for (&e, gain) in influences.features.row(v).iter().zip(gains.row(v)) {
            predicted.iter_mut().zip(strains.feature(e)).for_each(|(x, d)| *x += gain * d);
        }
    });
    predicted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learned::linear_band::{LinearSettings, linear_band};
    use rhytid_core::{HandleId, NoProgress};

    /// Numbers without a pattern, in −1..1.
    fn number(i: usize) -> f64 {
        ((i as f64 * 12.9898).sin() * 43758.5453).fract()
    }

    #[test]
    fn it_is_a_linear_band_whose_axes_move_alike() {
        let (vertices, examples, handles) = (3, 7, 6);
        let displacements: Vec<Vec<[f64; 3]>> = (0..examples)
            .map(|p| (0..handles).map(|h| [0, 1, 2].map(|c| number(100 * p + 10 * h + c))).collect())
            .collect();
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0]].map(|pair| pair.map(HandleId));
        let strains = VectorStrains::new(&displacements, &edges, &[1.0, 1.5, 0.7, 1.0, 2.0, 1.2], 1.1);
        let influences = LinearInfluences {
            features: Table::new(vertices, 4, (0..12).map(|i| i % 11).collect()),
            weights: Table::new(vertices, 4, (0..12).map(|i| if i == 5 { 0.0 } else { 0.25 }).collect()),
        };
        let smooth: Vec<[f64; 3]> =
            (0..vertices * examples).map(|i| [1, 2, 3].map(|c| number(1000 + 10 * i + c))).collect();
        let smooth = Table::new(vertices, examples, smooth);
        let settings = LinearSettings { share: 0.0, ridge: RIDGE, marker_noise: 0.02, reach: f64::INFINITY };
        let mut expected_basis = Table::filled(vertices, handles, 0.0);
        let kept = vec![1.0; vertices];
        let expected =
            linear_band(&strains, &influences, &smooth, settings, &kept, &mut expected_basis, &NoProgress)
                .unwrap();

        let mut prior = PriorBand::learn(strains.clone(), &strains, &influences, &smooth, 0.02).unwrap();
        prior.scale(0.5);
        let (mut basis, mut gains) = (Table::filled(vertices, handles, 0.0), Table::filled(vertices, 4, 0.0));
        prior.add_to(&influences, &mut basis, &mut gains);
        let near = |found: &[f64], expected: &[f64]| {
            found.iter().zip(expected).all(|(found, expected)| (2.0 * found - expected).abs() < 1e-9)
        };
        assert!(near(gains.as_slice(), expected.feature_gains.as_slice()));
        assert!(near(basis.as_slice(), expected_basis.as_slice()));
        assert!(expected_basis.as_slice().iter().any(|b| b.abs() > 0.1));

        // In an example, the basis moves a vertex as predicted.
        let mut left = smooth.clone();
        prior.subtract_from(&mut left);
        for v in 0..vertices {
            for (p, u) in displacements.iter().enumerate() {
                for c in 0..3 {
                    let moved: f64 = basis.row(v).iter().zip(u).map(|(b, u)| b * u[c]).sum();
                    let expected = smooth.row(v)[p][c] - moved;
                    assert!((left.row(v)[p][c] - expected).abs() < 1e-9, "{v} {p} {c}");
                }
            }
        }
    }
}
