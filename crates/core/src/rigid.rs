//! Rigid motions.
/// A rigid motion, such as a head pose: a turn, then a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMotion {
    /// A quaternion of length 1: x, y, z, w.
    pub rotation: [f64; 4],
    /// In the mesh's unit and along its axes.
    pub translation: [f64; 3],
}

impl RigidMotion {
    /// No motion.
    pub const IDENTITY: Self = Self { rotation: [0.0, 0.0, 0.0, 1.0], translation: [0.0; 3] };

    /// Whether all numbers are finite and the quaternion has length 1, within 10⁻⁶.
    pub fn is_rigid(&self) -> bool {
        let length = self.rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        (length - 1.0).abs() < 1e-6 && self.translation.iter().all(|x| x.is_finite())
    }

    /// The 4×4 matrix in the convention of column vectors, row by row: the translation is the last column.
    pub fn matrix(&self) -> [[f64; 4]; 4] {
        let [x, y, z, w] = self.rotation;
        let [tx, ty, tz] = self.translation;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y), tx],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x), ty],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y), tz],
            [0.0, 0.0, 0.0, 1.0],
        ]
    }

    /// Between this (`s` = 0) and `next` (`s` = 1), turning the shorter way.
    pub fn between(&self, next: &Self, s: f64) -> Self {
        let dot: f64 = self.rotation.iter().zip(&next.rotation).map(|(a, b)| a * b).sum();
        let sign = if dot < 0.0 { -1.0 } else { 1.0 };
        let angle = dot.abs().min(1.0).acos();
        // Slerp. Where both are nearly equal, its limit.
        let [a, b] = match angle.sin() {
            sine if sine > 1e-9 => [((1.0 - s) * angle).sin() / sine, (s * angle).sin() / sine],
            _ => [1.0 - s, s],
        };
        let mixed: [f64; 4] = std::array::from_fn(|i| a * self.rotation[i] + sign * b * next.rotation[i]);
        let length = mixed.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [from, to] = [self.translation, next.translation];
        Self {
            rotation: mixed.map(|x| x / length),
            translation: std::array::from_fn(|i| from[i] + s * (to[i] - from[i])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about_z(degrees: f64, translation: [f64; 3]) -> RigidMotion {
        let half = degrees.to_radians() / 2.0;
        RigidMotion { rotation: [0.0, 0.0, half.sin(), half.cos()], translation }
    }

    #[test]
    fn a_quarter_turn_takes_x_to_y() {
        let m = about_z(90.0, [1.0, 2.0, 3.0]).matrix();
        for (row, expected) in
            m.iter().zip([[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0]])
        {
            for (found, expected) in row.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-15, "{m:?}");
            }
        }
    }

    #[test]
    fn between_turns_evenly_and_the_shorter_way() {
        let [from, mut to] = [about_z(10.0, [0.0; 3]), about_z(70.0, [4.0, 0.0, -4.0])];
        for flip in [1.0, -1.0] {
            to.rotation = to.rotation.map(|x| flip * x);
            let found = from.between(&to, 0.25);
            let expected = about_z(25.0, [1.0, 0.0, -1.0]);
            for (a, b) in found.matrix().as_flattened().iter().zip(expected.matrix().as_flattened()) {
                assert!((a - b).abs() < 1e-12, "{found:?}");
            }
        }
        assert_eq!(from.between(&from, 0.5).rotation, from.rotation);
    }

    #[test]
    fn what_is_not_rigid() {
        assert!(RigidMotion::IDENTITY.is_rigid() && about_z(33.0, [1e6; 3]).is_rigid());
        let identity = RigidMotion::IDENTITY;
        assert!(!RigidMotion { rotation: [0.0; 4], ..identity }.is_rigid());
        assert!(!RigidMotion { rotation: [f64::NAN, 0.0, 0.0, 1.0], ..identity }.is_rigid());
        assert!(!RigidMotion { translation: [0.0, f64::INFINITY, 0.0], ..identity }.is_rigid());
    }
}
