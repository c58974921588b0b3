//! Points that a face hides.

use glam::Vec3;
use rhytid_render::Camera;

/// Whether a mesh hides each of `points` from `camera` in a picture of `size` pixels.
///
/// The mesh has `positions` and `triangles`. Each point counts as `lift` mesh units nearer than it is. A
/// point outside the picture is not hidden.
pub(crate) fn behind(
    camera: &Camera,
    size: [u32; 2],
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    lift: f32,
    points: &[[f32; 3]],
) -> Vec<bool> {
    if points.is_empty() {
        return Vec::new();
    }
    let toward = camera.view().row(2).truncate();
    let nearer = |p: &[f32; 3]| (Vec3::from(*p) + lift * toward).to_array();
    let points: Vec<[f32; 3]> = points.iter().map(|p| camera.project(size, nearer(p))).collect();
    let seen: Vec<[f32; 3]> = positions.iter().map(|p| camera.project(size, *p)).collect();
    let mut is_behind = vec![false; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| seen[v as usize]);
        let [low, high] = [f32::min, f32::max].map(|pick| [0, 1].map(|i| pick(pick(a[i], b[i]), c[i])));
        for (&[x, y, depth], is_behind) in points.iter().zip(&mut is_behind) {
            if !(x >= low[0] && x <= high[0] && y >= low[1] && y <= high[1]) {
                continue;
            }
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            let u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
            let v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
            // A device's depths are linear across a picture.
            *is_behind |=
                u >= 0.0 && v >= 0.0 && u + v <= 1.0 && a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]) < depth;
        }
    }
    is_behind
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::UpAxis;
    use rhytid_render::{Sphere, View};

    #[test]
    fn what_is_behind_a_square_and_how_far() {
        let square = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let sphere = Sphere { center: [0.0; 3], radius: 3.0 };
        let points = [
            [0.3, 0.2, 0.5],
            [0.3, 0.2, -0.05],
            [0.3, 0.2, -0.5],
            [1.5, 0.2, -0.5],
            [f32::NAN; 3],
            [f32::INFINITY; 3],
        ];
        let behind = |turn: f32| {
            let camera = Camera::around(sphere, UpAxis::Y, View { turn, ..View::default() }, 1.0);
            behind(&camera, [200, 200], &square, &triangles, 0.1, &points)
        };
        assert_eq!(behind(0.0), [false, false, true, false, false, false]);
        // From the other side, the other points are hidden.
        assert_eq!(behind(180.0), [true, false, false, false, false, false]);
        assert!(
            super::behind(
                &Camera::around(sphere, UpAxis::Y, View::default(), 1.0),
                [200, 200],
                &square,
                &triangles,
                0.1,
                &[]
            )
            .is_empty()
        );
    }
}
