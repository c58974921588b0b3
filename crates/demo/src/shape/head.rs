//! Skull and jaw: the face without eyes, nose and lips.
use crate::curve::{Curve, bell, pair, ramp};
use glam::DVec3;

/// Turns the domain's `across` into an angle around the head's axis.
const ANGLE_PER_CM: f64 = LAST_ANGLE / super::HALF_WIDTH;
/// The angle at the rim before the ears.
const LAST_ANGLE: f64 = 1.45;

/// Half the head's width, by `up`.
const WIDTH: [[f64; 2]; 15] = [
    [-15.2, 4.6],
    [-13.4, 4.45],
    [-12.2, 4.6],
    [-10.8, 4.9],
    [-9.5, 5.1],
    [-8.0, 5.5],
    [-6.0, 6.0],
    [-4.0, 6.45],
    [-2.0, 6.8],
    [0.0, 6.9],
    [1.5, 6.85],
    [3.0, 6.75],
    [5.0, 6.4],
    [7.0, 6.05],
    [8.6, 5.4],
];
/// y of the midline, by `up`.
const HEIGHT: [[f64; 2]; 13] = [
    [-15.2, -12.9],
    [-14.2, -12.0],
    [-13.4, -11.5],
    [-12.4, -11.2],
    [-11.4, -10.85],
    [-10.8, -10.5],
    [-10.2, -10.05],
    [-9.0, -8.95],
    [-5.0, -5.0],
    [0.0, 0.0],
    [5.0, 5.0],
    [7.0, 6.85],
    [8.6, 8.05],
];
/// z of the midline, by `up`.
const PROFILE: [[f64; 2]; 26] = [
    [-15.2, -4.4],
    [-14.2, -4.0],
    [-13.4, -3.5],
    [-12.4, -2.5],
    [-11.4, -1.3],
    [-10.8, -0.5],
    [-10.2, 0.02],
    [-9.5, 0.22],
    [-8.8, 0.2],
    [-8.0, 0.12],
    [-7.0, 0.38],
    [-6.0, 0.62],
    [-5.0, 0.6],
    [-4.0, 0.42],
    [-3.0, 0.2],
    [-2.0, 0.05],
    [-1.0, -0.05],
    [0.0, -0.05],
    [1.0, 0.05],
    [2.0, 0.2],
    [3.0, 0.25],
    [4.0, 0.2],
    [5.0, 0.0],
    [6.0, -0.38],
    [7.0, -1.05],
    [8.6, -2.5],
];
/// z of the rim before the ears, by `up`.
const BACK: [[f64; 2]; 5] = [[-15.2, -8.3], [-11.0, -8.1], [0.0, -8.0], [5.0, -7.6], [8.6, -8.2]];
/// How far a line of equal `up` rises towards the ears, by `up`.
const LIFT: [[f64; 2]; 15] = [
    [-15.2, 2.6],
    [-13.4, 3.5],
    [-12.0, 4.0],
    [-10.8, 4.0],
    [-9.5, 3.3],
    [-8.0, 2.3],
    [-6.0, 1.15],
    [-4.0, 0.6],
    [-2.0, 0.15],
    [0.0, 0.0],
    [1.5, -0.1],
    [3.0, -0.5],
    [5.0, -1.2],
    [7.0, -2.0],
    [8.6, -2.6],
];

#[derive(Debug)]
pub(super) struct Head {
    /// Half the head's width, by `up`. The other curves depend on it.
    width: Curve,
    /// y of the midline.
    height: Curve,
    /// z of the midline.
    profile: Curve,
    /// z of the rim before the ears.
    back: Curve,
    /// How far a line of equal `up` rises towards the ears. The jaw's edge is such a line.
    lift: Curve,
}

impl Head {
    pub(super) fn new() -> Self {
        Self {
            width: Curve::new(&WIDTH),
            height: Curve::new(&HEIGHT),
            profile: Curve::new(&PROFILE),
            back: Curve::new(&BACK),
            lift: Curve::new(&LIFT),
        }
    }

