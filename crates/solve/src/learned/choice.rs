//! The choice of the linear band's share s, its ridge λ and the reach (step 7 of the learned method): those
//! with the least error at left-out examples and at mixtures of the examples.
use super::linear_band::{LinearSettings, VertexSystem};
use super::neighborhoods::LinearInfluences;
use super::reach::Beyond;
use super::vector_strains::VectorStrains;
use glam::DMat3;
use rayon::prelude::*;
use rhytid_core::numbers::dot;
use rhytid_core::{Error, LearnedSettings, Result, Table};

/// The values of s that are tried if a project names none.
const SHARES: [f64; 3] = [0.1, 0.3, 1.0];
/// The values of the reach that are tried if a project names none.
const REACHES: [f64; 2] = [1.0, 1.5];
/// The values of λ that are tried if a project names none. With the last one nothing is learned.
const RIDGES: [f64; 6] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0, NOTHING];
/// A ridge at which the linear band is a millionth of what it could be, so the shell alone is left.
const NOTHING: f64 = LearnedSettings::LARGEST_RIDGE;

/// The fewest examples of which one can be left out.
pub(super) const FEWEST_LEFT_OUT: usize = 2;
/// The fewest examples from which s, λ and the reach are chosen. Fewer examples predict each other by chance.
const FEWEST_EXAMPLES: usize = 4;
/// s, λ and the reach where there are fewer examples. On five heads, they leave least of left-out examples.
const SHARE_OF_FEW: f64 = 0.2;
const RIDGE_OF_FEW: f64 = 1e-2;
const REACH_OF_FEW: f64 = 1.0;

/// Errors within this part of the least error count as equal. Of these candidates, the smallest ridge is
/// chosen: all examples predict more than all but one do, and need less of a ridge.
const AS_GOOD: f64 = 0.1;

/// The number of vertices in the sample.
pub(super) const SAMPLES: usize = 1024;

/// A choice of s, λ and the reach, with its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// s.
    pub share: f64,
    /// λ.
    pub ridge: f64,
    /// How far vector strains are followed.
    pub reach: f64,
    /// How much of the prior is taken, 0 to 1; 0 without a prior.
    pub prior: f64,
    /// The RMS distance from the smooth part of each example to its prediction by the others, in mesh units.
    ///
    /// The mean is over a sample of the surface. NaN where there are too few examples to leave one out.
    pub leave_one_out: f64,
    /// The RMS distance from the smooth part of each example to what the linear band makes of it with all
    /// examples, in mesh units. NaN where there are too few examples to leave one out.
    pub misfit: f64,
}

impl Candidate {
    /// The RMS error that is expected of a frame: half of the frames are mixtures of the examples, which
    /// [`Candidate::misfit`] stands for, and half are like none of the others.
    pub fn expected(&self) -> f64 {
        (0.5 * (self.leave_one_out.powi(2) + self.misfit.powi(2))).sqrt()
    }
}

/// What a prior says of the examples, and how much of it is to be taken.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OfPrior<'a> {
    /// What the prior adds to the shell in each example, V×P in mesh units.
    pub(crate) predicted: &'a Table<[f64; 3]>,
    /// The weight of the prior. `None` takes the one with the least expected error.
    pub(crate) weight: Option<f64>,
}

/// The squared error as a function of the prior's weight w: `error − 2w common + w² prior`.
#[derive(Debug, Clone, Copy, Default)]
struct Square {
    error: f64,
    common: f64,
    prior: f64,
}

impl Square {
    /// The square of `error − w of_prior`.
    fn new(error: &[f64], of_prior: &[f64]) -> Self {
        Self { error: dot(error, error), common: dot(error, of_prior), prior: dot(of_prior, of_prior) }
    }

    fn add(&mut self, other: Self) {
        self.error += other.error;
        self.common += other.common;
        self.prior += other.prior;
    }

    /// The value at w.
    fn at(&self, weight: f64) -> f64 {
        (self.error - 2.0 * weight * self.common + weight * weight * self.prior).max(0.0)
    }
}

/// Sums of squares over the examples at one vertex.
#[derive(Debug, Clone, Copy, Default)]
struct Squares {
    left_out: Square,
    misfit: Square,
}

