//! Section 5: the neighbour that orients each vertex's local frame.
use crate::Topology;
use glam::DVec3;

/// For each vertex the one-ring neighbour whose edge has the longest part tangential to the rest normal (ties:
/// the lowest index); the vertex itself where it has no neighbour.
pub fn frame_neighbors(rest: &[[f64; 3]], normals: &[[f64; 3]], topology: &Topology) -> Vec<u32> {
    (0..rest.len())
        .map(|v| {
            let (p, n) = (DVec3::from_array(rest[v]), DVec3::from_array(normals[v]));
            let mut best = (v as u32, -1.0);
            for &w in topology.neighbors(v) {
                let e = DVec3::from_array(rest[w as usize]) - p;
                let tangential = (e - e.dot(n) * n).length_squared();
                if tangential > best.1 {
                    best = (w, tangential);
                }
            }
            best.0
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_tangential_part_wins_and_ties_go_to_the_lowest_index() {
        let rest = [[0.0; 3], [1.0, 0.0, 5.0], [0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [9.0; 3]];
        let topology = Topology::new(5, &[[0, 1, 2], [0, 2, 3], [0, 3, 1]]);
        let got = frame_neighbors(&rest, &[[0.0, 0.0, 1.0]; 5], &topology);
        assert_eq!((got[0], got[4]), (2, 4));
    }
}
