//! The noise of the scans: by how much each vertex is off by chance.
use rayon::prelude::*;
use rhytid_core::{Example, Face};
use rhytid_geometry::laplacian::Laplacian;

/// The part of the vertices that are taken for smooth. Elsewhere, folds are as rough as noise.
const SMOOTH: f64 = 0.1;

/// The same quantile of χ² with three degrees of freedom.
const OF_CHI_SQUARED: f64 = 0.5844;

/// Less noise than this is none, in metres. The expressions of five makers, who add no noise, seem to have up
/// to 0.016 mm of it.
const NEGLIGIBLE: f64 = 2e-5;

/// The least variance of what is learned without noise, in variances of the noise.
pub(crate) const LEAST_VARIANCE: f64 = 1e-3;

/// Metres in a millimetre, the unit of the noise in a face.
const MILLIMETRE: f64 = 1e-3;

/// σ_p of each example, P in mesh units: the standard deviation of a vertex per axis.
///
/// If the face does not say it, it is estimated. The displacement of a vertex minus the mean of its
/// neighbours, by the weights of the Laplacian, is 0 where the displacement is linear. Noise of variance 1
/// makes it `k_v = 1 + Σ_w C_vw²/C_vv²`. So the estimate is the lower tenth of its square over k_v, since a
/// tenth of the skin is smooth in each expression. The noise of the neutral is in it, too.
pub(crate) fn of_examples(face: &Face, examples: &[Example], laplacian: &Laplacian) -> Vec<f64> {
    let mut known = vec![1.0; laplacian.diagonal.len()];
    for &(a, b, w) in &laplacian.edges {
        known[a as usize] += (w / laplacian.diagonal[a as usize]).powi(2);
        known[b as usize] += (w / laplacian.diagonal[b as usize]).powi(2);
    }
    let estimate = |example: &Example| {
        let rest = &face.neutral.positions;
        let moved = |v: u32| {
            let (x, rest) = (example.positions[v as usize], rest[v as usize]);
            [x[0] - rest[0], x[1] - rest[1], x[2] - rest[2]]
        };
        let mut rough: Vec<[f64; 3]> = (0..rest.len() as u32).map(moved).collect();
        for &(a, b, w) in &laplacian.edges {
            let (of_a, of_b) = (moved(a), moved(b));
            for c in 0..3 {
                rough[a as usize][c] += w / laplacian.diagonal[a as usize] * of_b[c];
                rough[b as usize][c] += w / laplacian.diagonal[b as usize] * of_a[c];
            }
        }
        let squares = rough.iter().zip(&known).zip(&laplacian.diagonal).filter(|(_, d)| **d != 0.0);
        let mut squares: Vec<f64> = squares
            .map(|((d, known), _)| (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / known)
            .filter(|square| square.is_finite())
            .collect();
        if squares.is_empty() {
            return 0.0;
        }
        let place = (SMOOTH * squares.len() as f64) as usize;
        let (_, square, _) = squares.select_nth_unstable_by(place, f64::total_cmp);
        (*square / OF_CHI_SQUARED).sqrt()
    };
    let negligible = NEGLIGIBLE / face.metres_per_unit;
    let of_example = |example: &Example| match example.noise {
        Some(noise) => noise * MILLIMETRE / face.metres_per_unit,
        None => Some(estimate(example)).filter(|noise| *noise >= negligible).unwrap_or(0.0),
    };
    examples.par_iter().map(of_example).collect()
}

/// White noise of variance 1: 1 or −1 by the number, from a bit of SplitMix64 (Steele, Lea and Flood, 2014).
pub(crate) fn white(number: usize) -> f64 {
    let mut z = (number as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    if (z ^ (z >> 31)) & 1 == 0 { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::Mesh;
    use rhytid_geometry::{laplacian::laplacian, triangulate};
    use rhytid_test_support::sheet::{add_sheet, face};

    /// Numbers of a normal distribution, by Box and Muller.
    fn normal(i: usize) -> f64 {
        let uniform = |i: usize| ((i as f64 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0).max(1e-12);
        (-2.0 * uniform(2 * i + 1).ln()).sqrt() * (std::f64::consts::TAU * uniform(2 * i + 2)).cos()
    }

    #[test]
    fn noise_is_told_from_a_smooth_motion_and_from_folds() {
        let mut face = face();
        face.neutral = Mesh::default();
        add_sheet(&mut face.neutral, 60, 50, [0.0; 3]);
        face.metres_per_unit = 0.001;
        face.neutral.positions.iter_mut().for_each(|x| *x = [0.25 * x[0], 0.25 * x[1], 0.0]);
        let expression = |noise: f64| {
            let moved = |(v, x): (usize, &[f64; 3])| {
                // A bend, and folds over a third of the sheet.
                let fold = if x[0] < 20.0 { 0.5 * (1.5 * x[0]).sin() } else { 0.0 };
                let z = (0.1 * x[0]).sin() * (0.08 * x[1]).cos() + fold;
                let noise = [0, 1, 2].map(|c| noise * normal(3 * v + c));
                [x[0] + 0.2 * x[1] + noise[0], x[1] + noise[1], x[2] + z + noise[2]]
            };
            let positions = face.neutral.positions.iter().enumerate().map(moved).collect();
            Example { positions, ..face.examples[0].clone() }
        };
        let found = |example: Example| {
            let laplacian = laplacian(&face.neutral.positions, &triangulate(&face.neutral));
            of_examples(&face, &[example], &laplacian)[0]
        };
        for noise in [0.1, 0.05, 0.5] {
            let found = found(expression(noise));
            assert!((found / noise - 1.0).abs() < 0.2, "{found} instead of {noise}");
        }
        assert_eq!(found(expression(0.0)), 0.0);
        assert_eq!(found(Example { noise: Some(0.25), ..expression(0.1) }), 0.25);
    }
}
