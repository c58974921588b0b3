//! How far light spreads in skin, as a filter on a mesh.

/// A part of a profile: a Gaussian `exp(−r²/2v) / 2πv` of the distance r along the surface. Its integral is
/// 1, so no light is lost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// v in mm², for each of the two directions in the surface.
    pub variance: f64,
    /// The part of red, green and blue light that it spreads.
    pub weights: [f64; 3],
}

/// Three layers of skin, as E. d'Eon and D. Luebke fitted them (GPU Gems 3, 2007, chapter 14, figure 14-13).
/// The weights of each colour sum to 1: the loss of light in the skin is part of the albedo.
pub const SKIN_PROFILE: [Gaussian; 6] = [
    Gaussian { variance: 0.0064, weights: [0.233, 0.455, 0.649] },
    Gaussian { variance: 0.0484, weights: [0.100, 0.336, 0.344] },
    Gaussian { variance: 0.187, weights: [0.118, 0.198, 0.0] },
    Gaussian { variance: 0.567, weights: [0.113, 0.007, 0.007] },
    Gaussian { variance: 1.99, weights: [0.358, 0.004, 0.0] },
    Gaussian { variance: 7.41, weights: [0.078, 0.0, 0.0] },
];

/// The part of the light that a series of polynomials leaves out: a millionth. So even the brightest light at
/// one vertex causes only a small error at others.
const LEFT_OUT: f64 = 1e-6;

/// The profile as a polynomial of the Laplacian, `p(L) = Σ_k c_k T_k(2 L/Λ − 1)`, for a mesh on which no
/// eigenvalue of L is above Λ.
///
/// A Gaussian of variance v is the heat kernel exp(−v L/2). A sum of Gaussians is thus one function of L. Its
/// Chebyshev series needs one multiplication by L for each polynomial, for any number of Gaussians.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// Λ in 1/mm².
    pub most: f64,
    /// The coefficients for each polynomial and colour. For L = 0 the series of each colour gives exactly 1,
    /// so constant light does not change.
    pub coefficients: Vec<[f64; 3]>,
}

impl Series {
    /// For eigenvalues up to `most` per mm². With only `longest` polynomials, at least 8, the series may
    /// cover fewer of them.
    pub(crate) fn new(profile: &[Gaussian], most: f64, longest: usize) -> Self {
        let most = most.max(1e-6);
        let series = |most| Self { most, coefficients: coefficients(profile, most, longest) };
        let whole = series(most);
        if whole.coefficients.len() <= longest {
            return whole;
        }
        let (mut low, mut high) = (1e-6, most);
        for _ in 0..60 {
            let middle = f64::sqrt(low * high);
            match coefficients(profile, middle, longest).len() <= longest {
                true => low = middle,
                false => high = middle,
            }
        }
        series(low)
    }
}

/// The part of the light of a wave that remains, for the eigenvalue `l` in 1/mm².
pub(crate) fn transfer(profile: &[Gaussian], l: f64) -> [f64; 3] {
    let part = |c| profile.iter().map(|g| g.weights[c] * (-0.5 * g.variance * l).exp()).sum();
    std::array::from_fn(part)
}

fn coefficients(profile: &[Gaussian], most: f64, longest: usize) -> Vec<[f64; 3]> {
    // A cosine transform, with more values than the longest series has.
    let count = 4 * longest;
    let cosines: Vec<f64> =
        (0..4 * count).map(|i| (std::f64::consts::PI * i as f64 / (2 * count) as f64).cos()).collect();
    // The cosine of k times the angle of value j.
    let cosine = |k: usize, j: usize| cosines[k * (2 * j + 1) % cosines.len()];
    let values: Vec<[f64; 3]> =
        (0..count).map(|j| transfer(profile, 0.5 * most * (1.0 + cosine(1, j)))).collect();
    let coefficient = |k: usize| -> [f64; 3] {
        let scale = if k == 0 { 1.0 } else { 2.0 } / count as f64;
        let sum = |c| (0..count).map(|j| values[j][c] * cosine(k, j)).sum::<f64>();
        std::array::from_fn(|c| scale * sum(c))
    };
    let mut all: Vec<[f64; 3]> = (0..2 * longest).map(coefficient).collect();
    let (mut left_out, mut count) = ([0.0; 3], all.len());
    while count > 2 {
        (0..3).for_each(|c| left_out[c] += all[count - 1][c].abs());
        if left_out.iter().any(|part| *part > LEFT_OUT) {
            break;
        }
        count -= 1;
    }
    all.truncate(count);
    for c in 0..3 {
        // T_k(−1) = (−1)^k.
        let at_0: f64 = all.iter().zip([1.0, -1.0].into_iter().cycle()).map(|(a, sign)| sign * a[c]).sum();
        all[0][c] += 1.0 - at_0;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_colour_keeps_its_light() {
        for c in 0..3 {
            let sum: f64 = SKIN_PROFILE.iter().map(|gaussian| gaussian.weights[c]).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
    }

    #[test]
    fn a_series_is_the_function_up_to_its_limit() {
        for most in [0.5, 20.0, 100.0] {
            let series = Series::new(&SKIN_PROFILE, most, 160);
            assert_eq!(series.most, most);
            for i in 0..=200 {
                let l = most * f64::from(i) / 200.0;
                let angle = (2.0 * l / most - 1.0).clamp(-1.0, 1.0).acos();
                let expected = transfer(&SKIN_PROFILE, l);
                for c in 0..3 {
                    let terms = series.coefficients.iter().enumerate();
                    let found: f64 = terms.map(|(k, a)| a[c] * (k as f64 * angle).cos()).sum();
                    assert!(
                        (found - expected[c]).abs() < 2.1 * LEFT_OUT,
                        "{most}: {l}: {found}, {expected:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_series_ends_where_it_is_longest() {
        let series = Series::new(&SKIN_PROFILE, 1e5, 160);
        assert!(series.most > 100.0 && series.most < 1e5, "{}", series.most);
        assert!((157..=160).contains(&series.coefficients.len()));
    }
}
