//! The triangles of each block of vertices, and the normals of one frame.
use crate::blocks::blocks;
use crate::lanes::{load3, store3};
use crate::lines::{Line, Line3};
use glam::{Mat4, Vec3A, Vec4};
use pulp::Simd;
use rayon::prelude::*;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::tile::TILE;
use rhytid_kernels::vec3;
use std::ops::Range;

/// The triangles that touch a block's vertices, ascending, and the vertices' tangent neighbours. They have
/// the block's own vertex numbers: first its vertices, then the others that it needs.
#[derive(Debug)]
pub(crate) struct BlockMesh {
    own: Range<usize>,
    others: Vec<u32>,
    numbers: Numbers,
    /// The block's vertices that are not the lowest of their points, each with the lowest, by the block's own
    /// numbers.
    copies: Vec<[u32; 2]>,
}

/// Pairs of triangles, and tangent neighbours, in as few bytes as the block's numbers need.
#[derive(Debug)]
enum Numbers {
    U16(Vec<[u16; 4]>, Vec<u16>),
    U32(Vec<[u32; 4]>, Vec<u32>),
}

/// A thread's scratch.
#[derive(Debug, Default)]
pub(crate) struct MeshScratch {
    near: Vec<Near>,
}

/// A vertex, by the block's own numbers.
#[derive(Debug, Clone, Copy)]
struct Near {
    position: Vec3A,
    /// Twice the areas of its triangles.
    areas: Vec3A,
}

impl Near {
    #[inline(always)]
    fn new(position: Vec3A) -> Self {
        Self { position, areas: Vec3A::ZERO }
    }
}

impl BlockMesh {
    /// For all blocks of a rig. `triangles` are its joined ones. `first` is the lowest vertex of a vertex's
    /// point.
    pub(crate) fn all(
        length: usize,
        vertices: usize,
        triangles: &[[u32; 3]],
        vertex_triangles: &VertexTriangles,
        tangent_neighbors: &[u32],
        first: impl Fn(u32) -> u32 + Sync,
    ) -> Vec<Self> {
        let blocks: Vec<_> = blocks(vertices, length).collect();
        blocks
            .into_par_iter()
            .map(|own| Self::new(own, triangles, vertex_triangles, tangent_neighbors, &first))
            .collect()
    }

    fn new(
        own: Range<usize>,
        triangles: &[[u32; 3]],
        vertex_triangles: &VertexTriangles,
        tangent_neighbors: &[u32],
        first: impl Fn(u32) -> u32,
    ) -> Self {
        let copies = || (own.start as u32..own.end as u32).filter(|&v| first(v) != v);
        let mut ids: Vec<u32> = own.clone().flat_map(|v| vertex_triangles.at(v)).copied().collect();
        ids.sort_unstable();
        ids.dedup();
        let pairs = pairs(ids.iter().map(|&t| triangles[t as usize]));
        let neighbors = &tangent_neighbors[own.clone()];
        let all = pairs.iter().flatten().copied().chain(neighbors.iter().copied());
        let all = all.chain(copies().map(&first));
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
                pairs.iter().map(|pair| pair.map(number)).collect(),
                neighbors.iter().map(|&v| number(v)).collect(),
            )
        } else {
            let number = |v| number(v) as u32;
            Numbers::U32(
                pairs.iter().map(|pair| pair.map(number)).collect(),
                neighbors.iter().map(|&v| number(v)).collect(),
            )
        };
        let copies = copies().map(|v| [number(v) as u32, number(first(v)) as u32]).collect();
        Self { own, others, numbers, copies }
    }

    /// The block's vertices.
    pub(crate) fn own(&self) -> Range<usize> {
        self.own.clone()
    }

    /// The normals of the block's vertices, tile after tile. Numbers behind the last vertex are zero.
    #[inline(always)]
    pub(crate) fn normals<S: Simd>(
        &self,
        simd: S,
        positions: &[[f32; 3]],
        scratch: &mut MeshScratch,
        normals: &mut Vec<Line3>,
    ) {
        let near = &mut scratch.near;
        near.clear();
        // Vertices are read four numbers at a time, of which the fourth belongs to the next vertex. The last
        // vertex has no next one.
        let own = positions[self.own()].as_flattened();
        near.extend(
            own.windows(4).step_by(3).map(|four| Near::new(Vec3A::from_vec4(Vec4::from_slice(four)))),
        );
        near.extend(own.last_chunk().map(|&last| Near::new(Vec3A::from_array(last))));
        near.extend(self.others.iter().map(|&v| Near::new(Vec3A::from_array(positions[v as usize]))));
        match &self.numbers {
            Numbers::U16(pairs, _) => sum_areas(pairs, near),
            Numbers::U32(pairs, _) => sum_areas(pairs, near),
        }
        for &[copy, first] in &self.copies {
            near[copy as usize].areas = near[first as usize].areas;
        }
        normals.clear();
        for near in near[..self.own.len()].chunks(TILE) {
            let mut normal = side_by_side(|lane| near.get(lane).map_or(Vec3A::ZERO, |near| near.areas));
            for register in 0..TILE / S::F32_LANES {
                store3(vec3::normalize(load3(simd, &normal, register)), &mut normal, register);
            }
            normals.push(normal);
        }
    }

    /// The positions of the vertices of the block's `tile`th tile and of their tangent neighbours, after
    /// [`BlockMesh::normals`] of the same frame.
    #[inline(always)]
    pub(crate) fn with_neighbors(&self, scratch: &MeshScratch, tile: usize) -> [Line3; 2] {
        let vertices = tile * TILE..self.own.len().min((tile + 1) * TILE);
        match &self.numbers {
            Numbers::U16(_, neighbors) => {
                positions(&neighbors[vertices.clone()], &scratch.near[vertices], &scratch.near)
            }
            Numbers::U32(_, neighbors) => {
                positions(&neighbors[vertices.clone()], &scratch.near[vertices], &scratch.near)
            }
        }
    }
}

