//! The detail: radial basis functions of the strains, from a table of squared differences.
//!
//! `(f_e − f_je)²` depends on frame, strain edge and centre alone. A table of it makes the K × N gathers of a vertex K loads of
//! neighbouring numbers.
use crate::lanes::{Lanes, load3, store3};
use crate::rows::{GROUP, GroupRow, GroupVectors, TileRow, TileVectors};
use pulp::Simd;
use rhytid_core::Rig;
use rhytid_kernels::Number;
use rhytid_kernels::detail::pivoted;
use rhytid_kernels::table::TILE;

/// Centres in a row of one frame's table: what the widest registers hold.
const CENTERS: usize = 16;

/// Vertices side by side in the weights: in this order they stream through memory.
const ROW: usize = GROUP;

/// Vertices whose distances are summed at once.
const VERTICES: usize = 4;

/// The squared differences of a strain edge and some of the centres.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct TableRow([f32; CENTERS]);

impl TableRow {
    const ZERO: Self = Self([0.0; CENTERS]);
}

/// What the kernel reads of a rig.
#[derive(Debug)]
pub struct Detail {
    influences: usize,
    centers: usize,
    /// F.
    edges: usize,
    /// N × F.
    pose_features: Vec<f32>,
    indices: Indices,
    /// α, V × K, V being a multiple of 64.
    weights: Vec<f32>,
    /// w, `[V/16][N][3][16]`, with the pivot's sum in its place.
    rbf_weights: Vec<GroupVectors>,
    /// The pivot of each vertex; past V, 0.
    pivots: Vec<[u32; TILE]>,
}

/// V × K indices of strain edges, V being a multiple of 64, in as many bytes as they need.
#[derive(Debug)]
enum Indices {
    U8(Vec<u8>),
    U32(Vec<u32>),
}

impl Detail {
    pub fn new(rig: &Rig) -> Self {
        let (vertices, centers) = (rig.vertices(), rig.centers());
        let (weights, pivots) = pivoted(&rig.rbf_weights, centers);
        let tiles = vertices.div_ceil(TILE);
        let mut rbf_weights = vec![[GroupRow::ZERO; 3]; tiles * TILE / ROW * centers];
        for (i, w) in weights.iter().enumerate() {
            let (v, j) = (i / centers, i % centers);
            for c in 0..3 {
                rbf_weights[v / ROW * centers + j][c].0[v % ROW] = w[c];
            }
        }
        let mut tiled = vec![[0; TILE]; tiles];
        pivots.iter().enumerate().for_each(|(v, &pivot)| tiled[v / TILE][v % TILE] = pivot);
        let mut edges = rig.influence_edges.clone();
        edges.resize(vertices.next_multiple_of(TILE) * rig.influences(), 0);
        let mut influence_weights = rig.influence_weights.clone();
        influence_weights.resize(edges.len(), 0.0);
        Self {
            influences: rig.influences(),
            centers,
            edges: rig.strain_edges.len(),
            pose_features: rig.pose_features.clone(),
            indices: if rig.strain_edges.len() <= 256 {
                Indices::U8(edges.iter().map(|&e| e as u8).collect())
            } else {
                Indices::U32(edges)
            },
            weights: influence_weights,
            rbf_weights,
            pivots: tiled,
        }
    }

    /// The squared differences of one frame's features, `[N/16][F][16]`; past N, 0.
    pub fn frame_table(&self, features: &[f32]) -> Vec<TableRow> {
        let mut table = vec![TableRow::ZERO; self.centers.div_ceil(CENTERS) * self.edges];
        for j in 0..self.centers {
            let rows = &mut table[j / CENTERS * self.edges..];
            for (e, row) in rows.iter_mut().enumerate().take(self.edges) {
                let difference = features[e] - self.pose_features[j * self.edges + e];
                row.0[j % CENTERS] = difference * difference;
            }
        }
        table
    }

    /// The squared differences of frames × F features of at most [`GROUP`] frames, F × N.
    pub fn group_table(&self, features: &[f32]) -> Vec<GroupRow> {
        let mut table = vec![GroupRow::ZERO; self.edges * self.centers];
        for (i, row) in table.iter_mut().enumerate() {
            let (e, j) = (i / self.centers, i % self.centers);
            for (lane, f) in features.chunks_exact(self.edges).enumerate() {
                let difference = f[e] - self.pose_features[j * self.edges + e];
                row.0[lane] = difference * difference;
            }
        }
        table
    }

    /// Room for the distances of a tile's vertices from all centres.
    pub fn tile_scratch(&self) -> Vec<TileRow> {
        vec![TileRow::ZERO; self.centers]
    }

