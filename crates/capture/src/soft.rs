//! Soft markers: a take without the noise of its markers, by the motion that its markers have in common.
use crate::tracks::{Tracks, noise};
use faer::{Mat, Side};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Error, Result, Take};

/// Powers of ten from the first to the last, and the steps of each: the smoothing that is tried.
const POWERS: std::ops::RangeInclusive<i32> = -2..=5;
const STEPS_OF_POWER: i32 = 2;

/// Frequencies at which the filter is summed up.
const FREQUENCIES: usize = 2048;

/// A marker stays within so many standard deviations of its noise. One of 1,000 is farther off by chance.
const MOST: f64 = 4.0;

/// A component has a motion if its variance is above the largest of noise by this factor.
const BEYOND_EDGE: f64 = 1.2;

/// The fewest frames from which noise is told.
const FEWEST_FRAMES: usize = 8;

/// The noise of a take's markers: the standard deviation of a coordinate, in the take's unit. 0 where the
/// take is too short to tell.
///
/// It is from the median of the second differences in time, which hardly any motion has.
pub fn marker_noise(take: &Take) -> f64 {
    let (frames, markers) = (take.times.len(), take.labels.len());
    if frames < FEWEST_FRAMES {
        return 0.0;
    }
    let at = |m: usize| (0..frames).map(move |f| DVec3::from_array(take.positions[f * markers + m]));
    noise(&Tracks { columns: (0..markers).map(|m| at(m).collect()).collect(), rate: 1.0 })
}

/// Takes the markers' noise out of a take, and returns what [`marker_noise`] was. Where that is 0, the take
/// is not changed.
///
/// A few of the take's principal components have nearly all of the face's motion, and the others are mostly
/// noise. Each component is smoothed in time by Whittaker's smoother, `a = (I + λ DᵀD)⁻¹ y` with D the second
/// differences. Its λ has the least expected error by Mallows' C_p, `‖y − a‖² + 2s² tr (I + λ DᵀD)⁻¹`; λ = 0
/// is tried, too. s² is the variance of the noise, or that of the component if it is no larger than noise
/// alone can be. No marker moves by more than four standard deviations of its noise, so a motion that is
/// larger than noise is not lost.
///
/// The take has no missing markers.
///
/// # Errors
/// [`Error::Internal`] if the components cannot be computed, as for positions that are not finite.
pub fn soften(take: &mut Take) -> Result<f64> {
    let (frames, markers) = (take.times.len(), take.labels.len());
    let sigma = marker_noise(take);
    if sigma == 0.0 {
        return Ok(0.0);
    }
    let size = 3 * markers;
    let numbers = take.positions.as_flattened();
    let means: Vec<f64> =
        (0..size).map(|i| numbers.iter().skip(i).step_by(size).sum::<f64>() / frames as f64).collect();
    let centred = Mat::from_fn(frames, size, |f, i| numbers[f * size + i] - means[i]);
    let covariance = centred.transpose() * &centred;
    let eigen = covariance
        .self_adjoint_eigen(Side::Lower)
        .map_err(|e| Error::Internal(format!("the components of the take cannot be computed: {e:?}")))?;
    let components = eigen.U();
    let scores = &centred * components;
    // Components of noise alone have up to this variance (Marčenko and Pastur), as the numbers are many and
    // the frames few.
    let edge = (sigma * (1.0 + (size as f64 / frames as f64).sqrt())).powi(2);
    let smoothers: Vec<Smoother> = (POWERS.start() * STEPS_OF_POWER..=POWERS.end() * STEPS_OF_POWER)
        .map(|step| Smoother::new(10_f64.powf(f64::from(step) / f64::from(STEPS_OF_POWER)), frames))
        .collect();
    let smoothed = |k: usize| {
        let raw = scores.col_as_slice(k);
        let variance = raw.iter().map(|y| y * y).sum::<f64>() / frames as f64;
        let noise = if variance <= BEYOND_EDGE * edge { variance } else { sigma * sigma };
        // Not to smooth leaves all of the noise.
        let (mut best, mut least) = (raw.to_vec(), noise * frames as f64);
        let mut smooth = raw.to_vec();
        for smoother in &smoothers {
            smooth.copy_from_slice(raw);
            smoother.apply(&mut smooth);
            let left: f64 = raw.iter().zip(&smooth).map(|(y, a)| (y - a).powi(2)).sum();
            let expected = left + (2.0 * smoother.kept - 1.0) * noise * frames as f64;
            if expected < least {
                least = expected;
                best.copy_from_slice(&smooth);
            }
        }
        best
    };
    let series: Vec<Vec<f64>> = (0..size).into_par_iter().map(smoothed).collect();
    let smooth = Mat::from_fn(frames, size, |f, k| series[k][f]) * components.transpose();
    for (f, frame) in take.positions.chunks_exact_mut(markers).enumerate() {
        for (m, position) in frame.iter_mut().enumerate() {
            let there = [0, 1, 2].map(|c| smooth[(f, 3 * m + c)] + means[3 * m + c]);
            let was = DVec3::from_array(*position);
            let by = (DVec3::from_array(there) - was).clamp_length_max(MOST * sigma);
            *position = (was + by).to_array();
        }
    }
    Ok(sigma)
}

