//! The contents of the planned buffers: those of a rig once, those of a batch each time.
use super::{Buffer, Input, Limits, Plan, PlannedBuffer, Role, Sizes, Slice, tiles_of};
use crate::{BasisStorage, ClusteredBasis, HandleFrames, HandleId, Rig, StrainEdgeId};
use half::f16;
use rayon::prelude::*;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::tile::{TILE, tile_influences};
use rhytid_kernels::{bands, detail, normals, vec3};
use std::borrow::Cow;
use std::ops::Range;

impl Plan {
    /// The first bytes of a constant buffer; the bytes behind them are never read. Empty for the other
    /// buffers.
    ///
    /// `rig` must be the one that the plan was made for.
    pub fn contents<'a>(&self, rig: &'a Rig, buffer: usize) -> Cow<'a, [u8]> {
        let planned = &self.buffers[buffer];
        let part = match &planned.role {
            Role::Constant { part: Some(part) } => part.clone(),
            _ => 0..self.sizes.vertices,
        };
        let Sizes { handles, centers, .. } = self.sizes;
        let rbf_weights = &rig.fine_scale().rbf_weights;
        match planned.buffer {
            Buffer::Rest => Cow::Borrowed(bytemuck::cast_slice(&rig.surface().rest)),
            Buffer::HandleRest => owned(&self.handle_rest),
            Buffer::StrainEdges => Cow::Borrowed(bytemuck::cast_slice(&rig.handles().strain_edges)),
            Buffer::RestLengths => owned(&rig.handles().rest_lengths()),
            Buffer::PoseFeatures => {
                Cow::Borrowed(bytemuck::cast_slice(rig.fine_scale().pose_features.as_slice()))
            }
            Buffer::TangentNeighbors => Cow::Borrowed(bytemuck::cast_slice(&rig.surface().tangent_neighbors)),
            Buffer::Basis => match &self.clusters {
                Some(_) => self.cluster_columns(&part),
                None => self.stored(rig.basis().of_rows(part), handles),
            },
            Buffer::BasisRows => owned(&self.rows_of_tiles(&part)),
            Buffer::ClusterBasis => owned(&self.cluster_basis()),
            Buffer::InfluenceOffsets => owned(&of_tiles(&self.influence_offsets, &part, 2)),
            Buffer::Influences => {
                owned(&tiles(&part).flat_map_iter(|tile| influences_of(rig, tile).0).collect::<Vec<_>>())
            }
            Buffer::InfluenceWeights => {
                let rows = tiles(&part).flat_map_iter(|tile| influences_of(rig, tile).1);
                let rows = rows.collect::<Vec<_>>();
                if self.narrow() { owned(&bits_of_weights(&rows)) } else { owned(&rows) }
            }
            Buffer::FeatureGains => {
                owned(&tiles(&part).flat_map_iter(|tile| gains_of(rig, tile)).collect::<Vec<_>>())
            }
            Buffer::RbfWeights if self.zero_at_rest => {
                owned(&tiled(rbf_weights.of_rows(part).as_flattened(), centers * 3))
            }
            Buffer::RbfWeights => {
                let (weights, _) = detail::pivoted(rbf_weights.of_rows(part), centers);
                owned(&tiled(weights.as_flattened(), centers * 3))
            }
            Buffer::Pivots if self.zero_at_rest => owned(&vec![0u32; part.len().next_multiple_of(TILE)]),
            Buffer::Pivots => owned(&tiled(&detail::pivoted(rbf_weights.of_rows(part), centers).1, 1)),
            Buffer::FeatureLengths => {
                owned(&rig.handles().feature_lengths().iter().map(|&l| l as f32).collect::<Vec<_>>())
            }
            Buffer::ExampleVectors => owned(rig.example_vectors().as_slice()),
            Buffer::FeatureLimits => owned(&rig.feature_limits()),
            Buffer::BandWeights => owned(&self.band_weights.words_of(&tiles_of(&part))),
            Buffer::FanOffsets => owned(&of_tiles(&self.fan_offsets, &part, 1)),
            Buffer::Fans => {
                let triangles = rig.surface().vertex_triangles();
                let joined = rig.surface().joined_triangles();
                let fans = tiles(&part).flat_map_iter(|tile| fans_of(rig, &joined, &triangles, tile));
                owned(&fans.collect::<Vec<_>>())
            }
            Buffer::HandlePositions
            | Buffer::Displacements
            | Buffer::VectorExcess
            | Buffer::Motions
            | Buffer::ClusterMotions
            | Buffer::SquaredDifferences
            | Buffer::SquaredVectorDifferences
            | Buffer::BandOffsets
            | Buffer::Features
            | Buffer::LargeScalePositions
            | Buffer::LargeScaleNormals
            | Buffer::LocalDetail
            | Buffer::Positions
            | Buffer::VertexNormals => Cow::Borrowed(&[]),
        }
    }

    /// n numbers for each vertex, tiled, in the precision that the basis is stored in.
    fn stored(&self, numbers: &[f32], n: usize) -> Cow<'static, [u8]> {
        if self.storage == BasisStorage::F16 {
            let fp16: Vec<u16> = numbers.iter().map(|&x| f16::from_f32(x).to_bits()).collect();
            owned(&tiled(&fp16, n))
        } else {
            owned(&tiled(numbers, n))
        }
    }

    /// U of a part's vertices: a row of 16 numbers for each row of W of their cluster.
    fn cluster_columns(&self, part: &Range<usize>) -> Cow<'static, [u8]> {
        let Some(clusters) = &self.clusters else { return Cow::Borrowed(&[]) };
        let mut rows: Vec<[i16; TILE]> = Vec::new();
        for tile in tiles_of(part) {
            let first = tile * TILE;
            for column in &clusters.clusters()[first / ClusteredBasis::VERTICES].columns {
                let column = &column[first % ClusteredBasis::VERTICES..];
                rows.push(std::array::from_fn(|lane| column.get(lane).copied().unwrap_or(0)));
            }
        }
        owned(&rows)
    }

    /// W of all clusters, H×R.
    fn cluster_basis(&self) -> Vec<f32> {
        let Some(clusters) = &self.clusters else { return Vec::new() };
        let rows = clusters.handle_factors();
        (0..self.sizes.handles).flat_map(|h| rows.rows().map(move |row| row[h])).collect()
    }

    /// The rows of a part's tiles, counted from the part's first one.
    fn rows_of_tiles(&self, part: &Range<usize>) -> Vec<u32> {
        let rows = &self.basis_rows[2 * (part.start / TILE)..=2 * part.end.div_ceil(TILE)];
        let counted = |(i, row): (usize, &u32)| if i % 2 == 0 { row - rows[0] } else { *row };
        rows.iter().enumerate().map(counted).collect()
    }

    /// What to write before a batch runs.
    pub fn inputs<'a>(&self, frames: HandleFrames<'a>) -> impl Iterator<Item = Input<'a>> {
        let handles = self.sizes.handles;
        self.slices(frames.frames).enumerate().flat_map(move |(slice, Slice { frames: of_slice, .. })| {
            let positions = &frames.positions[of_slice.start * handles * 3..of_slice.end * handles * 3];
            let (vectors, _) = positions.as_chunks::<3>();
            let displacements = || {
                let moved = vectors.iter().zip(self.handle_rest.iter().cycle());
                moved.flat_map(|(p, rest)| padded(vec3::sub(*p, *rest))).collect()
            };
            let excess = || {
                let moved = |frame: &[[f32; 3]]| {
                    let moved = frame.iter().zip(&self.handle_rest);
                    moved.map(|(p, rest)| vec3::sub(*p, *rest)).collect::<Vec<_>>()
                };
                let of_frame = |limits: &Limits| {
                    vectors.chunks(handles).flat_map(|frame| limits.excess(&moved(frame))).flatten().collect()
                };
                self.limits.as_deref().map(of_frame).unwrap_or_default()
            };
            let motions = || {
                let motions = self.rotations.iter().flat_map(|rotations| rotations.motions(vectors));
                motions.flat_map(padded).collect()
            };
            let numbers = [
                (Buffer::HandlePositions, Cow::Borrowed(positions)),
                (Buffer::Displacements, Cow::Owned(displacements())),
                (Buffer::VectorExcess, Cow::Owned(excess())),
                (Buffer::Motions, Cow::Owned(motions())),
            ];
            numbers.into_iter().filter_map(move |(buffer, numbers)| {
                let is = |planned: &PlannedBuffer| {
                    planned.buffer == buffer && planned.role == Role::Input { slice }
                };
                let buffer = self.buffers.iter().position(is)?;
                Some(Input { buffer, numbers })
            })
        })
    }
}

