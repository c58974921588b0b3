//! The triangles of each block of vertices, and the normals of one frame.
use crate::blocks::blocks;
use crate::lanes::{load3, store3};
use crate::rows::{TileRow, TileVectors};
use glam::Vec3A;
use pulp::Simd;
use rayon::prelude::*;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::table::TILE;
use rhytid_kernels::vec3;
use std::ops::Range;

/// The triangles that touch a block's vertices, ascending, and the vertices' frame neighbours, by the block's own numbers: first its
/// vertices, then the others that it needs.
#[derive(Debug)]
pub struct BlockMesh {
    own: Range<usize>,
    others: Vec<u32>,
    numbers: Numbers,
}

/// Triangles and frame neighbours in as many bytes as the block's numbers need.
#[derive(Debug)]
enum Numbers {
    U16(Vec<[u16; 3]>, Vec<u16>),
    U32(Vec<[u32; 3]>, Vec<u32>),
}

/// What a thread computes on the way.
#[derive(Default)]
pub struct MeshScratch {
    near: Vec<Vec3A>,
    sums: Vec<Vec3A>,
}

impl BlockMesh {
    /// For all blocks of a face.
    pub fn all(
        length: usize,
        vertices: usize,
        triangles: &[[u32; 3]],
        vertex_triangles: &VertexTriangles,
        frame_neighbors: &[u32],
    ) -> Vec<Self> {
        let blocks: Vec<_> = blocks(vertices, length).collect();
        blocks
            .into_par_iter()
            .map(|own| Self::new(own, triangles, vertex_triangles, frame_neighbors))
            .collect()
    }

    fn new(
        own: Range<usize>,
        triangles: &[[u32; 3]],
        vertex_triangles: &VertexTriangles,
        frame_neighbors: &[u32],
    ) -> Self {
        let mut ids: Vec<u32> = own.clone().flat_map(|v| vertex_triangles.at(v)).copied().collect();
        ids.sort_unstable();
        ids.dedup();
        let triangles = ids.iter().map(|&t| triangles[t as usize]);
        let neighbors = &frame_neighbors[own.clone()];
        let all = triangles.clone().flatten().chain(neighbors.iter().copied());
        let mut others: Vec<u32> = all.filter(|&v| !own.contains(&(v as usize))).collect();
        others.sort_unstable();
        others.dedup();
        let number = |v: u32| {
            let other = || own.len() + others.partition_point(|&o| o < v);
            if own.contains(&(v as usize)) { v as usize - own.start } else { other() }
        };
        let numbers = if own.len() + others.len() <= usize::from(u16::MAX) {
            let number = |v| number(v) as u16;
            Numbers::U16(
                triangles.map(|t| t.map(number)).collect(),
                neighbors.iter().map(|&v| number(v)).collect(),
            )
        } else {
            let number = |v| number(v) as u32;
            Numbers::U32(
                triangles.map(|t| t.map(number)).collect(),
                neighbors.iter().map(|&v| number(v)).collect(),
            )
        };
        Self { own, others, numbers }
    }

    /// The block's vertices.
    pub fn own(&self) -> Range<usize> {
        self.own.clone()
    }

    /// The normals of the block's vertices, a tile after the other; what is behind the last vertex is zero.
    #[inline(always)]
    pub fn normals<S: Simd>(
        &self,
        simd: S,
        positions: &[[f32; 3]],
        scratch: &mut MeshScratch,
        normals: &mut Vec<TileVectors>,
    ) {
        let MeshScratch { near, sums } = scratch;
        near.clear();
        near.extend(positions[self.own()].iter().map(|&p| Vec3A::from_array(p)));
        near.extend(self.others.iter().map(|&v| Vec3A::from_array(positions[v as usize])));
        sums.clear();
        sums.resize(near.len(), Vec3A::ZERO);
        match &self.numbers {
            Numbers::U16(triangles, _) => sum_areas(triangles, near, sums),
            Numbers::U32(triangles, _) => sum_areas(triangles, near, sums),
        }
        normals.clear();
        for sums in sums[..self.own.len()].chunks(TILE) {
            let mut tile = [TileRow::ZERO; 3];
            for (lane, sum) in sums.iter().enumerate() {
                let sum = sum.to_array();
                for c in 0..3 {
                    tile[c].0[lane] = sum[c];
                }
            }
            for part in 0..TILE / S::F32_LANES {
                store3(vec3::normalize(load3(simd, &tile, part)), &mut tile, part);
            }
            normals.push(tile);
        }
    }

