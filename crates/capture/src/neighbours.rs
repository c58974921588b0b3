//! Neighbours of a point, by distance.
use glam::DVec3;

/// For each point the indices of the `count` nearest others, the nearest first.
pub(crate) fn nearest(points: &[DVec3], count: usize) -> Vec<Vec<usize>> {
    let of = |i: usize| {
        let mut others: Vec<usize> = (0..points.len()).filter(|&j| j != i).collect();
        others.sort_by(|&a, &b| {
            points[i].distance_squared(points[a]).total_cmp(&points[i].distance_squared(points[b]))
        });
        others.truncate(count);
        others
    };
    (0..points.len()).map(of).collect()
}
