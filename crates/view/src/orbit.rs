//! The camera that the user moves: around a point, nearer and farther, and sideways.

use glam::{Vec2, Vec3};
use rhytid_core::{Rig, UpAxis};
use rhytid_render::{Camera, Sphere, View, around_handles};

/// Degrees per pixel.
const DEGREES: f32 = 0.4;
/// The least and the largest distance of the camera, in radii of the mesh.
const RANGE: [f32; 2] = [0.02, 50.0];

/// A camera that goes around `target`. Its horizon stays level. Beyond the poles it is upside down.
#[derive(Debug, Clone, PartialEq)]
pub struct Orbit {
    up: UpAxis,
    /// The ball around the mesh at rest.
    sphere: Sphere,
    /// The points that frame a picture.
    framed: Vec<[f32; 3]>,
    target: Vec3,
    /// In mesh units.
    distance: f32,
    /// Degrees as in [`View`], but without limits.
    turn: f32,
    raise: f32,
    /// Focal length in millimetres for film of 36 × 24 mm.
    lens: f32,
}

impl Orbit {
    /// As [`Orbit::new`], for the whole mesh instead of the face around its handles.
    pub fn around(rig: &Rig, aspect: f32) -> Self {
        let mut orbit = Self::new(rig, aspect);
        orbit.framed = rig.surface().rest.clone();
        orbit.all(aspect);
        orbit
    }

    /// Looks from the front at the face of `rig`, which is in the middle of a picture whose width is `aspect`
    /// times its height.
    pub fn new(rig: &Rig, aspect: f32) -> Self {
        let mut orbit = Self {
            up: rig.surface().up_axis,
            sphere: Sphere::around(&rig.surface().rest),
            framed: around_handles(&rig.handles().rest, &rig.surface().rest),
            target: Vec3::ZERO,
            distance: 1.0,
            turn: 0.0,
            raise: 0.0,
            lens: View::default().lens,
        };
        orbit.all(aspect);
        orbit
    }

    /// Shows the whole face, from the present direction.
    pub fn all(&mut self, aspect: f32) {
        let camera = self.framing(aspect);
        self.target = Vec3::from_array(camera.target());
        self.distance = distance(&camera);
    }

    /// The picture gets another shape: its width is no longer `from` times its height, but `to` times. The
    /// face fills the picture as much as before.
    pub fn reshape(&mut self, from: f32, to: f32) {
        self.distance *= distance(&self.framing(to)) / distance(&self.framing(from));
    }

    /// The camera that shows the whole face.
    fn framing(&self, aspect: f32) -> Camera {
        let view = View { turn: self.turn, raise: self.raise.clamp(-90.0, 90.0), lens: self.lens };
        Camera::framing(&self.framed, self.up, view, aspect)
    }

    /// Looks from `turn` degrees to the face's left and `raise` degrees above.
    pub fn look_from(&mut self, turn: f32, raise: f32) {
        (self.turn, self.raise) = (turn, raise);
    }

    /// The directions to the picture's right, up and towards the viewer, each of length 1.
    pub fn axes(&self) -> [Vec3; 3] {
        let (up, front) = match self.up {
            UpAxis::Y => (Vec3::Y, Vec3::Z),
            UpAxis::Z => (Vec3::Z, Vec3::NEG_Y),
        };
        let (turn, raise) = (self.turn.to_radians(), self.raise.to_radians());
        let level = turn.cos() * front + turn.sin() * Vec3::X;
        let right = up.cross(level);
        let toward = raise.cos() * level + raise.sin() * up;
        [right, toward.cross(right), toward]
    }

    /// The camera for drawing.
    pub fn camera(&self) -> Camera {
        let [_, upward, toward] = self.axes();
        let eye = self.target + self.distance * toward;
        let away = eye.distance(Vec3::from_array(self.sphere.center));
        let near = (away - 2.0 * self.sphere.radius).max(0.02 * self.distance);
        let far = away + 3.0 * self.sphere.radius;
        Camera::looking(
            [eye, self.target, upward].map(|v| v.to_array()),
            self.lens,
            [near, far.max(2.0 * near)],
        )
    }

    /// Turns the camera as the pointer drags the face by these pixels to the right and down.
    pub fn orbit(&mut self, [right, down]: [f32; 2]) {
        // Upside down the face turns the other way under the pointer.
        let upright = if self.raise.rem_euclid(360.0) > 90.0 && self.raise.rem_euclid(360.0) < 270.0 {
            -1.0
        } else {
            1.0
        };
        self.turn -= upright * DEGREES * right;
        self.raise += DEGREES * down;
    }

    /// The move of a point in space that follows the pointer by these pixels, in a picture `height` pixels
    /// high. It is a vector in the picture's plane, in mesh units.
    pub fn moved(&self, at: [f32; 3], [right, down]: [f32; 2], height: f32) -> [f32; 3] {
        let [x, y, toward] = self.axes();
        let eye = self.target + self.distance * toward;
        let depth = (eye - Vec3::from_array(at)).dot(toward).max(0.0);
        let unit = 2.0 * self.half() * depth / height;
        (unit * (right * x - down * y)).to_array()
    }

    /// Moves sideways, so that the target stays under the pointer.
    pub fn pan(&mut self, pixels: [f32; 2], height: f32) {
        self.target -= Vec3::from_array(self.moved(self.target.to_array(), pixels, height));
    }