/// A vector as devices read it: four numbers at a time.
fn padded([x, y, z]: [f32; 3]) -> [f32; 4] {
    [x, y, z, 0.0]
}

/// The tiles of a part.
fn tiles(part: &Range<usize>) -> rayon::range::Iter<usize> {
    tiles_of(part).into_par_iter()
}

/// The same weights of influences in 16 bits.
fn bits_of_weights(rows: &[[f32; TILE]]) -> Vec<[u16; TILE]> {
    rows.iter().map(|row| row.map(bands::bits_of_weight)).collect()
}

/// The offsets of a part's tiles in each of the `lists`, counted from the part's first row.
fn of_tiles(offsets: &[u32], part: &Range<usize>, lists: usize) -> Vec<u32> {
    let offsets = &offsets[lists * (part.start / TILE)..=lists * part.end.div_ceil(TILE)];
    offsets.iter().map(|offset| offset - offsets[0]).collect()
}

/// The first row of each tile's fans, and the end of the last ones.
pub(super) fn fan_offsets(rig: &Rig) -> Vec<u32> {
    let triangles = rig.surface().vertex_triangles();
    let joined = rig.surface().joined_triangles();
    offsets(rig, |tile| fans_of(rig, &joined, &triangles, tile).len())
}

/// The first row of each tile's influences and of its anchors, and the end of the last ones.
pub(super) fn influence_offsets(rig: &Rig) -> Vec<u32> {
    let rows: Vec<[usize; 2]> = tiles(&(0..rig.vertices()))
        .map(|tile| {
            let (influences, _) = influences_of(rig, tile);
            let edges =
                influences.partition_point(|&feature| (feature as usize) < rig.handles().strain_edges.len());
            [edges, influences.len() - edges]
        })
        .collect();
    ends(rows.into_flattened())
}

