//! The topology of a mesh: which triangles and vertices meet at each vertex.
use rhytid_kernels::normals::VertexTriangles;

/// Which triangles and vertices meet at each vertex.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    /// The triangles at each vertex.
    pub vertex_triangles: VertexTriangles,
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
}

impl Topology {
    /// For a mesh of `vertices` vertices; every index of `triangles` must be below that.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let vertex_triangles = VertexTriangles::new(vertices, triangles);
        let mut offsets = vec![0];
        let mut neighbors = Vec::with_capacity(triangles.len() * 3);
        let mut ring: Vec<u32> = Vec::new();
        for v in 0..vertices {
            ring.clear();
            for &t in vertex_triangles.at(v) {
                ring.extend(triangles[t as usize].iter().filter(|&&w| w as usize != v));
            }
            ring.sort_unstable();
            ring.dedup();
            neighbors.extend_from_slice(&ring);
            offsets.push(neighbors.len() as u32);
        }
        Self { vertex_triangles, offsets, neighbors }
    }

    /// V.
    pub fn vertices(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Where the one-ring of vertex `v` is among those of all vertices.
    pub fn neighbor_range(&self, v: usize) -> std::ops::Range<usize> {
        self.offsets[v] as usize..self.offsets[v + 1] as usize
    }

    /// The one-ring of vertex `v`: the vertices it shares an edge with, ascending.
    pub fn neighbors(&self, v: usize) -> &[u32] {
        &self.neighbors[self.neighbor_range(v)]
    }
}

/// The connected component of each vertex, counted from 0 in the order of their lowest vertices, and the
/// number of components. A vertex without a triangle is a component of its own.
pub fn components<'a>(vertices: usize, triangles: impl Iterator<Item = &'a [u32; 3]>) -> (Vec<u32>, usize) {
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            let grandparent = parent[parent[v as usize] as usize];
            parent[v as usize] = grandparent;
            v = grandparent;
        }
        v
    }
    let mut parent: Vec<u32> = (0..vertices as u32).collect();
    for triangle in triangles {
        for (a, b) in [(triangle[0], triangle[1]), (triangle[1], triangle[2])] {
            let (a, b) = (root(&mut parent, a), root(&mut parent, b));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    // Roots are the lowest vertices of their components, so each is met before the rest of it.
    let mut label = vec![0; vertices];
    let mut count = 0;
    for v in 0..vertices as u32 {
        let r = root(&mut parent, v);
        if r == v {
            label[v as usize] = count;
            count += 1;
        } else {
            label[v as usize] = label[r as usize];
        }
    }
    (label, count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_rings_are_sorted_and_without_repeats() {
        let topology = Topology::new(5, &[[2, 1, 0], [2, 0, 3]]);
        assert_eq!(topology.neighbors(0), [1, 2, 3]);
        assert_eq!(topology.neighbors(1), [0, 2]);
        assert!(topology.neighbors(4).is_empty());
        assert_eq!(topology.vertex_triangles.at(2), [0, 1]);
    }

    #[test]
    fn components_are_counted_from_their_lowest_vertices() {
        let (label, count) = components(7, [[5, 6, 1], [2, 3, 4], [1, 0, 6]].iter());
        assert_eq!((label, count), (vec![0, 0, 1, 1, 1, 0, 0], 2));
        let (label, count) = components(4, [[3, 2, 1]].iter());
        assert_eq!((label, count), (vec![0, 1, 1, 1], 2));
    }
}
