//! Triangles of polygons, for the computation.
use glam::DVec3;
use rhytid_core::Mesh;

/// Triangles for the computation, as vertex indices: n − 2 for each polygon of n corners, polygon after
/// polygon.
///
/// A quad is cut from its first corner. It is cut from its second corner if only that cut keeps both halves
/// facing the same way. Larger polygons are cut by ear clipping in their plane.
pub fn triangulate(mesh: &Mesh) -> Vec<[u32; 3]> {
    let position = |v: u32| DVec3::from_array(mesh.positions[v as usize]);
    let mut out = Vec::with_capacity(mesh.faces.indices.len() - 2 * mesh.faces.len());
    for face in mesh.faces.iter() {
        match *face {
            [a, b, c] => out.push([a, b, c]),
            [a, b, c, d] => {
                let [pa, pb, pc, pd] = [a, b, c, d].map(position);
                let facing = |first: DVec3, second: DVec3| first.dot(second) > 0.0;
                let ac_folds = !facing((pb - pa).cross(pc - pa), (pc - pa).cross(pd - pa));
                let bd_folds = !facing((pb - pa).cross(pd - pa), (pc - pb).cross(pd - pb));
                if !ac_folds || bd_folds {
                    out.extend([[a, b, c], [a, c, d]]);
                } else {
                    out.extend([[a, b, d], [b, c, d]]);
                }
            }
            _ => clip_ears(face, position, &mut out),
        }
    }
    out
}

fn clip_ears(face: &[u32], position: impl Fn(u32) -> DVec3, out: &mut Vec<[u32; 3]>) {
    let points: Vec<[f64; 3]> = face.iter().map(|&v| position(v).to_array()).collect();
    let mut flat = Vec::new();
    let mut corners: Vec<u32> = Vec::new();
    if earcut::utils3d::project3d_to_2d(&points, points.len(), &mut flat) {
        earcut::Earcut::new().earcut(flat, &[], &mut corners);
    }
    if corners.len() == 3 * (face.len() - 2) {
        // The projection may look at the polygon from behind.
        let area = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|i| DVec3::from_array(points[i as usize]));
            (b - a).cross(c - a)
        };
        let newell: DVec3 = (0..points.len())
            .map(|i| {
                let next = DVec3::from_array(points[(i + 1) % points.len()]);
                DVec3::from_array(points[i]).cross(next)
            })
            .sum();
        let sum: DVec3 = corners.chunks_exact(3).map(|t| area([t[0], t[1], t[2]])).sum();
        let flip = sum.dot(newell) < 0.0;
        out.extend(corners.chunks_exact(3).map(|t| {
            let t = if flip { [t[0], t[2], t[1]] } else { [t[0], t[1], t[2]] };
            t.map(|i| face[i as usize])
        }));
    } else {
        // A polygon without a plane or with repeated points: a fan is as good as anything.
        out.extend((1..face.len() - 1).map(|i| [face[0], face[i], face[i + 1]]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::Faces;

    fn mesh(points: &[[f64; 2]]) -> Mesh {
        let mut faces = Faces::default();
        faces.push(&(0..points.len() as u32).collect::<Vec<_>>());
        Mesh {
            positions: points.iter().map(|p| [p[0], p[1], 0.3 * p[0]]).collect(),
            faces,
            ..Mesh::default()
        }
    }

    /// Signed area in the x-y plane, by the shoelace formula for the polygon itself.
    fn areas(mesh: &Mesh) -> (f64, Vec<f64>) {
        let area = |vs: &[u32]| {
            (0..vs.len())
                .map(|i| {
                    let (a, b) =
                        (mesh.positions[vs[i] as usize], mesh.positions[vs[(i + 1) % vs.len()] as usize]);
                    0.5 * (a[0] * b[1] - a[1] * b[0])
                })
                .sum::<f64>()
        };
        (area(&mesh.faces.indices), triangulate(mesh).iter().map(|t| area(t)).collect())
    }

    #[test]
    fn triangles_cover_concave_polygons_without_overlap() {
        let arrow = [[0.0, 0.0], [4.0, 1.0], [0.0, 2.0], [1.0, 1.0]];
        let star = [[0.0, 3.0], [-1.0, 1.0], [-3.0, 0.0], [-1.0, -1.0], [0.0, -3.0], [1.0, -1.0], [3.0, 0.0]];
        for points in [&arrow[..], &star[..]] {
            for turn in 0..points.len() {
                for reverse in [false, true] {
                    let mut points = points.to_vec();
                    points.rotate_left(turn);
                    if reverse {
                        points.reverse();
                    }
                    let (whole, parts) = areas(&mesh(&points));
                    assert_eq!(parts.len(), points.len() - 2);
                    assert!(parts.iter().all(|a| a * whole > 0.0), "{parts:?} of {whole}");
                    assert!((parts.iter().sum::<f64>() - whole).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_quad_is_cut_from_its_first_corner_unless_that_folds_it() {
        let convex = mesh(&[[0.0, 0.0], [3.0, 0.0], [4.0, 1.0], [1.0, 1.0]]);
        assert_eq!(triangulate(&convex), [[0, 1, 2], [0, 2, 3]]);
        let arrow = mesh(&[[0.0, 0.0], [4.0, 1.0], [0.0, 2.0], [1.0, 1.0]]);
        assert_eq!(triangulate(&arrow), [[0, 1, 3], [1, 2, 3]]);
    }

    #[test]
    fn corners_are_found_again() {
        let mut faces = Faces::default();
        faces.push(&[4, 5, 6]);
        faces.push(&[0, 1, 5, 4]);
        assert_eq!(
            faces.triangle_corners(&[[4, 5, 6], [0, 1, 4], [1, 5, 4]]),
            Some(vec![[0, 1, 2], [3, 4, 6], [4, 5, 6]])
        );
        assert_eq!(faces.triangle_corners(&[[4, 5, 6], [0, 1, 2], [1, 5, 4]]), None);
        assert_eq!(faces.triangle_corners(&[[4, 5, 6]]), None);
        let mut circle = Faces::default();
        circle.push(&(0..100).rev().collect::<Vec<_>>());
        let fan: Vec<[u32; 3]> = (1..99).map(|i| [99, 99 - i, 98 - i]).collect();
        let expected = (1..99).map(|i| [0, i, i + 1]).collect();
        assert_eq!(circle.triangle_corners(&fan), Some(expected));
    }
}