    /// Goes nearer by `factor` if it is above 1, and farther if it is below 1. The point at this place of the
    /// picture stays there.
    pub fn zoom(&mut self, factor: f32, [x, y]: [f32; 2], [width, height]: [f32; 2]) {
        let [low, high] = RANGE.map(|radii| radii * self.sphere.radius);
        let distance = (self.distance / factor).clamp(low, high);
        let [right, upward, _] = self.axes();
        let from_middle = Vec2::new(x - 0.5 * width, 0.5 * height - y) / height;
        let shift = 2.0 * self.half() * (self.distance - distance) * from_middle;
        self.target += shift.x * right + shift.y * upward;
        self.distance = distance;
    }

    /// Goes around `point` from now on. The point moves to the middle.
    pub fn focus(&mut self, point: [f32; 3]) {
        self.target = Vec3::from_array(point);
    }

    /// Half a picture's height at the distance 1.
    fn half(&self) -> f32 {
        12.0 / self.lens
    }
}

/// From the eye to the target, in mesh units.
fn distance(camera: &Camera) -> f32 {
    Vec3::from_array(camera.target()).distance(Vec3::from_array(camera.eye()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    const SIZE: [u32; 2] = [800, 600];

    fn orbit() -> (Rig, Orbit) {
        let rig: Rig =
            rhytid_solve::solve(&rhytid_demo::face(1_000), &NoProgress).unwrap().rounded().unwrap();
        let orbit = Orbit::new(&rig, 800.0 / 600.0);
        (rig, orbit)
    }

    #[test]
    fn what_is_under_the_pointer_follows_it() {
        let (rig, mut orbit) = orbit();
        orbit.look_from(30.0, 20.0);
        let point = rig.handles().rest[0];
        let [x, y, _] = orbit.camera().project(SIZE, point);
        // A point that is dragged.
        let moved = orbit.moved(point, [31.0, -17.0], 600.0);
        let dragged = Vec3::from(point) + Vec3::from(moved);
        let [a, b, _] = orbit.camera().project(SIZE, dragged.to_array());
        assert!((a - x - 31.0).abs() < 0.02 && (b - y + 17.0).abs() < 0.02, "{a} {b}");
        // The target, when the camera moves sideways.
        let target = orbit.target.to_array();
        orbit.pan([50.0, 20.0], 600.0);
        let [a, b, _] = orbit.camera().project(SIZE, target);
        assert!((a - 450.0).abs() < 0.02 && (b - 320.0).abs() < 0.02, "{a} {b}");
    }

    #[test]
    fn zooming_keeps_the_place_under_the_cursor() {
        let (_, mut orbit) = orbit();
        orbit.look_from(-40.0, 10.0);
        // In the plane of the target.
        let [right, up, _] = orbit.axes();
        let point = (orbit.target + 0.1 * orbit.distance * (right + 0.5 * up)).to_array();
        let [x, y, _] = orbit.camera().project(SIZE, point);
        for factor in [1.3, 1.3, 0.5] {
            orbit.zoom(factor, [x, y], [800.0, 600.0]);
            let [a, b, _] = orbit.camera().project(SIZE, point);
            assert!((a - x).abs() < 0.05 && (b - y).abs() < 0.05, "{a} {b} instead of {x} {y}");
        }
        orbit.zoom(1e9, [x, y], [800.0, 600.0]);
        assert!(orbit.distance >= 0.99 * RANGE[0] * orbit.sphere.radius, "it does not go into the face");
    }

    #[test]
    fn it_goes_on_over_the_poles_without_a_jump() {
        let (_, mut orbit) = orbit();
        let mut before = orbit.axes();
        for _ in 0..2_000 {
            orbit.orbit([0.3, 1.0]);
            let after = orbit.axes();
            for (a, b) in before.iter().zip(after) {
                assert!((b.length() - 1.0).abs() < 1e-4);
                assert!(a.distance(b) < 0.02, "a jump at {} degrees", orbit.raise);
            }
            before = after;
        }
        assert!(orbit.raise > 700.0, "it was not held up at a pole: {}", orbit.raise);
    }

    #[test]
    fn the_whole_face_is_in_the_picture_from_everywhere() {
        let (_, mut orbit) = orbit();
        for (turn, raise) in [(0.0, 0.0), (90.0, 0.0), (0.0, 90.0), (33.0, -60.0)] {
            orbit.look_from(turn, raise);
            orbit.zoom(3.0, [10.0, 10.0], [800.0, 600.0]);
            orbit.all(800.0 / 600.0);
            for point in &orbit.framed {
                let [x, y, depth] = orbit.camera().project(SIZE, *point);
                assert!((0.0..=800.0).contains(&x) && (0.0..=600.0).contains(&y), "{turn} {raise}: {x} {y}");
                assert!((0.0..=1.0).contains(&depth));
            }
        }
    }
    #[test]
    fn a_picture_of_another_shape_shows_as_much_of_the_face() {
        // A zoomed face that was turned is as wide in the narrow picture as in the wide one, by parts.
        let (_, mut orbit) = orbit();
        orbit.look_from(25.0, 0.0);
        orbit.all(2.0);
        orbit.reshape(2.0, 0.4);
        let mut whole = orbit.clone();
        whole.all(0.4);
        assert!((orbit.distance / whole.distance - 1.0).abs() < 1e-5);
        orbit.zoom(2.0, [0.0, 0.0], [400.0, 1000.0]);
        let zoomed = orbit.clone();
        orbit.reshape(0.4, 0.9);
        orbit.reshape(0.9, 0.4);
        assert!((orbit.distance / zoomed.distance - 1.0).abs() < 1e-5);
    }
}