    /// The point of the domain at `across`, `up` (after the openings' warp).
    pub(super) fn position(&self, across: f64, up: f64) -> DVec3 {
        let angle = across * ANGLE_PER_CM;
        let (sin, cos) = angle.sin_cos();
        let x = self.width.at(up) * sin;
        let y = self.height.at(up) + self.lift.at(up) * (1.0 - cos);
        let z = self.profile.at(up);
        let z = z + (self.back.at(up) - z) * (1.0 - cos) / (1.0 - LAST_ANGLE.cos());
        let outward = Self::outward(x, y);
        DVec3::new(x, y, z + Self::forward(x, y))
            + outward * ramp(across.abs(), super::HALF_WIDTH + 1.0, 7.0) * DVec3::new(sin, 0.0, cos)
    }

    /// Bones and flesh that are visible from the front, as a height along z.
    fn forward(x: f64, y: f64) -> f64 {
        let side = x.abs();
        let brow_line = 1.75 + 0.3 * ramp(side, 1.0, 3.6) - 0.35 * ramp(side, 3.8, 5.6);
        let brow = 0.34 * bell(y, brow_line, 0.62) * ramp(side, 6.1, 4.2) * (1.0 - 0.4 * bell(x, 0.0, 0.9));
        let glabella = 0.16 * bell(x, 0.0, 1.3) * bell(y, 2.0, 0.9);
        let socket = -0.6 * pair(x, 2.9, 1.6) * bell(y, 0.45, 0.95);
        let inner_corner = -0.32 * pair(x, 1.4, 0.6) * bell(y, 0.3, 0.75);
        let outer_corner = 0.24 * pair(x, 4.8, 0.9) * bell(y, -0.25, 0.95);
        let under_eye = -0.07 * pair(x, 2.0, 0.8) * bell(y + 0.16 * side, -1.0, 0.45)
            + 0.16 * pair(x, 3.5, 1.2) * bell(y, -1.1, 0.5);
        let apple = 0.36 * pair(x, 3.5, 1.6) * bell(y, -2.5, 1.5);
        let beside_nose = -0.2 * pair(x, 2.1, 0.7) * bell(y, -2.9, 1.4);
        let nasolabial = -0.1 * pair(x - 0.0, 2.55, 0.4) * bell(y, -4.9, 1.1);
        let mouth_corner = -0.2 * pair(x, 2.95, 0.6) * bell(y, -6.5, 0.8);
        let below_lip = -0.16 * bell(x, 0.0, 1.5) * bell(y, -7.95, 0.42);
        let chin = 0.42 * bell(x, 0.0, 1.45) * bell(y, -9.5, 0.95);
        let beside_chin = -0.14 * pair(x, 2.5, 0.8) * bell(y, -8.9, 1.1);
        let bosses = 0.12 * pair(x, 2.6, 1.8) * bell(y, 4.6, 1.5);
        brow + glabella
            + socket
            + inner_corner
            + outer_corner
            + under_eye
            + apple
            + beside_nose
            + nasolabial
            + mouth_corner
            + below_lip
            + chin
            + beside_chin
            + bosses
    }

    /// Bones and hollows of the sides, along the head's own direction there.
    fn outward(x: f64, y: f64) -> f64 {
        let cheekbone = 0.42 * pair(x, 5.3, 1.3) * bell(y + 0.25 * (x.abs() - 5.0), -1.6, 1.1);
        let hollow = -0.32 * pair(x, 4.9, 1.1) * bell(y, -5.4, 1.7);
        let temple = -0.3 * pair(x, 6.3, 0.9) * bell(y, 2.2, 1.6);
        let jaw_angle = 0.25 * pair(x, 5.0, 0.7) * bell(y, -7.2, 1.4);
        cheekbone + hollow + temple + jaw_angle
    }
}
