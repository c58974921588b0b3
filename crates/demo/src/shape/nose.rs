//! The nose.
use crate::curve::{Curve, bell, pair, ramp, soft_max};

#[derive(Debug)]
pub(super) struct Nose {
    /// Height of the ridge over the face, by y.
    ridge: Curve,
    /// Half its width.
    width: Curve,
}

impl Nose {
    pub(super) fn new() -> Self {
        Self {
            ridge: Curve::new(&[
                [-5.0, 0.0],
                [-4.75, 0.06],
                [-4.5, 0.4],
                [-4.25, 1.1],
                [-4.0, 1.75],
                [-3.7, 2.12],
                [-3.35, 2.25],
                [-3.0, 2.16],
                [-2.0, 1.72],
                [-1.0, 1.22],
                [0.0, 0.68],
                [0.8, 0.3],
                [1.6, 0.08],
                [2.2, 0.0],
            ]),
            width: Curve::new(&[
                [-5.0, 0.75],
                [-4.4, 0.72],
                [-3.8, 1.08],
                [-3.3, 1.1],
                [-2.5, 1.0],
                [-1.5, 0.96],
                [-0.5, 0.92],
                [0.3, 0.95],
                [1.2, 1.2],
                [2.2, 1.6],
            ]),
        }
    }

    /// Its height along z.
    pub(super) fn height(&self, x: f64, y: f64) -> f64 {
        if !(-5.6..2.6).contains(&y) {
            return 0.0;
        }
        let ends = ramp(y, -5.1, -4.7) * ramp(y, 2.4, 1.4);
        let across = (x / self.width.at(y)).abs();
        let ridge = self.ridge.at(y) * (-across.powf(2.3)).exp() * ends;
        let wing = {
            let (dx, dy) = ((x.abs() - 1.2) / 0.68, (y + 3.88) / 0.72);
            1.25 * (-(dx * dx + dy * dy).powf(1.4)).exp()
        };
        let nostril = -0.62 * pair(x, 0.66, 0.3) * bell(y, -4.32, 0.24);
        let groove = -0.11 * pair(x, 1.84, 0.2) * bell(y, -3.75, 0.6);
        soft_max(ridge, wing, 0.22) - 0.11 + nostril + groove
    }

    /// How far the tip hangs over the lip, along y.
    pub(super) fn droop(&self, x: f64, y: f64) -> f64 {
        -0.22 * bell(x, 0.0, 0.9) * bell(y, -3.7, 0.5)
    }
}
