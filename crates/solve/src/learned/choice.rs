//! How much of the linear band is believed (step 7 of the learned method): what predicts examples best that are left out.
use super::linear_band::{LinearSettings, VectorStrains, VertexSystem};
use super::neighborhoods::LinearInfluences;
use rayon::prelude::*;
use rhytid_core::Result;

/// s and λ that are tried where a project names none.
pub(crate) const SHARES: [f64; 2] = [0.2, 1.0];
/// As [`SHARES`].
pub(crate) const RIDGES: [f64; 5] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// Leaving out one of two examples or fewer tells nothing.
const FEWEST_EXAMPLES: usize = 3;

/// Taken where there are fewer examples.
const UNSEEN: (f64, f64) = (0.2, 1e-2);

/// Vertices that are looked at.
const SAMPLES: usize = 1024;

/// A choice of s and λ, and what it is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// s.
    pub share: f64,
    /// λ.
    pub ridge: f64,
    /// The RMS distance, in mesh units, from the smooth part of each example to what the others predict, over a sample of
    /// the surface; NaN where there are too few examples to leave one out.
    pub leave_one_out: f64,
}

/// What is taken, and why.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choice {
    /// The best of the candidates; of equals the first.
    pub(crate) chosen: Candidate,
    /// In the order in which they were tried.
    pub(crate) candidates: Vec<Candidate>,
    /// How the best one predicts the sample; empty where there are too few examples to leave one out.
    pub(crate) predictions: Vec<Prediction>,
}

/// How well a vertex of the sample is predicted in examples that are left out, in mesh units squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Prediction {
    pub(crate) vertex: u32,
    /// Σ_p |e_p|².
    pub(crate) error: f64,
    /// Σ_p |Ŵ_p|²: the error of predicting nothing.
    pub(crate) size: f64,
}

/// Every pair of `shares` and `ridges`, neither of them empty, with its error, and the best of them.
///
/// `area` is the mass of each vertex, 0 at those that are not looked at, such as handles; the sample is fixed by it, and the
/// bits do not depend on the number of threads. σ_m is `marker_noise` in mesh units; `smooth` is Ŵ, V×P×3.
///
/// # Errors
/// As [`VertexSystem::solve`].
pub(crate) fn choose(
    strains: &VectorStrains,
    influences: &LinearInfluences,
    smooth: &[[f64; 3]],
    area: &[f64],
    (shares, ridges): (&[f64], &[f64]),
    marker_noise: f64,
) -> Result<Choice> {
    let examples = strains.examples();
    let pairs = || shares.iter().flat_map(|&share| ridges.iter().map(move |&ridge| (share, ridge)));
    let count = shares.len() * ridges.len();
    if examples < FEWEST_EXAMPLES {
        let (share, ridge) =
            pairs().find(|pair| *pair == UNSEEN).or_else(|| pairs().next()).unwrap_or(UNSEEN);
        let only = Candidate { share, ridge, leave_one_out: f64::NAN };
        return Ok(Choice { chosen: only, candidates: vec![only], predictions: Vec::new() });
    }
    let sample = sample(area, SAMPLES);
    let squares: Vec<Vec<f64>> = sample
        .par_iter()
        .map_init(
            || (VertexSystem::new(examples), vec![0.0; 3 * examples], vec![[0.0; 3]; examples]),
            |(system, z, errors), &v| {
                let of_vertex = v * influences.per_vertex..(v + 1) * influences.per_vertex;
                system.assemble(
                    strains,
                    &influences.features[of_vertex.clone()],
                    &influences.weights[of_vertex],
                );
                let smooth = &smooth[v * examples..][..examples];
                pairs()
                    .map(|(share, ridge)| {
                        let settings = LinearSettings { share, ridge, marker_noise };
                        if system.solve(settings, smooth.as_flattened(), z)? {
                            system.leave_one_out(z, errors);
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
    let better =
        |a: usize, b: usize| if candidates[b].leave_one_out < candidates[a].leave_one_out { b } else { a };
    let best = (0..count).reduce(better).unwrap_or(0);
    let predictions = sample.iter().zip(&squares).map(|(&v, of_vertex)| Prediction {
        vertex: v as u32,
        error: of_vertex[best],
        size: smooth[v * examples..][..examples].as_flattened().iter().map(|w| w * w).sum(),
    });
    Ok(Choice { chosen: candidates[best], predictions: predictions.collect(), candidates })
}

/// `count` vertices at equal distances in the sum of the areas: a vertex of a large area may be there more than once.
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
