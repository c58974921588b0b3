//! Points of a mesh's surface.
use crate::VertexId;
use rhytid_kernels::Real;
use std::cmp::Ordering;

/// A weight up to this counts as none. It is far below what float32 can tell apart in a position.
const NO_WEIGHT: f64 = 1e-6;

/// Weights whose sum is this near to 1 are taken as they are, but for the first.
const ROUNDED: f64 = 5e-7;

/// Rounds in which points are drawn to their places.
const DRAWN: usize = 50;

/// A point of a mesh's surface: up to three vertices of one face, with weights whose sum is 1. A vertex is a
/// point with one of them.
///
/// ```
/// use rhytid_core::{SurfacePoint, VertexId};
///
/// let positions = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// let point = SurfacePoint::new([0, 1, 2].map(VertexId), [0.25, 0.5, 0.25]).unwrap();
/// assert_eq!(point.at(&positions), [2.0, 1.0, 0.0]);
/// assert_eq!(point.nearest_vertex(), VertexId(1));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The vertices with a weight. Where there are fewer than three, the first stands for the others.
    corners: [VertexId; 3],
    /// The weights of the second and third vertex. Float32, so that a rig's file has all of them.
    others: [f32; 2],
}

impl From<VertexId> for SurfacePoint {
    fn from(vertex: VertexId) -> Self {
        Self { corners: [vertex; 3], others: [0.0; 2] }
    }
}

impl SurfacePoint {
    /// The point at these weights of three corners. The weights are divided by their sum where that is not 1,
    /// rounded to float32, and at most 1e-6 counts as 0.
    ///
    /// `None` if a weight is below −1e-6 or not finite, or if their sum is not above 0.
    pub fn new(corners: [VertexId; 3], weights: [f64; 3]) -> Option<Self> {
        let sum: f64 = weights.iter().sum();
        if !(sum.is_finite() && sum > 0.0 && weights.iter().all(|w| *w >= -NO_WEIGHT * sum)) {
            return None;
        }
        // One vertex that is given twice has the sum of its weights.
        let mut parts: Vec<(VertexId, f64)> = Vec::with_capacity(3);
        for (corner, weight) in corners.into_iter().zip(weights) {
            match parts.iter_mut().find(|(known, _)| *known == corner) {
                Some((_, known)) => *known += weight,
                None => parts.push((corner, weight)),
            }
        }
        parts.retain(|(_, weight)| *weight > NO_WEIGHT * sum);
        // Weights that were rounded before keep all their bits.
        let total = if (sum - 1.0).abs() <= ROUNDED { 1.0 } else { sum };
        let mut point = Self::from(parts.first()?.0);
        for (i, (corner, weight)) in parts.into_iter().enumerate().skip(1) {
            point.corners[i] = corner;
            point.others[i - 1] = (weight / total) as f32;
        }
        Some(point)
    }

    /// The vertices with a weight, one to three, with their weights. The sum is 1.
    pub fn corners(&self) -> impl Iterator<Item = (VertexId, f64)> + Clone + use<> {
        let all = self.corners.into_iter().zip(self.weights()).enumerate();
        all.filter(|(i, (_, weight))| *i == 0 || *weight > 0.0).map(|(_, corner)| corner)
    }

    /// Three vertices, as in a rig's file. Where there are fewer, the first stands for the others.
    pub fn triangle(&self) -> [VertexId; 3] {
        self.corners
    }

    /// The weights of [`SurfacePoint::triangle`].
    pub fn weights(&self) -> [f64; 3] {
        let [second, third] = self.others.map(f64::from);
        [1.0 - second - third, second, third]
    }

    /// The vertex with the greatest weight. Of equal ones, the lowest.
    pub fn nearest_vertex(&self) -> VertexId {
        let heavier = |best: (VertexId, f64), other: (VertexId, f64)| match other.1.total_cmp(&best.1) {
            Ordering::Greater => other,
            Ordering::Equal => (best.0.min(other.0), best.1),
            Ordering::Less => best,
        };
        self.corners().reduce(heavier).map_or(self.corners[0], |(vertex, _)| vertex)
    }

    /// The vertex, if the point is one.
    pub fn vertex(&self) -> Option<VertexId> {
        (self.others == [0.0; 2]).then_some(self.corners[0])
    }

