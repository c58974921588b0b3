//! Smooth functions of one and two numbers, from which everything else is made.

/// A natural cubic spline through `(x, y)` knots. It is straight beyond the first and the last one.
#[derive(Debug, Clone)]
pub(crate) struct Curve {
    knots: Vec<[f64; 2]>,
    /// Second derivative at each knot.
    bends: Vec<f64>,
}

impl Curve {
    /// A spline through `knots`, whose first numbers increase.
    pub(crate) fn new(knots: &[[f64; 2]]) -> Self {
        let last = knots.len() - 1;
        let slope = |i: usize| (knots[i + 1][1] - knots[i][1]) / (knots[i + 1][0] - knots[i][0]);
        // Thomas' algorithm on the tridiagonal system of the second derivatives, zero at both ends.
        let mut bends = vec![0.0; last + 1];
        let mut upper = vec![0.0; last + 1];
        for i in 1..last {
            let (before, after) = (knots[i][0] - knots[i - 1][0], knots[i + 1][0] - knots[i][0]);
            let pivot = 2.0 * (before + after) - before * upper[i - 1];
            upper[i] = after / pivot;
            bends[i] = (6.0 * (slope(i) - slope(i - 1)) - before * bends[i - 1]) / pivot;
        }
        for i in (1..last).rev() {
            bends[i] -= upper[i] * bends[i + 1];
        }
        Self { knots: knots.to_vec(), bends }
    }

    /// The value at `x`.
    pub(crate) fn at(&self, x: f64) -> f64 {
        let i = self.knots.partition_point(|k| k[0] <= x).clamp(1, self.knots.len() - 1);
        let ([x0, y0], [x1, y1]) = (self.knots[i - 1], self.knots[i]);
        let (m0, m1, h) = (self.bends[i - 1], self.bends[i], x1 - x0);
        let slope = (y1 - y0) / h;
        if x < x0 {
            return y0 + (x - x0) * (slope - h * (2.0 * m0 + m1) / 6.0);
        }
        if x > x1 {
            return y1 + (x - x1) * (slope + h * (m0 + 2.0 * m1) / 6.0);
        }
        let (a, b) = ((x1 - x) / h, (x - x0) / h);
        a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0
    }
}

/// A bell of height 1 around `centre`; `width` is where it has fallen to 1/e.
pub(crate) fn bell(x: f64, centre: f64, width: f64) -> f64 {
    let q = (x - centre) / width;
    (-q * q).exp()
}

/// A bell on either side of the midline: [`bell`] at `centre` and at `-centre`.
pub(crate) fn pair(x: f64, centre: f64, width: f64) -> f64 {
    bell(x, centre, width) + bell(x, -centre, width)
}

/// 0 at `from`, 1 at `to` (which may be the smaller), with two continuous derivatives.
pub(crate) fn ramp(x: f64, from: f64, to: f64) -> f64 {
    let q = ((x - from) / (to - from)).clamp(0.0, 1.0);
    q * q * q * (q * (6.0 * q - 15.0) + 10.0)
}

/// 1 between `from` and `to`, 0 at `soft` outside them.
pub(crate) fn plateau(x: f64, from: f64, to: f64, soft: f64) -> f64 {
    ramp(x, from - soft, from) * ramp(x, to + soft, to)
}

/// The larger of two numbers, rounded off over a width of about `soft`.
pub(crate) fn soft_max(a: f64, b: f64, soft: f64) -> f64 {
    0.5 * (a + b + ((a - b) * (a - b) + soft * soft).sqrt())
}

/// Smooth noise in [-1, 1] with features of size 1, the same on every platform. `seed` selects one of many.
pub(crate) fn noise(x: f64, y: f64, seed: u32) -> f64 {
    let (left, low) = (x.floor(), y.floor());
    let corner = |i: i32, j: i32| lattice(left as i32 + i, low as i32 + j, seed);
    let (s, t) = (ramp(x - left, 0.0, 1.0), ramp(y - low, 0.0, 1.0));
    let bottom = corner(0, 0) + s * (corner(1, 0) - corner(0, 0));
    let top = corner(0, 1) + s * (corner(1, 1) - corner(0, 1));
    bottom + t * (top - bottom)
}

/// A number in [-1, 1] for each lattice point: an integer hash, so that every platform agrees.
pub(crate) fn lattice(i: i32, j: i32, seed: u32) -> f64 {
    let mut h = (i as u32).wrapping_mul(0x9E37_79B1)
        ^ (j as u32).wrapping_mul(0x85EB_CA77)
        ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    h ^= h >> 15;
    f64::from(h) / f64::from(u32::MAX) * 2.0 - 1.0
}