impl Squares {
    /// The prior's weight in 0..1 with the least expected error; 0 where the prior says nothing.
    fn best_weight(&self) -> f64 {
        let prior = self.left_out.prior + self.misfit.prior;
        if prior > 0.0 { ((self.left_out.common + self.misfit.common) / prior).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The prior's weight where there is one example. It is predicted by the prior alone, and one scan proves
    /// little. So the best weight counts by the part of the square that it explains.
    fn weight_of_one(&self) -> f64 {
        let weight = self.best_weight();
        match self.left_out.error {
            error if error > 0.0 => weight * (1.0 - self.left_out.at(weight) / error).max(0.0),
            _ => weight,
        }
    }
}

/// One right-hand side of a vertex's system: what is to be learned, or what the prior says of it.
#[derive(Clone)]
struct Side {
    z: Vec<f64>,
    /// What the band leaves of it, 3P.
    left: Vec<f64>,
    /// The errors of left-out examples, P.
    errors: Vec<[f64; 3]>,
}

impl Side {
    fn new(examples: usize) -> Self {
        Self { z: vec![0.0; 3 * examples], left: vec![0.0; 3 * examples], errors: vec![[0.0; 3]; examples] }
    }
}

/// All candidates with their errors, and the best of them.
///
/// `area` is the mass of each vertex, and 0 at vertices that do not count, such as handles. It determines the
/// sample, and the bits do not depend on the number of threads. `marker_noise` is σ_m in mesh units, and
/// `smooth` is Ŵ, V×P. A left-out example is followed as far as a frame is. With a prior, the others predict
/// what the prior leaves of an example, and a single example is predicted by the prior alone.
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
    prior: Option<OfPrior>,
) -> Result<(Candidate, Vec<Candidate>)> {
    let examples = strains.examples();
    let is_chosen = examples >= FEWEST_EXAMPLES;
    let tried = |set: Option<f64>, few: f64, all: &[f64]| match set {
        Some(set) => vec![set],
        None if is_chosen => all.to_vec(),
        None => vec![few],
    };
    let shares = tried(settings.share, SHARE_OF_FEW, &SHARES);
    let ridges = tried(settings.ridge, RIDGE_OF_FEW, &RIDGES);
    let reaches = match examples {
        // The basis alone has no limit.
        0 if prior.is_some() => vec![f64::INFINITY],
        _ => tried(settings.reach, REACH_OF_FEW, &REACHES),
    };
    if examples < if prior.is_some() { 1 } else { FEWEST_LEFT_OUT } {
        let only = Candidate {
            share: shares[0],
            ridge: ridges[0],
            reach: reaches[0],
            prior: prior.map_or(0.0, |prior| prior.weight.unwrap_or(1.0)),
            leave_one_out: f64::NAN,
            misfit: f64::NAN,
        };
        return Ok((only, vec![only]));
    }
    let (shares, ridges) = (&shares, &ridges);
    let systems = || shares.iter().flat_map(|&share| ridges.iter().map(move |&ridge| (share, ridge)));
    let beyond: Vec<Beyond> = reaches.iter().map(|&reach| Beyond::new(strains, reach)).collect();
    let squares: Vec<Vec<Squares>> = sample(area, SAMPLES)
        .into_par_iter()
        .map_init(
            || {
                let of_vertex = vec![Table::filled(examples, examples, DMat3::ZERO); reaches.len()];
                let sides = vec![Side::new(examples); if prior.is_some() { 2 } else { 1 }];
                (VertexSystem::new(examples), sides, of_vertex)
            },
            |(system, sides, of_vertex), v| {
                let (features, omega) = (influences.features.row(v), influences.weights.row(v));
                system.assemble(strains, features, omega);
                for (beyond, of_vertex) in beyond.iter().zip(&mut *of_vertex) {
                    beyond.of_vertex(strains, features, omega, of_vertex);
                }
                let rows = [Some(smooth.row(v)), prior.map(|prior| prior.predicted.row(v))];
                let mut squares = Vec::with_capacity(shares.len() * ridges.len() * reaches.len());
                for (share, ridge) in systems() {
                    let settings = LinearSettings { share, ridge, marker_noise, reach: f64::INFINITY };
                    let mut is_solved = false;
                    for (side, row) in sides.iter_mut().zip(rows.iter().flatten()) {
                        is_solved = system.solve(settings, row.as_flattened(), &mut side.z)?;
                        match is_solved {
                            true => system.left(settings, &side.z, &mut side.left),
                            false => side.left.copy_from_slice(row.as_flattened()),
                        }
                    }
                    let [first, others @ ..] = &mut sides[..] else { continue };
                    let mut other = others.first_mut();
                    let of_prior = other.as_deref().map_or(&[][..], |side| &side.left);
                    let misfit = Square::new(&first.left, of_prior);
                    for of_vertex in &*of_vertex {
                        let sides = std::iter::once(&mut *first).chain(other.as_deref_mut());
                        for (side, row) in sides.zip(rows.iter().flatten()) {
                            match is_solved {
                                true => system.leave_one_out(settings, &side.z, of_vertex, &mut side.errors),
                                false => side.errors.copy_from_slice(row),
                            }
                        }
                        let of_prior = other.as_deref().map_or(&[][..], |side| side.errors.as_flattened());
                        let left_out = Square::new(first.errors.as_flattened(), of_prior);
                        squares.push(Squares { left_out, misfit });
                    }
                }
                Ok(squares)
            },
        )
        .collect::<Result<_>>()?;
    let count = (squares.len() * examples).max(1) as f64;
    let sums = |i: usize| {
        let mut sums = Squares::default();
        for of_vertex in &squares {
            sums.left_out.add(of_vertex[i].left_out);
            sums.misfit.add(of_vertex[i].misfit);
        }
        sums
    };
    let all = systems().flat_map(|(share, ridge)| reaches.iter().map(move |&reach| (share, ridge, reach)));
    let candidates: Vec<Candidate> = all
        .enumerate()
        .map(|(i, (share, ridge, reach))| {
            let sums = sums(i);
            let weight = prior.map_or(0.0, |prior| {
                prior.weight.unwrap_or_else(|| match examples {
                    1 => sums.weight_of_one(),
                    _ => sums.best_weight(),
                })
            });
            Candidate {
                share,
                ridge,
                reach,
                prior: weight,
                leave_one_out: (sums.left_out.at(weight) / count).sqrt(),
                misfit: (sums.misfit.at(weight) / count).sqrt(),
            }
        })
        .collect();
    let best = candidates.iter().copied().min_by(|a, b| a.expected().total_cmp(&b.expected()));
    let best = best.ok_or_else(|| Error::Internal("there is no share or no ridge to choose from".into()))?;
    let as_good = |c: &&Candidate| {
        (c.share, c.reach) == (best.share, best.reach)
            && c.ridge < NOTHING
            && c.expected() <= (1.0 + AS_GOOD) * best.expected()
    };
    let boldest = candidates.iter().filter(as_good).min_by(|a, b| a.ridge.total_cmp(&b.ridge));
    Ok((boldest.copied().unwrap_or(best), candidates))
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