    /// d of a tile's vertices, in one frame.
    #[inline(always)]
    pub fn tile<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        table: &[TableRow],
        distances: &mut [TileRow],
    ) -> TileVectors {
        match &self.indices {
            Indices::U8(indices) => self.distances(simd, indices, tile, table, distances),
            Indices::U32(indices) => self.distances(simd, indices, tile, table, distances),
        }
        let pivots = &self.pivots[tile];
        let mut at_pivot = TileRow::ZERO;
        for (lane, (r, pivot)) in at_pivot.0.iter_mut().zip(pivots).enumerate() {
            *r = distances[*pivot as usize].0[lane];
        }
        let mut d = [TileRow::ZERO; 3];
        for part in 0..TILE / S::F32_LANES {
            let (row, part_of_row) = (part * S::F32_LANES / ROW, part % (ROW / S::F32_LANES));
            let rbf_weights = &self.rbf_weights[(tile * TILE / ROW + row) * self.centers..][..self.centers];
            let pivots = S::as_simd_u32s(pivots).0[part];
            let at_pivot = Lanes::load(simd, &at_pivot.0, part);
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for (j, w) in rbf_weights.iter().enumerate() {
                let is_pivot = simd.equal_u32s(pivots, simd.splat_u32s(j as u32));
                let w = load3(simd, w, part_of_row);
                for c in 0..3 {
                    sum[c].1 = simd.select_f32s(is_pivot, (w[c] * at_pivot).1, sum[c].1);
                }
            }
            for (j, (r, w)) in distances.iter().zip(rbf_weights).enumerate() {
                let is_pivot = simd.equal_u32s(pivots, simd.splat_u32s(j as u32));
                let away = Lanes::load(simd, &r.0, part) - at_pivot;
                let w = load3(simd, w, part_of_row);
                for c in 0..3 {
                    sum[c].1 = simd.select_f32s(is_pivot, sum[c].1, w[c].times_plus(away, sum[c]).1);
                }
            }
            store3(sum, &mut d, part);
        }
        d
    }

    /// r of a tile's vertices from each centre: of several vertices at once, since each sum waits for its last addition.
    #[inline(always)]
    fn distances<S: Simd, I: Copy + Into<u32>>(
        &self,
        simd: S,
        indices: &[I],
        tile: usize,
        table: &[TableRow],
        distances: &mut [TileRow],
    ) {
        let k = self.influences;
        let here = tile * TILE * k..(tile + 1) * TILE * k;
        let (indices, weights) = (&indices[here.clone()], &self.weights[here]);
        let registers = CENTERS / S::F32_LANES;
        for (chunk, rows) in distances.chunks_mut(S::F32_LANES).enumerate() {
            let table = &table[chunk / registers * self.edges..][..self.edges];
            let part = chunk % registers;
            for lane in (0..TILE).step_by(VERTICES) {
                let indices = of_vertices(indices, lane, k);
                let weights = of_vertices(weights, lane, k);
                let mut sums = [Lanes::splat(simd, 0.0); VERTICES];
                for i in 0..k {
                    for v in 0..VERTICES {
                        let squares = &table[indices[v][i].into() as usize];
                        let squares = Lanes::load(simd, &squares.0, part);
                        sums[v] = Lanes::splat(simd, weights[v][i]).times_plus(squares, sums[v]);
                    }
                }
                let mut by_vertex = [TableRow::ZERO; VERTICES];
                for v in 0..VERTICES {
                    sums[v].store(&mut by_vertex[v].0, 0);
                }
                for (c, row) in rows.iter_mut().enumerate() {
                    for (v, sums) in by_vertex.iter().enumerate() {
                        row.0[lane + v] = sums.0[c];
                    }
                }
            }
        }
        for row in distances {
            for part in 0..TILE / S::F32_LANES {
                Lanes::load(simd, &row.0, part).root().store(&mut row.0, part);
            }
        }
    }

    /// Room for the distances of a vertex from all centres in a group of frames.
    pub fn group_scratch(&self) -> Vec<GroupRow> {
        vec![GroupRow::ZERO; self.centers]
    }

    /// d of vertex `v` in a group of frames.
    #[inline(always)]
    pub fn group<S: Simd>(
        &self,
        simd: S,
        v: usize,
        table: &[GroupRow],
        distances: &mut [GroupRow],
    ) -> GroupVectors {
        let mut d = [GroupRow::ZERO; 3];
        for part in 0..GROUP / S::F32_LANES {
            match &self.indices {
                Indices::U8(indices) => self.group_distances(simd, indices, (v, part), table, distances),
                Indices::U32(indices) => self.group_distances(simd, indices, (v, part), table, distances),
            }
            let pivot = self.pivots[v / TILE][v % TILE] as usize;
            let (weights, lane) = (&self.rbf_weights[v / ROW * self.centers..][..self.centers], v % ROW);
            let at_pivot = Lanes::load(simd, &distances[pivot].0, part);
            let mut sum = [at_pivot; 3];
            for c in 0..3 {
                sum[c] = Lanes::splat(simd, weights[pivot][c].0[lane]) * at_pivot;
            }
            for (j, (r, w)) in distances.iter().zip(weights).enumerate() {
                if j != pivot {
                    let away = Lanes::load(simd, &r.0, part) - at_pivot;
                    for c in 0..3 {
                        sum[c] = Lanes::splat(simd, w[c].0[lane]).times_plus(away, sum[c]);
                    }
                }
            }
            store3(sum, &mut d, part);
        }
        d
    }

    /// r of vertex `v` from each centre, in one part of a group.
    #[inline(always)]
    fn group_distances<S: Simd, I: Copy + Into<u32>>(
        &self,
        simd: S,
        indices: &[I],
        (v, part): (usize, usize),
        table: &[GroupRow],
        distances: &mut [GroupRow],
    ) {
        let k = self.influences;
        let (indices, weights) = (&indices[v * k..][..k], &self.weights[v * k..][..k]);
        for (j, r) in distances.iter_mut().enumerate() {
            let mut sum = Lanes::splat(simd, 0.0);
            for (e, alpha) in indices.iter().zip(weights) {
                let squares = &table[(*e).into() as usize * self.centers + j];
                sum = Lanes::splat(simd, *alpha).times_plus(Lanes::load(simd, &squares.0, part), sum);
            }
            sum.root().store(&mut r.0, part);
        }
    }
}

/// The K entries of each of a few vertices.
#[inline(always)]
fn of_vertices<T>(entries: &[T], first: usize, k: usize) -> [&[T]; VERTICES] {
    [0, 1, 2, 3].map(
        #[inline(always)]
        |v| &entries[(first + v) * k..][..k],
    )
}
