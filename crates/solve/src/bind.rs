//! Components without a handle that follow the driven surface (`bind = "nearest"`).
use crate::triangulate::is_degenerate;
use glam::DVec3;
use rayon::prelude::*;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

/// Gives every vertex of which `binds` is true, none of them driven, the basis row of the closest point of the driven
/// surface: the barycentric mean of the three rows there. The vertex keeps its offset from that point. Of triangles that
/// are equally close, the first is taken.
///
/// `rest` is V×3, `basis` V×H. Without a driven triangle nothing is bound.
pub(crate) fn bind_nearest(
    rest: &[[f64; 3]],
    triangles: &[[u32; 3]],
    driven: &[bool],
    binds: impl Fn(usize) -> bool,
    handles: usize,
    basis: &mut [f64],
) {
    let bound: Vec<usize> = (0..rest.len()).filter(|&v| binds(v)).collect();
    if bound.is_empty() {
        return;
    }
    let place = |v: u32| DVec3::from_array(rest[v as usize]);
    let surface: Vec<Triangle> = triangles
        .iter()
        .enumerate()
        .filter(|(_, t)| driven[t[0] as usize] && !is_degenerate(t.map(place)))
        .map(|(index, t)| Triangle { index, corners: t.map(place) })
        .collect();
    if surface.is_empty() {
        return;
    }
    let surface = RTree::bulk_load(surface);
    let rows: Vec<Vec<f64>> = bound
        .par_iter()
        .map(|&v| {
            let closest = surface.nearest_neighbors(&rest[v]).into_iter().min_by_key(|t| t.index).unwrap();
            let (_, weights) = closest.closest_point(DVec3::from_array(rest[v]));
            let corners = triangles[closest.index];
            let row = |h| (0..3).map(|i| weights[i] * basis[corners[i] as usize * handles + h]).sum();
            (0..handles).map(row).collect()
        })
        .collect();
    for (v, row) in bound.into_iter().zip(rows) {
        basis[v * handles..][..handles].copy_from_slice(&row);
    }
}

/// A triangle of the driven surface, which one it is of all, and its corners.
struct Triangle {
    index: usize,
    corners: [DVec3; 3],
}

impl Triangle {
    /// The point of the triangle that is closest to `p`, and its barycentric coordinates. Signs of products
    /// tell whether it is a corner, on an edge or inside (Ericson, *Real-Time Collision Detection*, 5.1.5).
    fn closest_point(&self, p: DVec3) -> (DVec3, [f64; 3]) {
        let [a, b, c] = self.corners;
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let (ap, bp, cp) = (p - a, p - b, p - c);
        let (ab_ap, ac_ap) = (ab.dot(ap), ac.dot(ap));
        if ab_ap <= 0.0 && ac_ap <= 0.0 {
            return (a, [1.0, 0.0, 0.0]);
        }
        let (ab_bp, ac_bp) = (ab.dot(bp), ac.dot(bp));
        if ab_bp >= 0.0 && ac_bp <= ab_bp {
            return (b, [0.0, 1.0, 0.0]);
        }
        let (ab_cp, ac_cp) = (ab.dot(cp), ac.dot(cp));
        if ac_cp >= 0.0 && ab_cp <= ac_cp {
            return (c, [0.0, 0.0, 1.0]);
        }
        // Twice the areas of what `p` makes with each edge, times that of the triangle. Ericson's differences
        // of the products above are the same but cancel.
        let normal = ab.cross(ac);
        let w = normal.dot(ab.cross(ap));
        if w < 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0 {
            let along = ab_ap / ab.length_squared();
            return (a + ab * along, [1.0 - along, along, 0.0]);
        }
        let v = -normal.dot(ac.cross(cp));
        if v < 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0 {
            let along = ac_ap / ac.length_squared();
            return (a + ac * along, [1.0 - along, 0.0, along]);
        }
        let u = normal.dot(bc.cross(bp));
        if u < 0.0 && ac_bp - ab_bp >= 0.0 && ab_cp - ac_cp >= 0.0 {
            let along = bc.dot(bp) / bc.length_squared();
            return (b + bc * along, [0.0, 1.0 - along, along]);
        }
        // Not zero: a degenerate triangle is not part of the surface.
        let all = u + v + w;
        let (v, w) = (v / all, w / all);
        (a + ab * v + ac * w, [1.0 - v - w, v, w])
    }
}

impl RTreeObject for Triangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(&self.corners.map(|corner| corner.to_array()))
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let p = DVec3::from_array(*point);
        self.closest_point(p).0.distance_squared(p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_closest_point() {
        // A driven triangle in the plane z = 0 and three vertices over its face, an edge and a corner.
        let rest = [
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [0.0, 4.0, 0.0],
            [1.0, 1.0, 3.0],
            [2.0, -1.0, 1.0],
            [-1.0, -1.0, 0.0],
        ];
        let driven = [true, true, true, false, false, false];
        let mut basis = vec![0.0; 18];
        for i in 0..3 {
            basis[i * 3 + i] = 1.0;
        }
        bind_nearest(&rest, &[[0, 1, 2], [3, 4, 5]], &driven, |v| !driven[v], 3, &mut basis);
        let expected = [[0.5, 0.25, 0.25], [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]];
        for (got, expected) in basis[9..].iter().zip(expected.as_flattened()) {
            assert!((got - expected).abs() < 1e-12, "{basis:?}");
        }
    }
}
