//! Cameras.

use glam::camera::rh::{proj, view};
use glam::{Mat4, Vec3, vec3};
use rhytid_core::UpAxis;

/// Height of the film to which focal lengths refer, in millimetres: film of 36 × 24 mm.
const FILM: f32 = 24.0;
/// The part of a picture that is filled.
const MARGIN: f32 = 0.9;

/// A ball around a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Its middle, in mesh units.
    pub center: [f32; 3],
    /// In mesh units, above 0.
    pub radius: f32,
}

impl Sphere {
    /// Around `points`: from the middle of their box to the farthest of them.
    pub fn around(points: &[[f32; 3]]) -> Self {
        let points = || points.iter().map(|p| Vec3::from_array(*p));
        let low = points().reduce(Vec3::min).unwrap_or_default();
        let high = points().reduce(Vec3::max).unwrap_or_default();
        let center = 0.5 * (low + high);
        let radius = points().map(|p| p.distance(center)).fold(f32::MIN_POSITIVE, f32::max);
        Self { center: center.to_array(), radius }
    }
}

/// A camera with a lens, in the space of the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: Vec3,
    target: Vec3,
    up: Vec3,
    /// The vertical angle of view, from the picture's lower to its upper edge, in radians.
    field_of_view: f32,
    near: f32,
    far: f32,
}

/// How a camera looks at a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Degrees by which the camera goes around the face, towards the face's left (the mesh's +x). 0 is in
    /// front of the face.
    pub turn: f32,
    /// Degrees by which the camera goes up, within ±90.
    pub raise: f32,
    /// Focal length in millimetres for film of 36 × 24 mm, above 0: 85 is a portrait's.
    pub lens: f32,
}

impl Default for View {
    /// A portrait from the front.
    fn default() -> Self {
        Self { turn: 0.0, raise: 0.0, lens: 85.0 }
    }
}

/// The picture's right, its up, and towards the viewer.
fn axes(up: UpAxis, view: View) -> [Vec3; 3] {
    let (up, front) = match up {
        UpAxis::Y => (Vec3::Y, Vec3::Z),
        UpAxis::Z => (Vec3::Z, Vec3::NEG_Y),
    };
    let [turn, raise] = [view.turn, view.raise.clamp(-89.9, 89.9)].map(f32::to_radians);
    let toward = raise.cos() * (turn.cos() * front + turn.sin() * Vec3::X) + raise.sin() * up;
    let right = up.cross(toward).normalize();
    [right, toward.cross(right), toward]
}

impl Camera {
    /// Looks at `points` so that they fill a picture except for a margin. The picture's width is `aspect`
    /// times its height. Faces look along +Z where Y is up, and along −Y where Z is up.
    pub fn framing(points: &[[f32; 3]], up: UpAxis, view: View, aspect: f32) -> Self {
        let [right, upward, toward] = axes(up, view);
        let seen = || {
            points
                .iter()
                .map(|p| Vec3::from_array(*p))
                .map(|p| vec3(p.dot(right), p.dot(upward), p.dot(toward)))
        };
        let low = seen().reduce(Vec3::min).unwrap_or_default();
        let high = seen().reduce(Vec3::max).unwrap_or_default();
        let middle = 0.5 * (low + high);
        let half = (0.5 * FILM / view.lens).atan().tan() * MARGIN;
        let needs = |p: Vec3| {
            let from = (p - middle).abs();
            (p - middle).z + (from.y / half).max(from.x / (half * aspect))
        };
        let distance = seen().map(needs).fold(f32::MIN_POSITIVE, f32::max);
        let radius = 0.5 * low.distance(high);
        let target = middle.x * right + middle.y * upward + middle.z * toward;
        Self::at_distance([target, toward, upward], distance, radius, view)
    }

    /// Looks at `sphere` so that it just fits, from any direction: for turntables.
    pub fn around(sphere: Sphere, up: UpAxis, view: View, aspect: f32) -> Self {
        let [_, upward, toward] = axes(up, view);
        let half = (0.5 * FILM / view.lens).atan();
        let narrower = half.min((half.tan() * aspect).atan());
        let distance = sphere.radius / narrower.sin();
        Self::at_distance([Vec3::from_array(sphere.center), toward, upward], distance, sphere.radius, view)
    }

