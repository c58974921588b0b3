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

    /// The same where some vertices are one point of the surface: `first` (V) has the lowest vertex of each
    /// vertex's point. Each vertex has all triangles around its point, so that all of the point have one
    /// normal.
    pub fn joined(vertices: usize, triangles: &[[u32; 3]], first: &[u32]) -> Self {
        let of_points = Self::new(vertices, &joined_triangles(triangles, first));
        let mut joined = Self { offsets: vec![0], triangles: Vec::with_capacity(of_points.triangles.len()) };
        for &first in first {
            joined.triangles.extend_from_slice(of_points.at(first as usize));
            joined.offsets.push(joined.triangles.len() as u32);
        }
        joined
    }

    /// The triangles at vertex `v`.
    pub fn at(&self, v: usize) -> &[u32] {
        &self.triangles[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }
}

/// Triangles with the lowest vertex of each corner's point in the place of the corner.
pub fn joined_triangles(triangles: &[[u32; 3]], first: &[u32]) -> Vec<[u32; 3]> {
    triangles.iter().map(|triangle| triangle.map(|v| first[v as usize])).collect()
}

/// The vertices around vertex v, given the triangles at it: the README's `fans`. Two consecutive vertices are
/// a triangle with v, in the triangle's order. Where one fan ends and another begins, v itself stands between
/// them.
///
/// Triangles that have a vertex twice have no area and are left out.
pub fn fan(v: u32, triangles: &[[u32; 3]], incident: &[u32]) -> Vec<u32> {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(incident.len());
    for &t in incident {
        let [a, b, c] = triangles[t as usize];
        let edge = if v == a {
            [b, c]
        } else if v == b {
            [c, a]
        } else {
            [a, b]
        };
        if edge[0] != edge[1] && !edge.contains(&v) {
            edges.push(edge);
        }
    }
    edges.sort_unstable();
    let mut ends: Vec<u32> = edges.iter().map(|edge| edge[1]).collect();
    ends.sort_unstable();
    // For each vertex, the entry of its first edge counts the edges from this vertex that have been walked.
    let mut walked = vec![0; edges.len()];
    let mut walk = |from: u32| {
        let first = edges.partition_point(|edge| edge[0] < from);
        let [begin, end] = *edges.get(first + walked.get(first)?)?;
        (begin == from).then(|| {
            walked[first] += 1;
            end
        })
    };
    let mut fan = Vec::with_capacity(edges.len() + 1);
    // Open fans are walked from their beginnings. The fans that remain are closed.
    let begins = edges.iter().map(|edge| edge[0]);
    for begin in begins.clone().filter(|begin| ends.binary_search(begin).is_err()).chain(begins) {
        while let Some(next) = walk(begin) {
            if !fan.is_empty() {
                fan.push(v);
            }
            fan.push(begin);
            fan.extend(std::iter::successors(Some(next), |&at| walk(at)));
        }
    }
    fan
}

/// The normal of one vertex, given the triangles at it.
pub fn vertex_normal<T: Real>(positions: &[[T; 3]], triangles: &[[u32; 3]], incident: &[u32]) -> [T; 3] {
    let mut sum = [T::ZERO; 3];
    for &t in incident {
        let [a, b, c] = triangles[t as usize].map(|v| positions[v as usize]);
        let area = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
        for i in 0..3 {
            sum[i] += area[i];
        }
    }
    vec3::normalize(sum)
}

/// The reference.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles at vertex v that a fan contains, ascending. Each begins with its smallest vertex.
    fn triangles_of(v: u32, fan: &[u32]) -> Vec<[u32; 3]> {
        let pairs = fan.array_windows().filter(|pair: &&[u32; 2]| !pair.contains(&v));
        sorted(pairs.map(|&[a, b]| [v, a, b]))
    }

    fn sorted(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
        let mut all: Vec<[u32; 3]> = triangles
            .map(|mut triangle| {
                let smallest = (0..3).min_by_key(|&i| triangle[i]).unwrap();
                triangle.rotate_left(smallest);
                triangle
            })
            .collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn a_fan_has_each_triangle_at_its_vertex_once() {
        let cases: [(&str, &[[u32; 3]], usize); 7] = [
            ("no triangle", &[], 0),
            ("closed, from any corner", &[[0, 1, 2], [3, 0, 2], [3, 4, 0], [0, 4, 1]], 5),
            ("open", &[[4, 0, 3], [0, 1, 2], [3, 0, 2]], 4),
            ("two that touch at the vertex alone", &[[0, 1, 2], [0, 2, 3], [5, 0, 4]], 6),
            ("turned against each other", &[[0, 1, 2], [0, 3, 2], [0, 1, 3]], 6),
            ("three at one edge, and one triangle twice", &[[0, 1, 2], [0, 1, 3], [0, 1, 2], [0, 2, 1]], 7),
            ("without area", &[[0, 0, 1], [0, 1, 1], [0, 1, 2], [2, 0, 2]], 2),
        ];
        for (name, triangles, words) in cases {
            let incident: Vec<u32> = (0..triangles.len() as u32).collect();
            let found = fan(0, triangles, &incident);
            let expected = triangles.iter().filter(|[a, b, c]| a != b && b != c && c != a);
            assert_eq!(triangles_of(0, &found), sorted(expected.copied()), "{name}: {found:?}");
            assert_eq!(found.len(), words, "{name}: {found:?}");
        }
    }
}