    /// The positions of a tile's vertices and of their frame neighbours, after [`BlockMesh::normals`] of the same frame.
    #[inline(always)]
    pub fn with_neighbors(&self, scratch: &MeshScratch, tile: usize) -> [TileVectors; 2] {
        let first = tile * TILE;
        let count = (self.own.len() - first).min(TILE);
        match &self.numbers {
            Numbers::U16(_, neighbors) => pairs(&neighbors[first..][..count], first, &scratch.near),
            Numbers::U32(_, neighbors) => pairs(&neighbors[first..][..count], first, &scratch.near),
        }
    }
}

/// Adds each triangle's area to its three vertices: ascending, so that each vertex has the twin's order.
#[inline(always)]
fn sum_areas<I: Copy + Into<u32>>(triangles: &[[I; 3]], near: &[Vec3A], sums: &mut [Vec3A]) {
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| v.into() as usize);
        let area = (near[b] - near[a]).cross(near[c] - near[a]);
        for v in [a, b, c] {
            sums[v] += area;
        }
    }
}

#[inline(always)]
fn pairs<I: Copy + Into<u32>>(neighbors: &[I], first: usize, near: &[Vec3A]) -> [TileVectors; 2] {
    let mut pairs = [[TileRow::ZERO; 3]; 2];
    for (lane, (neighbor, own)) in neighbors.iter().zip(&near[first..]).enumerate() {
        let both = [own.to_array(), near[(*neighbor).into() as usize].to_array()];
        for (rows, vector) in pairs.iter_mut().zip(both) {
            for c in 0..3 {
                rows[c].0[lane] = vector[c];
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vectors::Vectors;
    use pulp::WithSimd;
    use rhytid_kernels::normals::{Params, normals};

    struct All<'a>(&'a [BlockMesh], &'a [[f32; 3]], &'a mut Vec<[f32; 3]>);

    impl WithSimd for All<'_> {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let (mut scratch, mut tiles) = (MeshScratch::default(), Vec::new());
            for mesh in self.0 {
                mesh.normals(simd, self.1, &mut scratch, &mut tiles);
                let lanes = tiles.iter().flat_map(|[x, y, z]| (0..TILE).map(|i| [x.0[i], y.0[i], z.0[i]]));
                self.2.extend(lanes.take(mesh.own().len()));
            }
        }
    }

    /// More triangles at one vertex than 16 bits count, and blocks on either side of that.
    #[test]
    fn a_fan_of_seventy_thousand_triangles_has_the_twins_normals() {
        let rim = 70_000;
        let triangles: Vec<[u32; 3]> = (0..rim).map(|i| [2000, i + 2001, (i + 1) % rim + 2001]).collect();
        let mut positions = vec![[0.0; 3]; 2001 + rim as usize];
        for (i, p) in positions.iter_mut().enumerate().skip(2001) {
            let angle = i as f32 * 9e-5;
            *p = [angle.cos(), angle.sin(), (7.0 * angle).cos()];
        }
        let vertices = positions.len();
        let mut expected = vec![[0.0; 3]; vertices];
        let vertex_triangles = VertexTriangles::new(vertices, &triangles);
        normals(Params::whole(1, vertices), &positions, &triangles, &vertex_triangles, &mut expected);
        let neighbors = vec![0; vertices];
        let meshes = BlockMesh::all(1024, vertices, &triangles, &vertex_triangles, &neighbors);
        let wide = |mesh: &BlockMesh| matches!(mesh.numbers, Numbers::U32(..));
        assert!(wide(&meshes[1]) && !wide(&meshes[40]));
        let mut normals = Vec::new();
        Vectors::Widest.run(All(&meshes, &positions, &mut normals));
        assert!(normals == expected);
    }
}