/// Triangles in pairs. A triangle is paired with the next one where both make a quad: a, b, c, d are the
/// triangles a, b, c and a, c, d. Where d is c, there is only the first, since the second has no area.
pub(crate) fn pairs(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 4]> {
    let mut pairs: Vec<[u32; 4]> = Vec::new();
    for [a, b, c] in triangles {
        match pairs.last_mut() {
            Some([first, _, second, third]) if third == second && [*first, *second] == [a, b] => *third = c,
            _ => pairs.push([a, b, c, c]),
        }
    }
    pairs
}

/// Adds each triangle's area to its three vertices. Triangles ascend, so each vertex has the reference's
/// order.
#[inline(always)]
fn sum_areas<I: Copy + Into<u32>>(pairs: &[[I; 4]], near: &mut [Near]) {
    for pair in pairs {
        let [i, j, k, l] = pair.map(|v| v.into() as usize);
        let a = near[i].position;
        let [b, c, d] = [j, k, l].map(|v| near[v].position - a);
        let (first, second) = (b.cross(c), c.cross(d));
        near[i].areas = near[i].areas + first + second;
        near[j].areas += first;
        near[k].areas = near[k].areas + first + second;
        near[l].areas += second;
    }
}

#[inline(always)]
fn positions<I: Copy + Into<u32>>(neighbors: &[I], own: &[Near], near: &[Near]) -> [Line3; 2] {
    [
        side_by_side(|lane| own.get(lane).map_or(Vec3A::ZERO, |near| near.position)),
        side_by_side(|lane| neighbors.get(lane).map_or(Vec3A::ZERO, |&v| near[v.into() as usize].position)),
    ]
}

/// A tile's vectors, with a line for each coordinate.
#[inline(always)]
fn side_by_side(vector: impl Fn(usize) -> Vec3A) -> Line3 {
    let mut lines = [Line::ZERO; 3];
    for lane in (0..TILE).step_by(4) {
        let four = [0, 1, 2, 3].map(|i| vector(lane + i).extend(0.0));
        let by_coordinate = Mat4::from_cols(four[0], four[1], four[2], four[3]).transpose();
        for (line, numbers) in lines.iter_mut().zip(by_coordinate.to_cols_array_2d()) {
            line.0[lane..lane + 4].copy_from_slice(&numbers);
        }
    }
    lines
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

    /// More triangles at one vertex than 16 bits can count, and blocks below and above this number.
    #[test]
    fn a_fan_of_seventy_thousand_triangles_has_the_references_normals() {
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
        let meshes = BlockMesh::all(1024, vertices, &triangles, &vertex_triangles, &neighbors, |v| v);
        let wide = |mesh: &BlockMesh| matches!(mesh.numbers, Numbers::U32(..));
        assert!(wide(&meshes[1]) && !wide(&meshes[40]));
        let mut normals = Vec::new();
        Vectors::Widest.run(All(&meshes, &positions, &mut normals));
        assert!(normals == expected);
    }
}
