//! What is in the planned buffers: of a rig once, of a batch each time.
use super::{Input, Plan, Role, Sizes, Slice, TILE};
use crate::{HandleFrames, Rig};
use half::f16;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::{detail, normals, strain};
use std::borrow::Cow;
use std::ops::Range;

impl Plan {
    /// What a constant buffer starts with; what is behind that is never read. Empty for the other buffers.
    ///
    /// `rig` is the one that the plan was made for.
    pub fn contents<'a>(&self, rig: &'a Rig, buffer: usize) -> Cow<'a, [u8]> {
        let Role::Constant { part } = &self.buffers[buffer].role else { return Cow::Borrowed(&[]) };
        let part = part.clone().unwrap_or_default();
        let Sizes { handles, edges, influences, centers, .. } = self.sizes;
        let of_part = |per_vertex: usize| part.start * per_vertex..part.end * per_vertex;
        match self.buffers[buffer].name {
            "rest" => Cow::Borrowed(bytemuck::cast_slice(&rig.rest)),
            "handle_rest" => owned(&self.handle_rest),
            "strain_edges" => Cow::Borrowed(bytemuck::cast_slice(&rig.strain_edges)),
            "rest_lengths" => owned(&strain::rest_lengths(&rig.rest, &rig.handles, &rig.strain_edges)),
            "pose_features" => Cow::Borrowed(bytemuck::cast_slice(&rig.pose_features)),
            "frame_neighbors" => Cow::Borrowed(bytemuck::cast_slice(&rig.frame_neighbors)),
            "basis" if self.half_basis => {
                let halves: Vec<u16> =
                    rig.basis[of_part(handles)].iter().map(|&b| f16::from_f32(b).to_bits()).collect();
                owned(&tiled(&halves, handles))
            }
            "basis" => owned(&tiled(&rig.basis[of_part(handles)], handles)),
            "influence_edges" => {
                let per_word = detail::edges_per_word(edges);
                let edges = zeros_last(rig, of_part(influences), &rig.influence_edges);
                let of_vertices = edges.chunks_exact(influences.max(1));
                let words: Vec<u32> = of_vertices.flat_map(|edges| detail::packed(edges, per_word)).collect();
                owned(&tiled(&words, influences.div_ceil(per_word)))
            }
            "influence_weights" => {
                owned(&tiled(&zeros_last(rig, of_part(influences), &rig.influence_weights), influences))
            }
            "rbf_weights" => {
                let (weights, _) = detail::pivoted(&rig.rbf_weights[of_part(centers)], centers);
                owned(&tiled(weights.as_flattened(), centers * 3))
            }
            "pivots" => owned(&tiled(&detail::pivoted(&rig.rbf_weights[of_part(centers)], centers).1, 1)),
            "corner_offsets" => {
                let triangles = VertexTriangles::new(rig.vertices(), &rig.triangles);
                let offsets = &triangles.offsets[part.start..=part.end];
                owned(&offsets.iter().map(|offset| offset - offsets[0]).collect::<Vec<u32>>())
            }
            "corners" => {
                let triangles = VertexTriangles::new(rig.vertices(), &rig.triangles);
                owned(
                    &part
                        .flat_map(|v| normals::corners(v as u32, &rig.triangles, triangles.at(v)))
                        .collect::<Vec<_>>(),
                )
            }
            name => unreachable!("no constant is called {name}"),
        }
    }

    /// What to write before a batch runs.
    pub fn inputs<'a>(&self, frames: HandleFrames<'a>) -> impl Iterator<Item = Input<'a>> {
        let handles = self.sizes.handles;
        self.slices(frames.frames).enumerate().flat_map(move |(slice, Slice { frames: of_slice, .. })| {
            let positions = &frames.positions[of_slice.start * handles * 3..of_slice.end * handles * 3];
            let rest = self.handle_rest.iter().cycle();
            let displacements = positions
                .as_chunks::<3>()
                .0
                .iter()
                .zip(rest)
                .flat_map(|(p, rest)| [p[0] - rest[0], p[1] - rest[1], p[2] - rest[2], 0.0]);
            let displacements = displacements.collect::<Vec<f32>>();
            let buffer = |name| self.find(name, None, slice);
            [
                Input { buffer: buffer("handle_positions"), numbers: Cow::Borrowed(positions) },
                Input { buffer: buffer("displacements"), numbers: Cow::Owned(displacements) },
            ]
        })
    }
}

/// Those of V × K entries that belong to `range`, each vertex's with α = 0 last. Before those, the ones whose α is so small that some
/// devices take it for zero.
fn zeros_last<T: Copy>(rig: &Rig, range: Range<usize>, entries: &[T]) -> Vec<T> {
    let k = rig.influences().max(1);
    let rank = |alpha: f32| u8::from(alpha < f32::MIN_POSITIVE) + u8::from(alpha == 0.0);
    let weights = rig.influence_weights[range.clone()].chunks_exact(k);
    let mut order = Vec::with_capacity(k);
    let of_vertices = entries[range].chunks_exact(k).zip(weights);
    of_vertices
        .flat_map(|(entries, weights)| {
            order.clear();
            order.extend(0..k);
            order.sort_by_key(|&i| rank(weights[i]));
            order.iter().map(|&i| entries[i]).collect::<Vec<T>>()
        })
        .collect()
}

fn owned<T: bytemuck::NoUninit>(numbers: &[T]) -> Cow<'static, [u8]> {
    Cow::Owned(bytemuck::cast_slice(numbers).to_vec())
}

/// From n numbers for each vertex to `[⌈V/16⌉][n][16]`; what is past V is zero.
fn tiled<T: Copy + Default>(numbers: &[T], n: usize) -> Vec<T> {
    if n == 0 {
        return Vec::new();
    }
    let vertices = numbers.len() / n;
    let mut tiles = vec![T::default(); vertices.next_multiple_of(TILE) * n];
    for (v, of_vertex) in numbers.chunks_exact(n).enumerate() {
        let tile = &mut tiles[v / TILE * TILE * n..];
        for (i, &number) in of_vertex.iter().enumerate() {
            tile[i * TILE + v % TILE] = number;
        }
    }
    tiles
}
