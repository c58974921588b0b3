//! The part of an example that is beyond the reach of the others. If the example is left out, a frame like it
//! is not followed to that part.
use super::vector_strains::VectorStrains;
use glam::{DMat3, DVec3};
use rhytid_core::Table;
use rhytid_kernels::vec3;
use rhytid_kernels::vector_differences::limited as limited_to;

/// The part beyond the reach, of all features.
pub(crate) struct Beyond {
    /// (F + H)×3P; without rows where there is no bound.
    of_features: Table<f64>,
}

impl Beyond {
    /// Computes how much longer each vector strain of an example is than `reach` times the longest of the
    /// others and of the prior's expressions, as a vector in its direction.
    pub(crate) fn new(strains: &VectorStrains, reach: f64) -> Self {
        let limited = if reach.is_finite() { strains.features() } else { 0 };
        let mut of_features = Table::filled(limited as usize, 3 * strains.examples(), 0.0);
        for (e, beyond) in of_features.rows_mut().enumerate() {
            let d = strains.feature(e as u32).as_chunks::<3>().0;
            let of_prior = strains.prior_lengths().get(e).copied().unwrap_or(0.0);
            let longest = |p: usize| {
                let others = d.iter().enumerate().filter(|(q, _)| *q != p);
                others.map(|(_, d)| vec3::length(*d)).fold(of_prior, f64::max)
            };
            for (p, (d, beyond)) in d.iter().zip(beyond.as_chunks_mut::<3>().0).enumerate() {
                *beyond = vec3::sub(*d, limited_to(*d, reach * longest(p)));
            }
        }
        Self { of_features }
    }

    /// Writes `Σ_e ω_e (D_pe − limited(D_pe)) D_qeᵀ` of a vertex into `beyond`, P×P. The rows are p, the
    /// example that is limited.
    pub(crate) fn of_vertex(
        &self,
        strains: &VectorStrains,
        features: &[u32],
        weights: &[f64],
        beyond: &mut Table<DMat3>,
    ) {
        beyond.as_mut_slice().fill(DMat3::ZERO);
        if self.of_features.is_empty() {
            return;
        }
        for (&e, &w) in features.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
            let d = strains.feature(e).as_chunks::<3>().0;
            let of_feature = self.of_features.row(e as usize).as_chunks::<3>().0;
            for (of_example, beyond) in of_feature.iter().zip(beyond.rows_mut()) {
                if *of_example != [0.0; 3] {
                    let of_example = w * DVec3::from_array(*of_example);
                    let times =
                        |d: &[f64; 3]| DMat3::from_cols_array_2d(&d.map(|d| (d * of_example).to_array()));
                    beyond.iter_mut().zip(d).for_each(|(beyond, d)| *beyond += times(d));
                }
            }
        }
    }
}
