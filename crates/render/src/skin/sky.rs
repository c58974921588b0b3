//! Light from all directions, as spherical harmonics of the second order.

use std::f32::consts::PI;

/// Radiance by direction: Σ c_i Y_i, for the nine real spherical harmonics up to the second order, in the
/// order of R. Ramamoorthi and P. Hanrahan, *An Efficient Representation for Irradiance Environment Maps*
/// (2001): Y00, Y1−1 (y), Y10 (z), Y11 (x), Y2−2 (xy), Y2−1 (yz), Y20 (3z² − 1), Y21 (xz), Y22 (x² − y²).
/// Directions are the camera's: x to the picture's right, y up, z towards the viewer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// Red, green and blue of each, in cd/m².
    pub coefficients: [[f32; 3]; 9],
}

/// The factor of a harmonic in irradiance, by its order: the coefficients of the cosine.
pub(super) const COSINE: [f32; 3] = [PI, 2.0 * PI / 3.0, PI / 4.0];

/// The harmonics' factors: 1, a linear one, xy and the like, 3z² − 1, x² − y².
pub(super) fn harmonics([x, y, z]: [f32; 3]) -> [f32; 9] {
    let [c0, c1, c2] = [(0.25 / PI).sqrt(), (0.75 / PI).sqrt(), (3.75 / PI).sqrt()];
    let c3 = (0.3125 / PI).sqrt();
    [
        c0,
        c1 * y,
        c1 * z,
        c1 * x,
        c2 * x * y,
        c2 * y * z,
        c3 * (3.0 * z * z - 1.0),
        c2 * x * z,
        0.5 * c2 * (x * x - y * y),
    ]
}

impl Sky {
    /// A sky of the same radiance in all directions, in cd/m².
    pub fn even(radiance: [f32; 3]) -> Self {
        let mut coefficients = [[0.0; 3]; 9];
        coefficients[0] = radiance.map(|x| x / harmonics([0.0, 0.0, 1.0])[0]);
        Self { coefficients }
    }

    /// The sky of a function of the direction, in cd/m².
    pub fn from_radiance(radiance: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        let mut coefficients = [[0.0; 3]; 9];
        let directions = directions(4096);
        let part = 4.0 * PI / directions.len() as f32;
        for direction in directions {
            let light = radiance(direction);
            for (coefficient, y) in coefficients.iter_mut().zip(harmonics(direction)) {
                (0..3).for_each(|c| coefficient[c] += part * y * light[c]);
            }
        }
        Self { coefficients }
    }

    /// The radiance from a direction of length 1, in cd/m². Not below 0.
    pub fn radiance(&self, direction: [f32; 3]) -> [f32; 3] {
        self.sum(direction, [1.0; 3])
    }

    /// The irradiance of an unoccluded surface with this normal, in lx.
    pub fn irradiance(&self, normal: [f32; 3]) -> [f32; 3] {
        self.sum(normal, COSINE)
    }

    fn sum(&self, direction: [f32; 3], factors: [f32; 3]) -> [f32; 3] {
        const ORDERS: [usize; 9] = [0, 1, 1, 1, 2, 2, 2, 2, 2];
        let mut sum = [0.0; 3];
        for ((coefficient, y), order) in self.coefficients.iter().zip(harmonics(direction)).zip(ORDERS) {
            (0..3).for_each(|c| sum[c] += factors[order] * y * coefficient[c]);
        }
        sum.map(|x: f32| x.max(0.0))
    }
}

/// `count` directions, evenly distributed over the sphere: a spiral by the golden angle.
pub(super) fn directions(count: usize) -> Vec<[f32; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z].map(|x| x as f32)
    };
    (0..count).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_orthonormal() {
        let directions = directions(20_000);
        for i in 0..9 {
            for j in 0..9 {
                let sum: f32 = directions.iter().map(|d| harmonics(*d)[i] * harmonics(*d)[j]).sum();
                let product = sum * 4.0 * PI / directions.len() as f32;
                assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 2e-3, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn irradiance_is_the_integral_of_radiance() {
        let sky = Sky::from_radiance(|[x, y, z]| [2.0 + y, 1.5 + 0.5 * x * z, 1.0 + z * z]);
        let normal = [0.48, 0.6, 0.64];
        let directions = directions(100_000);
        let mut expected = [0.0_f64; 3];
        for d in &directions {
            let cosine = glam::Vec3::from(*d).dot(normal.into());
            let light = sky.radiance(*d);
            for c in 0..3 {
                expected[c] += f64::from(cosine.max(0.0) * light[c]) * 4.0 * std::f64::consts::PI / 100_000.0;
            }
        }
        for (found, expected) in sky.irradiance(normal).into_iter().zip(expected) {
            assert!((f64::from(found) / expected - 1.0).abs() < 2e-3, "{found}, expected {expected}");
        }
        // The sky has the radiance from which it was made.
        let [r, g, b] = sky.radiance([0.6, 0.0, 0.8]);
        assert!((r - 2.0).abs() < 1e-2 && (g - 1.74).abs() < 1e-2 && (b - 1.64).abs() < 1e-2, "{r} {g} {b}");
    }

    #[test]
    fn an_even_sky_is_pi_times_its_radiance() {
        let [r, g, b] = Sky::even([1.0, 2.0, 3.0]).irradiance([0.0, -1.0, 0.0]);
        assert!((r - PI).abs() < 1e-5 && (g - 2.0 * PI).abs() < 1e-5 && (b - 3.0 * PI).abs() < 1e-5);
    }
}
