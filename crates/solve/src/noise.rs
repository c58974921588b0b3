//! The noise of the scans: by how much each vertex is off by chance.
use rayon::prelude::*;
use rhytid_core::{Example, Face};
use rhytid_geometry::laplacian::Laplacian;
use rhytid_kernels::vec3;

/// The part of the vertices that are taken for smooth. Elsewhere, folds are as rough as noise.
const SMOOTH: f64 = 0.1;

/// Less noise than this is none, in metres.
const NEGLIGIBLE: f64 = 2e-5;

/// The least variance of what is learned without noise, in variances of the noise.
pub(crate) const LEAST_VARIANCE: f64 = 1e-3;

/// Metres in a millimetre, the unit of the noise in a face.
const MILLIMETRE: f64 = 1e-3;

/// σ_p of each example, P in mesh units: the standard deviation of a vertex per axis.
///
/// If the face does not say it, it is estimated. A field is rough where a vertex differs from the mean of its
/// neighbours, by the weights of the Laplacian. The roughness of a displacement is its lower tenth, since a
/// tenth of the skin is smooth in each expression. The estimate is the ratio of this roughness to that of
/// noise of variance 1. A second estimate is the same of what is rough in what is rough. The lesser of both
/// counts. They are equal for noise, and on a coarse mesh the second is much less for a bend. The noise of
/// the neutral is in the estimate, too.
pub(crate) fn of_examples(face: &Face, examples: &[Example], laplacian: &Laplacian) -> Vec<f64> {
    let rest = &face.neutral.positions;
    let of_noise =
        roughness((0..rest.len()).map(|v| [0, 1, 2].map(|c| white(3 * v + c))).collect(), laplacian);
    let estimate = |example: &Example| {
        let moved = example.positions.iter().zip(rest).map(|(x, rest)| vec3::sub(*x, *rest)).collect();
        let found = roughness(moved, laplacian);
        let ratios = found.iter().zip(of_noise).map(|(found, of_noise)| found / of_noise);
        ratios.filter(|ratio| ratio.is_finite()).reduce(f64::min).unwrap_or(0.0)
    };
    let negligible = NEGLIGIBLE / face.metres_per_unit;
    let of_example = |example: &Example| match example.noise {
        Some(noise) => noise * MILLIMETRE / face.metres_per_unit,
        None => Some(estimate(example)).filter(|noise| *noise >= negligible).unwrap_or(0.0),
    };
    examples.par_iter().map(of_example).collect()
}

/// How rough a field is at its smooth vertices, and how rough what is rough in it is there.
fn roughness(mut field: Vec<[f64; 3]>, laplacian: &Laplacian) -> [f64; 2] {
    [(); 2].map(|()| {
        let mut rough = field.clone();
        for &(a, b, w) in &laplacian.edges {
            let (a, b) = (a as usize, b as usize);
            for c in 0..3 {
                rough[a][c] += w / laplacian.diagonal[a] * field[b][c];
                rough[b][c] += w / laplacian.diagonal[b] * field[a][c];
            }
        }
        field = rough;
        let with_area = field.iter().zip(&laplacian.diagonal).filter(|(_, diagonal)| **diagonal != 0.0);
        let mut lengths: Vec<f64> =
            with_area.map(|(d, _)| vec3::length(*d)).filter(|length| length.is_finite()).collect();
        let place = (SMOOTH * lengths.len() as f64) as usize;
        match lengths.is_empty() {
            true => 0.0,
            false => *lengths.select_nth_unstable_by(place, f64::total_cmp).1,
        }
    })
}

/// White noise of variance 1 by its number, nearly normal: the sum of 16 bits of SplitMix64 (Steele, Lea and
/// Flood, 2014).
pub(crate) fn white(number: usize) -> f64 {
    let mut z = (number as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let ones = ((z ^ (z >> 31)) & 0xffff).count_ones();
    (f64::from(ones) - 8.0) / 2.0
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
            assert!((found / noise - 1.0).abs() < 0.15, "{found} instead of {noise}");
        }
        assert_eq!(found(expression(0.0)), 0.0);
        assert_eq!(found(Example { noise: Some(0.25), ..expression(0.1) }), 0.25);
    }
}
