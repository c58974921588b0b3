//! Vertex normals: in each block every triangle's area is computed once, then summed at its vertices.
use crate::blocks::BLOCK;
use crate::simd::widest;
use rayon::prelude::*;
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use rhytid_kernels::vec3;

/// The triangles at the vertices of each block.
#[derive(Debug)]
pub struct Normals {
    blocks: Vec<Block>,
    triangles: Vec<[u32; 3]>,
    vertex_triangles: VertexTriangles,
}

/// The triangles of a block in ascending order, by the block's own numbers.
#[derive(Debug)]
struct Block {
    /// The vertices of its triangles, which may belong to other blocks; empty if there are too many of them for 16 bits.
    vertices: Vec<u32>,
    triangles: Vec<[u16; 3]>,
    /// How many triangles are at each of the block's vertices.
    counts: Vec<u16>,
    /// These triangles, ascending for each vertex.
    incident: Vec<u16>,
}

impl Normals {
    pub fn new(vertices: usize, triangles: Vec<[u32; 3]>) -> Self {
        let vertex_triangles = VertexTriangles::new(vertices, &triangles);
        let firsts = (0..vertices).step_by(BLOCK).collect::<Vec<_>>();
        let block =
            |first: usize| Block::new(first..(first + BLOCK).min(vertices), &triangles, &vertex_triangles);
        let blocks = firsts.into_par_iter().map(block).collect();
        Self { blocks, triangles, vertex_triangles }
    }

    /// The normals of frames × V positions.
    pub fn apply(&self, vertices: usize, positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
        for (positions, normals) in positions.chunks_exact(vertices).zip(normals.chunks_exact_mut(vertices)) {
            let work = normals.par_chunks_mut(BLOCK).zip(&self.blocks).enumerate();
            work.for_each_init(Scratch::default, |scratch, (i, (normals, block))| {
                if block.triangles.is_empty() {
                    for (j, n) in normals.iter_mut().enumerate() {
                        let incident = self.vertex_triangles.at(i * BLOCK + j);
                        *n = vertex_normal(positions, &self.triangles, incident);
                    }
                } else {
                    widest(
                        #[inline(always)]
                        || block.normals(positions, scratch, normals),
                    );
                }
            });
        }
    }
}

/// What a block computes on the way. Vectors are padded to four numbers.
#[derive(Default)]
struct Scratch {
    positions: Vec<[f32; 4]>,
    areas: Vec<[f32; 4]>,
    sums: Vec<[f32; 3]>,
}

impl Block {
    fn new(of: std::ops::Range<usize>, triangles: &[[u32; 3]], vertex_triangles: &VertexTriangles) -> Self {
        let mut ids: Vec<u32> = of.clone().flat_map(|v| vertex_triangles.at(v).iter().copied()).collect();
        ids.sort_unstable();
        ids.dedup();
        let mut vertices: Vec<u32> = ids.iter().flat_map(|&t| triangles[t as usize]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut block = Self { vertices, triangles: Vec::new(), counts: Vec::new(), incident: Vec::new() };
        let most = usize::from(u16::MAX);
        if block.vertices.len() > most || ids.len() > most {
            return Self { vertices: Vec::new(), ..block };
        }
        let own = |list: &[u32], x: u32| list.partition_point(|&y| y < x) as u16;
        block.triangles =
            ids.iter().map(|&t| triangles[t as usize].map(|v| own(&block.vertices, v))).collect();
        for v in of {
            let incident = vertex_triangles.at(v);
            block.counts.push(incident.len() as u16);
            block.incident.extend(incident.iter().map(|&t| own(&ids, t)));
        }
        block
    }

    /// Plain loops: what is inlined for certain is compiled for the widest vectors.
    #[inline(always)]
    fn normals(&self, positions: &[[f32; 3]], scratch: &mut Scratch, normals: &mut [[f32; 3]]) {
        let Scratch { positions: near, areas, sums } = scratch;
        near.resize(self.vertices.len().max(near.len()), [0.0; 4]);
        areas.resize(self.triangles.len().max(areas.len()), [0.0; 4]);
        sums.resize(BLOCK, [0.0; 3]);
        for (near, &v) in near.iter_mut().zip(&self.vertices) {
            let [x, y, z] = positions[v as usize];
            *near = [x, y, z, 0.0];
        }
        for (area, &[a, b, c]) in areas.iter_mut().zip(&self.triangles) {
            let (a, b, c) = (near[usize::from(a)], near[usize::from(b)], near[usize::from(c)]);
            let (u, v) = (vec3::sub(xyz(b), xyz(a)), vec3::sub(xyz(c), xyz(a)));
            let [x, y, z] = vec3::cross(u, v);
            *area = [x, y, z, 0.0];
        }
        let mut incident = &self.incident[..];
        for (sum, &count) in sums.iter_mut().zip(&self.counts) {
            let (here, rest) = incident.split_at(usize::from(count));
            incident = rest;
            let mut all = [0.0; 4];
            for &t in here {
                let area = &areas[usize::from(t)];
                for i in 0..4 {
                    all[i] += area[i];
                }
            }
            *sum = xyz(all);
        }
        for (n, sum) in normals.iter_mut().zip(sums.iter()) {
            *n = vec3::normalize(*sum);
        }
    }
}

#[inline(always)]
fn xyz([x, y, z, _]: [f32; 4]) -> [f32; 3] {
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_kernels::normals::{Params, normals};

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
        let found = Normals::new(vertices, triangles);
        assert!(found.blocks[1].triangles.is_empty() && !found.blocks[40].triangles.is_empty());
        let mut normals = vec![[0.0; 3]; vertices];
        found.apply(vertices, &positions, &mut normals);
        assert!(normals == expected);
    }
}
