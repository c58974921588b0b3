//! A surface of triangles, and its closest point to a given point.
use glam::DVec3;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

/// The most triangles that are tried in the search for a suitable one.
const LOOKED_AT: usize = 256;

/// Triangles in a tree.
pub struct Surface {
    tree: RTree<Triangle>,
}

/// The point of a surface that is closest to a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// The closest point.
    pub point: DVec3,
    /// The number of its triangle, as the triangles were given.
    pub triangle: usize,
    /// Its barycentric coordinates in that triangle.
    pub weights: [f64; 3],
}

impl Surface {
    /// The surface of triangles with these `corners`; each triangle has an area.
    pub fn new(corners: impl Iterator<Item = (usize, [DVec3; 3])>) -> Self {
        let triangles = corners.map(|(index, corners)| Triangle { index, corners }).collect();
        Self { tree: RTree::bulk_load(triangles) }
    }

    /// The closest point. Of equally close triangles the first one counts. `None` without a triangle.
    pub fn closest(&self, p: DVec3) -> Option<Closest> {
        let found = self.tree.nearest_neighbors(&p.to_array()).into_iter().min_by_key(|t| t.index)?;
        Some(found.closest(p))
    }

    /// The closest points of the `count` closest triangles, the closest one first.
    pub fn nearest(&self, p: DVec3, count: usize) -> impl Iterator<Item = Closest> {
        self.tree.nearest_neighbor_iter(p.to_array()).take(count).map(move |triangle| triangle.closest(p))
    }

    /// The closest point in a triangle that `suits`, no farther than `within`. Only the 256 nearest triangles
    /// are tried, so that a point among unsuitable triangles costs little.
    pub fn closest_that(&self, p: DVec3, within: f64, suits: impl Fn(usize) -> bool) -> Option<Closest> {
        let near = self.tree.nearest_neighbor_iter_with_distance_2(p.to_array()).take(LOOKED_AT);
        let near = near.take_while(|(_, squared)| *squared <= within * within);
        near.map(|(triangle, _)| triangle).find(|triangle| suits(triangle.index)).map(|t| t.closest(p))
    }
}

/// A triangle: its number and its corners.
struct Triangle {
    index: usize,
    corners: [DVec3; 3],
}

impl Triangle {
    fn closest(&self, p: DVec3) -> Closest {
        let (point, weights) = self.closest_point(p);
        Closest { point, triangle: self.index, weights }
    }

    /// The point of the triangle that is closest to `p`, and its barycentric coordinates. The signs of
    /// products tell whether the point is a corner, on an edge or inside (Ericson, *Real-Time Collision
    /// Detection*, 5.1.5).
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
    fn the_closest_that_suits_and_no_farther() {
        // Two sheets, one over the other, each of one triangle.
        let sheet = |z: f64| [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]].map(|[x, y]| DVec3::new(x, y, z));
        let surface = Surface::new([sheet(0.0), sheet(2.0)].into_iter().enumerate());
        let p = DVec3::new(1.0, 1.0, 1.5);
        assert_eq!(surface.closest_that(p, 9.0, |_| true), surface.closest(p));
        let lower = surface.closest_that(p, 9.0, |triangle| triangle == 0).unwrap();
        assert_eq!((lower.point, lower.triangle), (DVec3::new(1.0, 1.0, 0.0), 0));
        assert_eq!(surface.closest_that(p, 1.0, |triangle| triangle == 0), None);
        assert_eq!(surface.closest_that(p, 9.0, |_| false), None);
    }
}