/// Whittaker's smoother for one λ: the factor `L Δ Lᵀ` of `I + λ DᵀD`, which has two bands below its
/// diagonal.
struct Smoother {
    /// Δ, and the two bands of L: for each frame.
    diagonal: Vec<f64>,
    lower: Vec<[f64; 2]>,
    /// The part of white noise's variance that is kept: `tr (I + λ DᵀD)⁻¹` per frame.
    kept: f64,
}

impl Smoother {
    fn new(lambda: f64, frames: usize) -> Self {
        // The bands of DᵀD, where each frame but the first and the last has a second difference.
        let mut bands = vec![[0.0; 3]; frames];
        for second in 0..frames - 2 {
            let weights = [1.0, -2.0, 1.0];
            for (i, of_i) in weights.iter().enumerate() {
                for (j, of_j) in weights.iter().enumerate().take(i + 1) {
                    bands[second + i][i - j] += lambda * of_i * of_j;
                }
            }
        }
        let (mut diagonal, mut lower) = (vec![0.0; frames], vec![[0.0; 2]; frames]);
        for f in 0..frames {
            let [own, first, second] = bands[f];
            if f >= 2 {
                lower[f][1] = second / diagonal[f - 2];
            }
            if f >= 1 {
                let through = if f >= 2 { lower[f][1] * diagonal[f - 2] * lower[f - 1][0] } else { 0.0 };
                lower[f][0] = (first - through) / diagonal[f - 1];
            }
            let mut square = 1.0 + own;
            for (back, l) in lower[f].iter().enumerate().filter(|(back, _)| f > *back) {
                square -= l * l * diagonal[f - 1 - back];
            }
            diagonal[f] = square;
        }
        let gain = |i: usize| {
            let turn = std::f64::consts::PI * (i as f64 + 0.5) / FREQUENCIES as f64;
            1.0 / (1.0 + lambda * (2.0 - 2.0 * turn.cos()).powi(2))
        };
        let kept = (0..FREQUENCIES).map(gain).sum::<f64>() / FREQUENCIES as f64;
        Self { diagonal, lower, kept }
    }