fn offsets(rig: &Rig, rows: impl Fn(usize) -> usize + Sync + Send) -> Vec<u32> {
    ends(tiles(&(0..rig.vertices())).map(rows).collect())
}

/// The beginning of each of several lists that stand one after the other, and the end of the last one.
fn ends(rows: Vec<usize>) -> Vec<u32> {
    let ends = rows.iter().scan(0, |end, &rows| {
        *end += rows as u32;
        Some(*end)
    });
    std::iter::once(0).chain(ends).collect()
}

/// The influences of a tile's vertices: strain edges with α and, where the rig has bands, anchors with ν.
/// Anchors are counted from F. Where a tile has no anchor, one with weight 0 is added, so that a kernel knows
/// where the edges end.
fn influences_of(rig: &Rig, tile: usize) -> (Vec<u32>, Vec<[f32; TILE]>) {
    let of_tile = |per_vertex: usize, indices: &[u32], weights: &[f32]| {
        let here = tile * TILE * per_vertex..((tile + 1) * TILE).min(rig.vertices()) * per_vertex;
        tile_influences(per_vertex, &indices[here.clone()], &weights[here])
    };
    let influences = rig.influences();
    let (mut indices, mut weights) = of_tile(
        influences.per_vertex(),
        StrainEdgeId::numbers(influences.edges.as_slice()),
        influences.weights.as_slice(),
    );
    if let Some(learned) = rig.bands() {
        let (numbers, nus) =
            (HandleId::numbers(learned.anchors.as_slice()), learned.anchor_weights.as_slice());
        let (anchors, of_anchors) = match of_tile(learned.anchors_per_vertex(), numbers, nus) {
            (anchors, _) if anchors.is_empty() => (vec![0], vec![[0.0; TILE]]),
            some => some,
        };
        indices.extend(anchors.iter().map(|anchor| rig.handles().strain_edges.len() as u32 + anchor));
        weights.extend(of_anchors);
    }
    (indices, weights)
}

/// g of the tile's vertices, in the rows of [`influences_of`].
fn gains_of(rig: &Rig, tile: usize) -> Vec<[f32; TILE]> {
    let (influences, _) = influences_of(rig, tile);
    let mut gains = vec![[0.0; TILE]; influences.len()];
    let Some(learned) = rig.learned() else { return gains };
    for v in tile * TILE..((tile + 1) * TILE).min(rig.vertices()) {
        for ((feature, _), gain) in rig.influences_of(v).zip(learned.feature_gains.row(v)) {
            // A feature without a weight has no gain.
            if let Some(row) = influences.iter().position(|other| *other as usize == feature) {
                gains[row][v % TILE] += gain;
            }
        }
    }
    gains
}

/// The fans of a tile's vertices side by side, each with its vertex behind it up to the longest. `joined` are
/// the rig's joined triangles.
fn fans_of(rig: &Rig, joined: &[[u32; 3]], triangles: &VertexTriangles, tile: usize) -> Vec<[u32; TILE]> {
    let first = tile * TILE;
    let vertices = first..(first + TILE).min(rig.vertices());
    let fan = |v: usize| normals::fan(rig.surface().first(v as u32), joined, triangles.at(v));
    let fans: Vec<Vec<u32>> = vertices.map(fan).collect();
    let at = |row: usize, lane: usize| match fans.get(lane) {
        Some(fan) => fan.get(row).copied().unwrap_or((first + lane) as u32),
        None => 0,
    };
    let rows = fans.iter().map(Vec::len).max().unwrap_or(0);
    (0..rows).map(|row| std::array::from_fn(|lane| at(row, lane))).collect()
}

fn owned<T: bytemuck::NoUninit>(numbers: &[T]) -> Cow<'static, [u8]> {
    Cow::Owned(bytemuck::cast_slice(numbers).to_vec())
}

/// From n numbers for each vertex to `[⌈V/16⌉][n][16]`. Numbers past V are zero.
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
