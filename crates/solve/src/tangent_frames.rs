//! Section 5: the neighbour that orients each vertex's tangent frame.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::VertexId;
use rhytid_geometry::Topology;
use rhytid_kernels::normals;

/// The tangent neighbour of each vertex.
///
/// It is the one-ring neighbour whose edge has the longest part tangential to the rest normal (ties: the
/// lowest index). A vertex without a neighbour has itself.
pub fn tangent_neighbors(rest: &[[f64; 3]], triangles: &[[u32; 3]], topology: &Topology) -> Vec<VertexId> {
    (0..rest.len())
        .into_par_iter()
        .map(|v| {
            let normal = normals::vertex_normal(rest, triangles, topology.vertex_triangles.at(v));
            let (p, n) = (DVec3::from_array(rest[v]), DVec3::from_array(normal));
            let mut best = (v as u32, -1.0);
            for &w in topology.neighbors(v) {
                let e = DVec3::from_array(rest[w as usize]) - p;
                let tangential = (e - e.dot(n) * n).length_squared();
                if tangential > best.1 {
                    best = (w, tangential);
                }
            }
            VertexId(best.0)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_tangential_part_wins_and_ties_go_to_the_lowest_index() {
        // The first and the third edge are the longest, but along the normal.
        let rest = [[0.0; 3], [1.0, 0.0, 5.0], [0.0, 2.0, 0.0], [-1.0, 0.0, 5.0], [0.0, -2.0, 0.0], [9.0; 3]];
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
        let got = tangent_neighbors(&rest, &triangles, &Topology::new(6, &triangles));
        assert_eq!((got[0], got[5]), (VertexId(2), VertexId(5)));
    }
}
