//! The choice of the linear band's share s and ridge λ (step 7 of the learned method): those that best
//! predict left-out examples.
use super::linear_band::{LinearSettings, VertexSystem};
use super::neighborhoods::LinearInfluences;
use super::reach::Beyond;
use super::vector_strains::VectorStrains;
use rayon::prelude::*;
use rhytid_core::{Error, LearnedSettings, Result, Table};

/// The values of s that are tried if a project names none and frames are followed without a bound.
const SHARES: [f64; 2] = [0.2, 1.0];
/// The value of s if frames are followed up to a bound. The part that does not belong to the share is in the
/// basis, which has no bound. Leaving examples out does not test poses that are unlike all examples.
const BOUNDED_SHARES: [f64; 1] = [1.0];
/// The values of λ that are tried if a project names none.
const RIDGES: [f64; 4] = [1e-4, 1e-3, 1e-2, 1e-1];

/// The fewest examples for which leaving one out is meaningful.
const FEWEST_EXAMPLES: usize = 3;

/// λ where there are fewer examples.
const UNSEEN: f64 = 1e-2;

/// Errors within this part of the least error count as equal. Of these candidates, the largest ridge is
/// chosen, because it is the calmest.
const AS_GOOD: f64 = 0.02;

/// The number of vertices in the sample.
const SAMPLES: usize = 1024;

/// A pair of s and λ, with its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// s.
    pub share: f64,
    /// λ.
    pub ridge: f64,
    /// The RMS distance from the smooth part of each example to its prediction by the others, in mesh units.
    ///
    /// The mean is over a sample of the surface. NaN where there are too few examples to leave one out.
    pub leave_one_out: f64,
}

/// All candidate pairs of shares and ridges with their errors, and the best of them.
///
/// `area` is the mass of each vertex, and 0 at vertices that do not count, such as handles. It determines the
/// sample, and the bits do not depend on the number of threads. `marker_noise` is σ_m in mesh units, and
/// `smooth` is Ŵ, V×P. A left-out example is followed as far as a frame is.
///
/// # Errors
/// As [`VertexSystem::solve`].
pub(crate) fn choose(
    strains: &VectorStrains,
    influences: &LinearInfluences,
    smooth: &Table<[f64; 3]>,
    area: &[f64],
    settings: &LearnedSettings,
    marker_noise: f64,
) -> Result<(Candidate, Vec<Candidate>)> {
    let (examples, reach) = (strains.examples(), settings.reach);
    let shares = match &settings.share {
        Some(share) => std::slice::from_ref(share),
        None if reach.is_finite() => &BOUNDED_SHARES,
        None => &SHARES[..],
    };
    let ridges = settings.ridge.as_ref().map_or(&RIDGES[..], std::slice::from_ref);
    let pairs = || shares.iter().flat_map(|&share| ridges.iter().map(move |&ridge| (share, ridge)));
    let count = shares.len() * ridges.len();
    if examples < FEWEST_EXAMPLES {
        let (share, ridge) = (shares[0], settings.ridge.unwrap_or(UNSEEN));
        let only = Candidate { share, ridge, leave_one_out: f64::NAN };
        return Ok((only, vec![only]));
    }
    let beyond = Beyond::new(strains, reach);
    let squares: Vec<Vec<f64>> = sample(area, SAMPLES)
        .into_par_iter()
        .map_init(
            || {
                let system = VertexSystem::new(examples);
                let beyond = Table::filled(examples, examples, 0.0);
                (system, vec![0.0; 3 * examples], vec![[0.0; 3]; examples], beyond)
            },
            |(system, z, errors, of_vertex), v| {
                let (features, omega) = (influences.features.row(v), influences.weights.row(v));
                system.assemble(strains, features, omega);
                beyond.of_vertex(strains, features, omega, of_vertex);
                let smooth = smooth.row(v);
                pairs()
                    .map(|(share, ridge)| {
                        let settings = LinearSettings { share, ridge, marker_noise, reach };
                        if system.solve(settings, smooth.as_flattened(), z)? {
                            system.leave_one_out(settings, z, of_vertex, errors);
                        } else {
                            errors.copy_from_slice(smooth);
                        }
                        Ok(errors.as_flattened().iter().map(|x| x * x).sum())
                    })
                    .collect::<Result<Vec<f64>>>()
            },
        )
        .collect::<Result<_>>()?;
    let mean = |i: usize| {
        squares.iter().map(|of_vertex| of_vertex[i]).sum::<f64>() / (squares.len() * examples).max(1) as f64
    };
    let candidates: Vec<Candidate> = pairs()
        .zip(0..count)
        .map(|((share, ridge), i)| Candidate { share, ridge, leave_one_out: mean(i).sqrt() })
        .collect();
    let best = candidates.iter().copied().min_by(|a, b| a.leave_one_out.total_cmp(&b.leave_one_out));
    let best = best.ok_or_else(|| Error::Internal("there is no share or no ridge to choose from".into()))?;
    let as_good =
        |c: &&Candidate| c.share == best.share && c.leave_one_out <= (1.0 + AS_GOOD) * best.leave_one_out;
    let calmest = candidates.iter().filter(as_good).max_by(|a, b| a.ridge.total_cmp(&b.ridge));
    Ok((calmest.copied().unwrap_or(best), candidates))
}

/// `count` vertices at equal distances in the sum of the areas. A vertex with a large area may occur more
/// than once.
pub(super) fn sample(area: &[f64], count: usize) -> Vec<usize> {
    let total: f64 = area.iter().sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let mut vertices = Vec::with_capacity(count);
    let mut sum = 0.0;
    for (v, area) in area.iter().enumerate() {
        sum += area;
        while vertices.len() < count && (vertices.len() as f64 + 0.5) / count as f64 * total < sum {
            vertices.push(v);
        }
    }
    vertices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sample_goes_by_area() {
        let found = sample(&[1.0, 0.0, 3.0], SAMPLES);
        assert_eq!(found.len(), SAMPLES);
        assert_eq!(found.iter().filter(|v| **v == 0).count(), SAMPLES / 4);
        assert!(!found.contains(&1));
        assert!(sample(&[0.0; 3], SAMPLES).is_empty());
    }
}