    /// A mesh that moves may leave its ball of this radius at rest. So the near and far planes leave room
    /// around it.
    fn at_distance([target, toward, up]: [Vec3; 3], distance: f32, radius: f32, view: View) -> Self {
        let (near, far) = (distance - 2.0 * radius, distance + 3.0 * radius);
        let field_of_view = 2.0 * (0.5 * FILM / view.lens).atan();
        Self {
            eye: target + distance * toward,
            target,
            up,
            field_of_view,
            near: near.max(0.02 * distance),
            far,
        }
    }

    /// Looks from `eye` to `target`, both in mesh units. The picture's up is as near to `up` as possible. The
    /// `lens` is a focal length in millimetres for film of 36 × 24 mm. The picture shows distances from
    /// `near` to `far` mesh units.
    pub fn looking([eye, target, up]: [[f32; 3]; 3], lens: f32, [near, far]: [f32; 2]) -> Self {
        let [eye, target, up] = [eye, target, up].map(Vec3::from_array);
        Self { eye, target, up, field_of_view: 2.0 * (0.5 * FILM / lens).atan(), near, far }
    }

    /// The position of the camera, in mesh units.
    pub fn eye(&self) -> [f32; 3] {
        self.eye.to_array()
    }

    /// The point in the picture's middle, in mesh units.
    pub fn target(&self) -> [f32; 3] {
        self.target.to_array()
    }

    /// The matrix from the mesh's space to the camera's: x to the picture's right, y up, z towards the
    /// viewer.
    pub fn view(&self) -> Mat4 {
        view::look_at_mat4(self.eye, self.target, self.up)
    }

    /// The matrix from the camera's space to clip space with depths from 0 to 1, for a picture whose width is
    /// `aspect` times its height.
    pub fn projection(&self, aspect: f32) -> Mat4 {
        proj::directx::perspective(self.field_of_view, aspect, self.near, self.far)
    }

    /// Where `point` is in a picture of `size` pixels: to the right and down from the upper left corner, and
    /// its depth from 0 (near) to 1.
    pub fn project(&self, size: [u32; 2], point: [f32; 3]) -> [f32; 3] {
        let [width, height] = size.map(|n| n as f32);
        let clip = self.projection(width / height) * self.view();
        let p = clip.project_point3(Vec3::from_array(point));
        [(0.5 + 0.5 * p.x) * width, (0.5 - 0.5 * p.y) * height, p.z]
    }

    /// The direction from the eye, of length 1, to a place in a picture of `size` pixels. It is the inverse
    /// of [`Camera::project`].
    pub fn ray(&self, size: [u32; 2], [x, y]: [f32; 2]) -> [f32; 3] {
        let [width, height] = size.map(|n| n as f32);
        let clip = self.projection(width / height) * self.view();
        let at = clip.inverse().project_point3(vec3(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, 0.5));
        (at - self.eye).normalize_or(Vec3::NEG_Z).to_array()
    }
}

