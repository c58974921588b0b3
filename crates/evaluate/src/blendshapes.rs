//! The usual method for examples: weighted sums of them, fitted to the markers.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use rhytid_core::numbers::dot;
use rhytid_core::{Error, Result};

/// The number of sweeps over the weights. A few dozen leave no visible error.
const SWEEPS: usize = 200;

/// Weighted sums of P examples' displacements. The weights fit the markers best in the least-squares sense.
#[derive(Debug)]
pub(crate) struct Blendshapes {
    /// P rows of 3H: the markers' displacements in each example.
    at_markers: Vec<Vec<f64>>,
    /// The dot products of the rows, P×P.
    gram: Mat<f64>,
}

/// Which weights are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Weights {
    /// From 0 to 1, as a rig of blendshapes has them.
    ZeroToOne,
    /// Any weights. This is a principal component analysis of the examples and the rest pose that keeps all
    /// components.
    Any,
}

impl Blendshapes {
    pub(crate) fn new(at_markers: Vec<Vec<f64>>) -> Self {
        let n = at_markers.len();
        let gram = Mat::from_fn(n, n, |i, j| dot(&at_markers[i], &at_markers[j]));
        Self { at_markers, gram }
    }

    /// The P weights for the markers' 3H displacements.
    ///
    /// # Errors
    /// [`Error::Internal`] if there is no solution in floating point.
    pub(crate) fn fit(&self, displacements: &[f64], weights: Weights) -> Result<Vec<f64>> {
        let n = self.at_markers.len();
        let wanted: Vec<f64> = self.at_markers.iter().map(|row| dot(row, displacements)).collect();
        let trace: f64 = (0..n).map(|i| self.gram[(i, i)]).sum();
        if trace <= 0.0 {
            return Ok(vec![0.0; n]);
        }
        match weights {
            Weights::Any => {
                // Two examples that are the same share their weight.
                let ridge = 1e-9 * trace / n as f64;
                let system = Mat::from_fn(n, n, |i, j| self.gram[(i, j)] + if i == j { ridge } else { 0.0 });
                let factor = system.llt(Side::Lower).map_err(|e| {
                    Error::Internal(format!("the fit of the examples has no solution: {e:?}"))
                })?;
                let solution = factor.solve(Mat::from_fn(n, 1, |i, _| wanted[i]));
                Ok((0..n).map(|i| solution[(i, 0)]).collect())
            }
            Weights::ZeroToOne => {
                let mut w = vec![0.0; n];
                for _ in 0..SWEEPS {
                    for i in (0..n).filter(|&i| self.gram[(i, i)] > 0.0) {
                        let others: f64 = (0..n).filter(|&j| j != i).map(|j| self.gram[(i, j)] * w[j]).sum();
                        w[i] = ((wanted[i] - others) / self.gram[(i, i)]).clamp(0.0, 1.0);
                    }
                }
                Ok(w)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_meet_the_markers() {
        let shapes = Blendshapes::new(vec![vec![1.0, 0.0, 2.0, 0.0], vec![0.0, 1.0, 1.0, 0.0], vec![0.0; 4]]);
        let any = shapes.fit(&[2.0, -1.0, 3.0, 7.0], Weights::Any).unwrap();
        assert!((any[0] - 2.0).abs() < 1e-6 && (any[1] + 1.0).abs() < 1e-6 && any[2].abs() < 1e-6, "{any:?}");
        // Within 0..1 the best second weight is 0, and the first would have to be more than 1.
        assert_eq!(shapes.fit(&[2.0, -1.0, 3.0, 7.0], Weights::ZeroToOne).unwrap(), [1.0, 0.0, 0.0]);
        let within = shapes.fit(&[0.25, 0.5, 1.0, 0.0], Weights::ZeroToOne).unwrap();
        assert!((within[0] - 0.25).abs() < 1e-9 && (within[1] - 0.5).abs() < 1e-9, "{within:?}");
    }
}
