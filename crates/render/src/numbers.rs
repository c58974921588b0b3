//! Numbers at vertices, for heat maps.

use crate::renderer::edges;
use glam::Vec3;
use rhytid_core::Faces;

/// How much longer or shorter skin is than at rest.
#[derive(Debug, Clone)]
pub struct Strains {
    /// Edges of polygons, each once, and their lengths at rest.
    edges: Vec<([u32; 2], f32)>,
    vertices: usize,
}

impl Strains {
    /// For a mesh whose V vertices are at `rest`. An edge without length there is left out.
    pub fn new(faces: &Faces, rest: &[[f32; 3]]) -> Self {
        let length = |edge: [u32; 2]| {
            let [a, b] = edge.map(|v| Vec3::from(rest[v as usize]));
            a.distance(b)
        };
        let edges =
            edges(faces).into_iter().map(|edge| (edge, length(edge))).filter(|(_, length)| *length > 0.0);
        Self { edges: edges.collect(), vertices: rest.len() }
    }

    /// The mean of ‖e‖/‖e₀‖ − 1 over the edges of each vertex. It is signed: 0.1 where the edges are a tenth
    /// longer than at rest. It is 0 without an edge. `positions` are V × 3.
    ///
    /// # Panics
    /// If there are fewer positions.
    pub fn measure(&self, positions: &[f32]) -> Vec<f32> {
        let (points, _) = positions.as_chunks::<3>();
        let (mut strains, mut counts) = (vec![0.0_f32; self.vertices], vec![0_u32; self.vertices]);
        for &(edge, rest) in &self.edges {
            let [a, b] = edge.map(|v| v as usize);
            let strain = Vec3::from(points[a]).distance(Vec3::from(points[b])) / rest - 1.0;
            for v in [a, b] {
                strains[v] += strain;
                counts[v] += 1;
            }
        }
        for (strain, count) in strains.iter_mut().zip(counts) {
            *strain /= count.max(1) as f32;
        }
        strains
    }
}

/// How far V vertices are apart in two frames of V × 3 positions, times `scale`.
pub fn distances(a: &[f32], b: &[f32], scale: f32) -> Vec<f32> {
    let pairs = a.as_chunks::<3>().0.iter().zip(b.as_chunks::<3>().0);
    pairs.map(|(a, b)| scale * Vec3::from(*a).distance(Vec3::from(*b))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strains_by_hand() {
        // A quad of 3 by 4, and a vertex without a face.
        let rest = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 4.0, 0.0], [9.0; 3]];
        let strains = Strains::new(&Faces { counts: vec![4], indices: vec![0, 1, 2, 3] }, &rest);
        assert_eq!(strains.measure(rest.as_flattened()), [0.0; 5]);
        // The lower edge is a third longer. The right edge grows from 4 to √17.
        let mut moved = rest;
        moved[1][0] = 4.0;
        let right = 17.0_f32.sqrt() / 4.0 - 1.0;
        let expected = [1.0 / 6.0, 0.5 * (1.0 / 3.0 + right), 0.5 * right, 0.0, 0.0];
        for (found, expected) in strains.measure(moved.as_flattened()).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
        }
        assert_eq!(distances(rest.as_flattened(), moved.as_flattened(), 10.0), [0.0, 10.0, 0.0, 0.0, 0.0]);
    }
}