/// The points that a picture of a face is to show, for [`Camera::framing`]. They are the `handles`, moved
/// outwards from their middle, since a face extends beyond its handles. No point leaves the box of the mesh,
/// whose vertices are at `rest`.
pub fn around_handles(handles: &[[f32; 3]], rest: &[[f32; 3]]) -> Vec<[f32; 3]> {
    const BEYOND: f32 = 1.4;
    let center = Sphere::around(handles).center;
    let [low, high] = [f32::min, f32::max].map(|pick| {
        let all = rest.iter().copied();
        all.reduce(|a, b| std::array::from_fn(|c| pick(a[c], b[c]))).unwrap_or_default()
    });
    let beyond = |p: &[f32; 3], c: usize| center[c] + BEYOND * (p[c] - center[c]);
    handles.iter().map(|p| std::array::from_fn(|c| beyond(p, c).clamp(low[c], high[c]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPHERE: Sphere = Sphere { center: [1.0, 2.0, 3.0], radius: 10.0 };

    #[test]
    fn a_sphere_just_fits() {
        for size in [[400, 300], [300, 400]] {
            let aspect = size[0] as f32 / size[1] as f32;
            for view in [View::default(), View { turn: 50.0, raise: -30.0, lens: 35.0 }] {
                let camera = Camera::around(SPHERE, UpAxis::Y, view, aspect);
                // The ball's rim as the eye sees it: the points where rays touch the ball.
                let eye = camera.eye - camera.target;
                let toward = eye.normalize();
                let sine = SPHERE.radius / eye.length();
                let (rim, middle) =
                    (SPHERE.radius * (1.0 - sine * sine).sqrt(), SPHERE.radius * sine * toward);
                let (right, up) = (toward.any_orthonormal_pair().0, toward.any_orthonormal_pair().1);
                let mut reach = [0.0_f32; 2];
                for k in 0..720 {
                    let (sin, cos) = (k as f32 / 2.0).to_radians().sin_cos();
                    let p = camera.target + middle + rim * (cos * right + sin * up);
                    let [x, y, depth] = camera.project(size, p.to_array());
                    assert!((0.0..=1.0).contains(&depth));
                    reach[0] = reach[0].max((x / size[0] as f32 - 0.5).abs());
                    reach[1] = reach[1].max((y / size[1] as f32 - 0.5).abs());
                }
                assert!((reach[0].max(reach[1]) - 0.5).abs() < 1e-3, "{reach:?}");
            }
        }
    }

    #[test]
    fn a_ray_goes_through_what_is_at_its_place() {
        let camera = Camera::looking([[4.0, 1.0, 9.0], [0.0, 0.5, 0.0], [0.0, 1.0, 0.0]], 50.0, [0.1, 100.0]);
        for point in [[0.0, 0.5, 0.0], [1.0, -2.0, 3.0], [-2.0, 1.5, -4.0]] {
            let [x, y, _] = camera.project([640, 480], point);
            let ray = Vec3::from_array(camera.ray([640, 480], [x, y]));
            let expected = (Vec3::from_array(point) - Vec3::from_array(camera.eye())).normalize();
            assert!(ray.distance(expected) < 1e-4, "{ray} instead of {expected}");
        }
    }

    #[test]
    fn points_fill_the_picture() {
        let points = [[-3.0, 0.0, 1.0], [3.0, 1.0, 0.0], [0.0, 5.0, 0.0], [0.5, -4.0, 2.0]];
        for (size, view) in
            [([400, 300], View::default()), ([300, 900], View { turn: -70.0, raise: 40.0, lens: 28.0 })]
        {
            let camera = Camera::framing(&points, UpAxis::Z, view, size[0] as f32 / size[1] as f32);
            let reach = points.iter().flat_map(|p| {
                let [x, y, depth] = camera.project(size, *p);
                assert!((0.0..=1.0).contains(&depth));
                [(x / size[0] as f32 - 0.5).abs(), (y / size[1] as f32 - 0.5).abs()]
            });
            let most = reach.fold(0.0, f32::max);
            assert!((most - 0.45).abs() < 1e-3, "{most}");
        }
    }

    #[test]
    fn a_face_is_shown_beyond_its_handles_where_it_goes_on() {
        let handles = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
        // A wide strip that is as high as the handles.
        let rest = [[-9.0, -1.1, 0.0], [9.0, 1.1, 0.0]];
        let shown = around_handles(&handles, &rest);
        let expected = [[-1.4, 0.0, 0.0], [1.4, 0.0, 0.0], [0.0, 1.1, 0.0], [0.0, -1.1, 0.0]];
        assert!(shown.as_flattened().iter().zip(expected.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-6));
        assert!(around_handles(&[], &rest).is_empty());
    }

    #[test]
    fn a_face_looks_at_the_viewer_whichever_axis_is_up() {
        // Chin, nose tip and the face's left, the same face in both axes.
        let y_up = [[0.0, -3.0, 0.0], [0.0, 0.0, 2.0], [2.5, 0.0, 0.0]];
        let z_up = y_up.map(|[x, y, z]| [x, -z, y]);
        for turn in [0.0, 35.0] {
            let seen = [(UpAxis::Y, y_up), (UpAxis::Z, z_up)].map(|(up, face)| {
                let sphere = Sphere { center: [0.0; 3], radius: 4.0 };
                let camera = Camera::around(sphere, up, View { turn, ..View::default() }, 1.0);
                face.map(|p| camera.project([500, 500], p))
            });
            let [chin, nose, left] = seen[0];
            assert!(
                seen[0].iter().flatten().zip(seen[1].iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-2)
            );
            assert!(chin[1] > 300.0 && nose[2] < chin[2] && left[0] > 300.0);
            assert!(if turn == 0.0 { (nose[0] - 250.0).abs() < 1e-2 } else { nose[0] < 240.0 });
        }
    }
}
