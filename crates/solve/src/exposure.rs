//! The visibility of vertices from outside: a marker cannot be inside the mouth.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_geometry::Topology;
use rhytid_kernels::normals;

/// The number of directions from which the mesh is viewed, evenly around it.
const DIRECTIONS: usize = 60;

/// The least and the largest number of pixels across the mesh.
const PIXELS: [usize; 2] = [128, 512];

/// A visible vertex may be this many pixels behind the depth buffer, because it is not at its pixel's centre.
const SLACK: f64 = 1.5;

/// A surface faces a direction if the cosine between its normal and the direction is at least this.
const FACING: f64 = 0.15;

/// The exposure of each of V vertices, from 0 to 1.
///
/// It is the part of the directions that the vertex faces from which the vertex is seen. It is 0 for a vertex
/// without a triangle.
pub(crate) fn exposure(positions: &[[f64; 3]], triangles: &[[u32; 3]], topology: &Topology) -> Vec<f64> {
    let points: Vec<DVec3> = positions.iter().copied().map(DVec3::from_array).collect();
    let normals: Vec<DVec3> = (0..positions.len())
        .into_par_iter()
        .map(|v| normals::vertex_normal(positions, triangles, topology.vertex_triangles.at(v)).into())
        .collect();
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let directions: Vec<DVec3> = (0..DIRECTIONS)
        .map(|i| {
            let z = 1.0 - 2.0 * (i as f64 + 0.5) / DIRECTIONS as f64;
            let (sin, cos) = (golden * i as f64).sin_cos();
            DVec3::new((1.0 - z * z).sqrt() * cos, z, (1.0 - z * z).sqrt() * sin)
        })
        .collect();
    let seen: Vec<Vec<bool>> =
        directions.par_iter().map(|from| seen_from(*from, &points, triangles)).collect();
    (0..positions.len())
        .into_par_iter()
        .map(|v| {
            let facing = |from: &&(&DVec3, &Vec<bool>)| normals[v].dot(*from.0) >= FACING;
            let looks: Vec<_> = directions.iter().zip(&seen).collect();
            let (all, seen) = looks
                .iter()
                .filter(facing)
                .fold((0, 0), |(all, seen), (_, of)| (all + 1, seen + usize::from(of[v])));
            f64::from(seen as u32) / f64::from(all.max(1))
        })
        .collect()
}

/// Whether a viewer far away at `from` sees each point, by a depth buffer.
fn seen_from(from: DVec3, points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<bool> {
    let (right, up) = from.any_orthonormal_pair();
    let turned: Vec<DVec3> =
        points.iter().map(|p| DVec3::new(right.dot(*p), up.dot(*p), from.dot(*p))).collect();
    let (low, high) = turned
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    // About four pixels for each vertex along a line.
    let pixels = (4 * points.len().isqrt()).clamp(PIXELS[0], PIXELS[1]);
    let scale = (pixels - 1) as f64 / (high - low).truncate().max_element().max(f64::MIN_POSITIVE);
    let seen: Vec<DVec3> = turned.iter().map(|p| (*p - low) * scale).collect();
    let mut depth = vec![f64::NEG_INFINITY; pixels * pixels];
    for triangle in triangles {
        draw(triangle.map(|v| seen[v as usize]), pixels, &mut depth);
    }
    let pixel = |p: &DVec3| (p.y as usize).min(pixels - 1) * pixels + (p.x as usize).min(pixels - 1);
    seen.iter().map(|p| p.z + SLACK >= depth[pixel(p)]).collect()
}

fn draw([a, b, c]: [DVec3; 3], pixels: usize, depth: &mut [f64]) {
    let area = (b - a).truncate().perp_dot((c - a).truncate());
    if area == 0.0 {
        return;
    }
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    for row in low.y as usize..=(high.y as usize).min(pixels - 1) {
        for column in low.x as usize..=(high.x as usize).min(pixels - 1) {
            let p = glam::DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - a.truncate();
            let u = p.perp_dot((c - a).truncate()) / area;
            let v = (b - a).truncate().perp_dot(p) / area;
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
                let here = &mut depth[row * pixels + column];
                *here = here.max(a.z + u * (b.z - a.z) + v * (c.z - a.z));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_in_a_box_is_not_seen_and_a_hole_shows_what_is_behind_it() {
        // Two boxes, one inside the other, each of four quads and two lids. Then the outer box without its
        // lids.
        let corners = |r: f64| (0..8).map(move |i| [0, 1, 2].map(|c| if i >> c & 1 == 1 { r } else { -r }));
        let positions: Vec<[f64; 3]> = corners(1.0).chain(corners(0.4)).collect();
        let around = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
        let lids = [[0, 2, 3, 1], [4, 5, 7, 6]];
        let exposed = |closed: bool| {
            let outer = around.iter().chain(lids.iter().filter(|_| closed)).copied();
            let inner = around.iter().chain(&lids).map(|quad| quad.map(|v| v + 8));
            let triangles: Vec<[u32; 3]> =
                outer.chain(inner).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
            exposure(&positions, &triangles, &Topology::new(16, &triangles))
        };
        let closed = exposed(true);
        assert!(closed[..8].iter().all(|seen| *seen == 1.0), "{closed:?}");
        assert!(closed[8..].iter().all(|seen| *seen == 0.0), "{closed:?}");
        assert!(exposed(false)[8..].iter().all(|seen| *seen > 0.0 && *seen < 0.8));
    }
}
