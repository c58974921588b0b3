#![doc = include_str!("README.md")]
use crate::params::parameter_block;
use crate::{Real, vec3};

parameter_block!(
    /// Frames in the batch.
    frames,
    /// V.
    vertices,
    /// The first vertex of this part; 0 where the rig is in one piece.
    first_vertex,
    /// Vertices of this part.
    part_vertices,
);

impl Params {
    /// For a rig in one piece.
    pub fn whole(frames: usize, vertices: usize) -> Self {
        let (frames, vertices) = (frames as u32, vertices as u32);
        Self { frames, vertices, first_vertex: 0, part_vertices: vertices }
    }
}

/// The triangles at each vertex, as two flat buffers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VertexTriangles {
    /// V + 1 entries: where each vertex's part of `triangles` begins.
    pub offsets: Vec<u32>,
    /// 3 T entries: triangle indices, ascending for each vertex.
    pub triangles: Vec<u32>,
}

impl VertexTriangles {
    /// Counts and sorts the corners of `triangles`; every index must be below `vertices`.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut offsets = vec![0u32; vertices + 1];
        for &v in triangles.as_flattened() {
            offsets[v as usize + 1] += 1;
        }
        for v in 0..vertices {
            offsets[v + 1] += offsets[v];
        }
        let mut next = offsets.clone();
        let mut sorted = vec![0; triangles.len() * 3];
        for (t, triangle) in triangles.iter().enumerate() {
            for &v in triangle {
                sorted[next[v as usize] as usize] = t as u32;
                next[v as usize] += 1;
            }
        }
        Self { offsets, triangles: sorted }
    }

    /// The triangles at vertex `v`.
    pub fn at(&self, v: usize) -> &[u32] {
        &self.triangles[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }
}

/// The two words of each corner at vertex `v`, given the triangles at it: the README's `corners`. A triangle that has the
/// vertex twice has no area, so that it does not matter which of the two a corner is.
pub fn corners<'a>(
    v: u32,
    triangles: &'a [[u32; 3]],
    incident: &'a [u32],
) -> impl Iterator<Item = [u32; 2]> + 'a {
    incident.iter().map(move |&t| {
        let triangle = triangles[t as usize];
        let corner = triangle.iter().position(|&other| other == v).unwrap_or(0);
        [triangle[(corner + 1) % 3] | (corner as u32) << 30, triangle[(corner + 2) % 3]]
    })
}

/// The triangle that [`corners`] has at vertex `v`.
pub fn triangle_of(v: u32, [next, last]: [u32; 2]) -> [u32; 3] {
    let mut triangle = [v, next & !(3 << 30), last];
    triangle.rotate_right((next >> 30) as usize);
    triangle
}

/// The normal of one vertex, given the triangles at it.
pub fn vertex_normal<T: Real>(positions: &[[T; 3]], triangles: &[[u32; 3]], incident: &[u32]) -> [T; 3] {
    let mut sum = [T::zero(); 3];
    for &t in incident {
        let [a, b, c] = triangles[t as usize].map(|v| positions[v as usize]);
        let area = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
        for i in 0..3 {
            sum[i] += area[i];
        }
    }
    vec3::normalize(sum)
}

/// The twin.
pub fn normals<T: Real>(
    params: Params,
    positions: &[[T; 3]],
    triangles: &[[u32; 3]],
    vertex_triangles: &VertexTriangles,
    vertex_normals: &mut [[T; 3]],
) {
    let vertices = params.vertices as usize;
    for frame in 0..params.frames as usize {
        let p = &positions[frame * vertices..][..vertices];
        for i in 0..params.part_vertices as usize {
            let v = params.first_vertex as usize + i;
            vertex_normals[frame * vertices + v] = vertex_normal(p, triangles, vertex_triangles.at(v));
        }
    }
}
