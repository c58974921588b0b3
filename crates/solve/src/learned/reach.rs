//! The part of an example that is beyond the reach of the others. If the example is left out, a frame like it
//! is not followed to that part.
use super::vector_strains::VectorStrains;
use rhytid_core::Table;

/// The part beyond the reach, of all features.
pub(crate) struct Beyond {
    /// (F + H)×3P; without rows where there is no bound.
    of_features: Table<f64>,
}

impl Beyond {
    /// Computes the part of each example beyond `reach` times the range of the others, for each component by
    /// itself.
    pub(crate) fn new(strains: &VectorStrains, reach: f64) -> Self {
        let n = 3 * strains.examples();
        let of_component = |d: &[f64], i: usize| {
            let others = (i % 3..n).step_by(3).filter(|j| *j != i).map(|j| reach * d[j]);
            let (least, most) =
                others.fold((0.0_f64, 0.0_f64), |(least, most), x| (least.min(x), most.max(x)));
            d[i] - d[i].clamp(least, most)
        };
        let of_feature = |e| (0..n).map(move |i| of_component(strains.feature(e), i));
        let bounded = if reach.is_finite() { strains.features() } else { 0 };
        let of_features = (0..bounded).flat_map(of_feature).collect();
        Self { of_features: Table::new(bounded as usize, n, of_features) }
    }

    /// Writes `Σ_e ω_e (D_pe − clamp(D_pe)) · D_qe` of a vertex into `beyond`, P×P. The rows are p, the
    /// example that is clamped.
    pub(crate) fn of_vertex(
        &self,
        strains: &VectorStrains,
        features: &[u32],
        weights: &[f64],
        beyond: &mut Table<f64>,
    ) {
        beyond.as_mut_slice().fill(0.0);
        if self.of_features.is_empty() {
            return;
        }
        for (&e, &w) in features.iter().zip(weights).filter(|(_, w)| **w > 0.0) {
            let d = strains.feature(e).as_chunks::<3>().0;
            let of_feature = self.of_features.row(e as usize).as_chunks::<3>().0;
            for (of_example, beyond) in of_feature.iter().zip(beyond.rows_mut()) {
                if *of_example != [0.0; 3] {
                    let dot = |d: &[f64; 3]| d.iter().zip(of_example).map(|(a, b)| a * b).sum::<f64>();
                    beyond.iter_mut().zip(d).for_each(|(beyond, d)| *beyond += w * dot(d));
                }
            }
        }
    }
}