    /// Smooths one number per frame.
    fn apply(&self, values: &mut [f64]) {
        let frames = values.len();
        for f in 1..frames {
            let two_back = if f >= 2 { self.lower[f][1] * values[f - 2] } else { 0.0 };
            values[f] -= self.lower[f][0] * values[f - 1] + two_back;
        }
        for f in (0..frames).rev() {
            let one = if f + 1 < frames { self.lower[f + 1][0] * values[f + 1] } else { 0.0 };
            let two = if f + 2 < frames { self.lower[f + 2][1] * values[f + 2] } else { 0.0 };
            values[f] = values[f] / self.diagonal[f] - one - two;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smoother_solves_its_system() {
        let (frames, lambda) = (9, 3.7);
        let values: Vec<f64> = (0..frames).map(|f| ((f * f) as f64 * 0.7).sin()).collect();
        let mut smooth = values.clone();
        Smoother::new(lambda, frames).apply(&mut smooth);
        for (f, value) in values.iter().enumerate() {
            let second = |f: usize| smooth[f] - 2.0 * smooth[f + 1] + smooth[f + 2];
            let mut sum = smooth[f];
            for (back, weight) in [1.0, -2.0, 1.0].iter().enumerate() {
                if f >= back && f - back + 2 < frames {
                    sum += lambda * weight * second(f - back);
                }
            }
            assert!((sum - value).abs() < 1e-12, "{f}: {sum} {value}");
        }
    }

    #[test]
    fn noise_is_taken_out_and_motion_stays() {
        // Three motions of thirty markers, one of them a blink of five frames.
        let motion = |f: usize, k: usize| match k {
            0 => 4.0 * (f as f64 * 0.05).sin(),
            1 => 2.0 * (f as f64 * 0.17).sin(),
            _ => {
                if (200..205).contains(&(f % 250)) {
                    3.0
                } else {
                    0.0
                }
            }
        };
        let shape = |m: usize, c: usize, k: usize| ((m * 7 + c * 3 + k * 5) as f64).sin();
        let truth: Vec<[f64; 3]> = (0..600 * 30)
            .map(|i| [0, 1, 2].map(|c| (0..3).map(|k| motion(i / 30, k) * shape(i % 30, c, k)).sum()))
            .collect();
        let uniform = |i: usize| ((i as f64 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0);
        // The sum of twelve uniform numbers is nearly normal.
        let normal = |i: usize| (0..12).map(|k| uniform(12 * i + k)).sum::<f64>() - 6.0;
        let noisy: Vec<[f64; 3]> = truth
            .iter()
            .enumerate()
            .map(|(i, x)| [0, 1, 2].map(|c| x[c] + 0.2 * normal(3 * i + c)))
            .collect();
        let mut take = Take {
            labels: (0..30).map(|m| m.to_string()).collect(),
            times: (0..600).map(|f| f64::from(f) / 60.0).collect(),
            positions: noisy.clone(),
            ..Take::default()
        };
        let sigma = soften(&mut take).unwrap();
        assert!((sigma - 0.2).abs() < 0.02, "{sigma}");
        let rms = |found: &[[f64; 3]], frames: std::ops::Range<usize>| {
            let range = 30 * frames.start..30 * frames.end;
            let pairs = found[range.clone()].as_flattened().iter().zip(truth[range].as_flattened());
            let squares: Vec<f64> = pairs.map(|(a, b)| (a - b).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        assert!(rms(&take.positions, 0..600) < 0.06, "{}", rms(&take.positions, 0..600));
        assert!(rms(&take.positions, 199..206) < 0.2, "{}", rms(&take.positions, 199..206));
        for (soft, was) in take.positions.iter().zip(&noisy) {
            assert!(DVec3::from_array(*soft).distance(DVec3::from_array(*was)) < 4.001 * sigma);
        }

        // Without noise, and in a take of a few frames, nothing changes.
        let mut clean = Take { positions: truth.clone(), ..take.clone() };
        soften(&mut clean).unwrap();
        assert!(rms(&clean.positions, 0..600) < 0.01, "{}", rms(&clean.positions, 0..600));
        let mut short = Take { times: vec![0.0; 5], positions: truth[..150].to_vec(), ..take };
        assert_eq!(soften(&mut short).unwrap(), 0.0);
        assert_eq!(short.positions, truth[..150]);
    }
}
