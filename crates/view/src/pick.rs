//! The marker or vertex under the pointer.

use glam::Vec3;
use rayon::prelude::*;
use rhytid_render::Camera;

/// The marker nearest to the place `at` of a picture of `size` pixels, among those within `reach` pixels. Of
/// several, the one in front is chosen.
pub fn marker(
    markers: &[[f32; 3]],
    camera: &Camera,
    size: [u32; 2],
    at: [f32; 2],
    reach: f32,
) -> Option<usize> {
    let seen = markers.iter().enumerate().filter_map(|(i, &marker)| {
        let [x, y, depth] = camera.project(size, marker);
        let off = (x - at[0]).hypot(y - at[1]);
        (off <= reach && (0.0..=1.0).contains(&depth)).then_some((i, off, marker))
    });
    let eye = Vec3::from_array(camera.eye());
    // The far side of a head has a marker behind each one.
    let score = |off: f32, marker: [f32; 3]| eye.distance(Vec3::from_array(marker)) * (1.0 + 0.01 * off);
    seen.min_by(|a, b| score(a.1, a.2).total_cmp(&score(b.1, b.2))).map(|(i, ..)| i)
}

/// The vertex nearest to the point where the ray through a place of a picture first meets the mesh, which has
/// V × 3 `positions`. `None` if the ray misses the mesh.
pub fn vertex(
    positions: &[f32],
    triangles: &[[u32; 3]],
    camera: &Camera,
    size: [u32; 2],
    at: [f32; 2],
) -> Option<usize> {
    let (points, _) = positions.as_chunks::<3>();
    let (eye, ray) = (Vec3::from_array(camera.eye()), Vec3::from_array(camera.ray(size, at)));
    let corner = |v: u32| Vec3::from_array(points[v as usize]);
    let hit = |triangle: &[u32; 3]| {
        let corners = triangle.map(corner);
        let [u, v, distance] = meets(eye, ray, corners)?;
        let weights = [1.0 - u - v, u, v];
        let nearest = (0..3).max_by(|&i, &j| weights[i].total_cmp(&weights[j]))?;
        Some((distance, triangle[nearest] as usize))
    };
    let hits = triangles.par_iter().filter_map(hit);
    hits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, vertex)| vertex)
}

/// The point where a ray meets a triangle, from either side: two barycentric coordinates and the distance
/// (Möller and Trumbore 1997).
fn meets(eye: Vec3, ray: Vec3, [a, b, c]: [Vec3; 3]) -> Option<[f32; 3]> {
    let (e, f) = (b - a, c - a);
    let p = ray.cross(f);
    let det = e.dot(p);
    if det == 0.0 {
        return None;
    }
    let s = eye - a;
    let u = s.dot(p) / det;
    let q = s.cross(e);
    let v = ray.dot(q) / det;
    let distance = f.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some([u, v, distance])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [400, 300];

    fn camera() -> Camera {
        Camera::looking([[0.0, 0.0, 10.0], [0.0; 3], [0.0, 1.0, 0.0]], 50.0, [0.1, 100.0])
    }

    #[test]
    fn the_marker_in_front_is_taken() {
        let markers = [[0.0, 0.0, -2.0], [0.1, 0.0, 2.0], [3.0, 0.0, 0.0]];
        let at = |marker: [f32; 3]| {
            let [x, y, _] = camera().project(SIZE, marker);
            [x, y]
        };
        // Marker 0 is nearer to this place, but it is behind the other.
        assert_eq!(marker(&markers, &camera(), SIZE, at(markers[0]), 12.0), Some(1));
        assert_eq!(marker(&markers, &camera(), SIZE, at(markers[2]), 12.0), Some(2));
        assert_eq!(marker(&markers, &camera(), SIZE, [5.0, 5.0], 12.0), None);
    }

    #[test]
    fn the_vertex_that_is_seen_is_taken() {
        // Two triangles, one behind the other, and the vertices at their corners.
        let positions = [
            [-2.0, -2.0, 0.0],
            [2.0, -2.0, 0.0],
            [0.0, 2.0, 0.0],
            [-2.0, -2.0, 3.0],
            [2.0, -2.0, 3.0],
            [0.0, 2.0, 3.0],
        ];
        let triangles = [[0, 1, 2], [3, 5, 4]];
        for (v, point) in positions.iter().enumerate().skip(3) {
            // The place is a little towards the middle.
            let [x, y, _] = camera().project(SIZE, [0.9 * point[0], 0.9 * point[1] - 0.05, point[2]]);
            assert_eq!(vertex(positions.as_flattened(), &triangles, &camera(), SIZE, [x, y]), Some(v));
        }
        assert_eq!(vertex(positions.as_flattened(), &triangles, &camera(), SIZE, [1.0, 1.0]), None);
    }
}