    /// Whether any of its vertices is `v`.
    pub fn has(&self, v: VertexId) -> bool {
        self.corners.contains(&v)
    }

    /// Where the point is on a mesh with these V positions. At a vertex, it is the vertex' position to the
    /// bit.
    pub fn at<T: Real>(&self, positions: &[[T; 3]]) -> [T; 3] {
        match self.vertex() {
            Some(vertex) => positions[vertex.index()],
            None => self.mean(|v| positions[v.index()].map(T::widen)).map(T::round_from),
        }
    }

    /// The mean of `of` at its vertices, by their weights.
    pub fn mean(&self, of: impl Fn(VertexId) -> [f64; 3]) -> [f64; 3] {
        let mut mean = [0.0; 3];
        for (vertex, weight) in self.corners() {
            let of_vertex = of(vertex);
            (0..3).for_each(|c| mean[c] += weight * of_vertex[c]);
        }
        mean
    }

    /// Moves vertices so that each of `points` is where it is drawn to, and moves them as little as that
    /// takes. The points can be met together, as the handles of a face.
    pub fn draw(points: &[(&Self, [f64; 3])], positions: &mut [[f64; 3]]) {
        // Where points share vertices, each round leaves less to do (Kaczmarz 1937).
        for _ in 0..DRAWN {
            for (point, to) in points {
                let at = point.at(positions);
                let squares: f64 = point.corners().map(|(_, weight)| weight * weight).sum();
                for (v, weight) in point.corners() {
                    for (x, (to, at)) in positions[v.index()].iter_mut().zip(to.iter().zip(at)) {
                        *x = if weight == 1.0 { *to } else { *x + weight / squares * (to - at) };
                    }
                }
            }
        }
    }

    /// The point with other names for its vertices.
    #[must_use]
    pub fn renamed(&self, name: impl Fn(VertexId) -> VertexId) -> Self {
        Self { corners: self.corners.map(name), others: self.others }
    }
}

impl std::fmt::Display for SurfacePoint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let corners: Vec<VertexId> = self.corners().map(|(vertex, _)| vertex).collect();
        match corners[..] {
            [vertex] => write!(f, "vertex {vertex}"),
            [a, b] => write!(f, "vertices {a} and {b}"),
            _ => write!(f, "vertices {}, {} and {}", self.corners[0], self.corners[1], self.corners[2]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(weights: [f64; 3]) -> Option<SurfacePoint> {
        SurfacePoint::new([5, 3, 9].map(VertexId), weights)
    }

    #[test]
    fn the_sum_of_weights_does_not_matter_and_nothing_is_lost() {
        for weights in [[0.2, 0.5, 0.3], [1.0, 1.0, 1.0], [1e-5, 0.7, 0.1], [0.0, 0.4, 0.6]] {
            let one = point(weights).unwrap();
            assert_eq!(point(weights.map(|w| 7.0 * w)), Some(one));
            assert!((one.weights().iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert_eq!(SurfacePoint::new(one.triangle(), one.weights()), Some(one));
        }
        assert_eq!(point([0.2, 0.5, 0.3]).unwrap().nearest_vertex(), VertexId(3));
        assert_eq!(point([0.4, 0.4, 0.2]).unwrap().nearest_vertex(), VertexId(3));
    }

    #[test]
    fn all_weight_at_one_vertex_is_that_vertex() {
        for weights in [[0.0, 2.0, 0.0], [1e-7, 1.0, -1e-7]] {
            let found = point(weights).unwrap();
            assert_eq!((found.vertex(), found), (Some(VertexId(3)), VertexId(3).into()));
        }
        let twice = SurfacePoint::new([4, 4, 4].map(VertexId), [0.5, 0.25, 0.25]);
        assert_eq!(twice, Some(VertexId(4).into()));
        assert_eq!(point([0.5, 0.5, 0.0]).unwrap().to_string(), "vertices 5 and 3");
    }

    #[test]
    fn weights_that_are_none_are_refused() {
        for weights in [[-0.1, 0.6, 0.5], [0.0; 3], [f64::NAN, 0.5, 0.5], [f64::INFINITY, 0.0, 0.0]] {
            assert_eq!(point(weights), None, "{weights:?}");
        }
    }
}
