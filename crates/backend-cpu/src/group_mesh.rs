//! The triangles at each vertex, and the normals of a group of frames.
use crate::lanes::{Lanes, load3, store3};
use crate::lines::{GROUP, Line3};
use crate::mesh::pairs;
use crate::prefetch::Prefetch;
use pulp::Simd;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::vec3;

/// Neighbours are requested this many vertices before they are needed.
const AHEAD: usize = 8;

/// The triangles at each vertex in [`pairs`], ascending, so that each sum has the reference's order.
#[derive(Debug)]
pub(crate) struct GroupMesh {
    /// V + 1: the index of each vertex's first pair.
    offsets: Vec<u32>,
    pairs: Vec<[u32; 4]>,
}

impl GroupMesh {
    pub(crate) fn new(vertices: usize, triangles: &[[u32; 3]], vertex_triangles: &VertexTriangles) -> Self {
        let mut mesh = Self { offsets: vec![0], pairs: Vec::new() };
        for v in 0..vertices {
            mesh.pairs.extend(pairs(vertex_triangles.at(v).iter().map(|&t| triangles[t as usize])));
            mesh.offsets.push(mesh.pairs.len() as u32);
        }
        mesh
    }

    fn at(&self, v: usize) -> &[[u32; 4]] {
        &self.pairs[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// The normals of the vertices from `first` on, as many as `out` has, from the positions of all vertices.
    #[inline(always)]
    pub(crate) fn normals<S: Simd>(&self, simd: S, positions: &[Line3], first: usize, out: &mut [Line3]) {
        let prefetch = Prefetch::new();
        for (v, out) in (first..).zip(out) {
            // Triangles mostly ascend with their vertices. So the last ones have the vertices that were not
            // needed before.
            if let Some([_, _, c, d]) = self.at((v + AHEAD).min(positions.len() - 1)).last() {
                for corner in [c, d] {
                    prefetch.ask(bytemuck::cast_slice(&positions[*corner as usize]));
                }
            }
            for register in 0..GROUP / S::F32_LANES {
                let mut sum = [Lanes::splat(simd, 0.0); 3];
                for pair in self.at(v) {
                    let [a, b, c] = [0, 1, 2].map(|i| load3(simd, &positions[pair[i] as usize], register));
                    let to_c = vec3::sub(c, a);
                    sum = vec3::add(sum, vec3::cross(vec3::sub(b, a), to_c));
                    if pair[3] != pair[2] {
                        let d = load3(simd, &positions[pair[3] as usize], register);
                        sum = vec3::add(sum, vec3::cross(to_c, vec3::sub(d, a)));
                    }
                }
                store3(vec3::normalize(sum), out, register);
            }
        }
    }
}
