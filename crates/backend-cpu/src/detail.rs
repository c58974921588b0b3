//! The detail: radial basis functions of the strains.
//!
//! The squared distances of vertices from centres are `Σ_k α_k (f_e(k) − f_je(k))²`. This is a sparse matrix,
//! V × F, times the table of squared differences, F × N.
use crate::lanes::{Lanes, load3, store3};
use crate::lines::{GROUP, Line, Line3};
use crate::tile_weights::{
    CellTable, FRAME_COLUMNS, FrameCells, GROUP_COLUMNS, GROUP_VERTICES, GroupCells, TileWeights, tiled3,
};
use pulp::Simd;
use rhytid_core::{Rig, Table};
use rhytid_kernels::detail::pivoted;
use rhytid_kernels::tile::TILE;
use rhytid_kernels::{Number, differences};

/// The data of a rig that the kernel reads.
#[derive(Debug)]
pub(crate) struct Detail {
    /// N.
    centers: usize,
    /// F.
    edges: usize,
    /// N × F.
    pose_features: Table<f32>,
    /// w, tiled, `[V/16][N][3][16]`. In the pivot's place is the sum of all weights, or b.
    rbf_weights: Vec<Line3>,
    /// The pivot of each vertex, tiled. Numbers past V are 0.
    pivots: Vec<[u32; TILE]>,
    /// Whether the first weight is b, and the pivot of every vertex is the rest pose.
    zero_at_rest: bool,
}

impl Detail {
    /// `None` where the wrinkles are functions of vector strains.
    pub(crate) fn new(rig: &Rig) -> Option<Self> {
        if rig.vector_wrinkles() {
            return None;
        }
        let (vertices, centers) = (rig.vertices(), rig.centers());
        let rbf_weights = rig.fine_scale().rbf_weights.as_slice();
        let (weights, pivots) = match rig.learned() {
            Some(_) => (rbf_weights.to_vec(), vec![0; vertices]),
            None => pivoted(rbf_weights, centers),
        };
        let rbf_weights = tiled3(&weights, centers);
        let mut tiled_pivots = vec![[0; TILE]; vertices.div_ceil(TILE)];
        pivots.iter().enumerate().for_each(|(v, &pivot)| tiled_pivots[v / TILE][v % TILE] = pivot);
        Some(Self {
            centers,
            edges: rig.handles().strain_edges.len(),
            pose_features: rig.fine_scale().pose_features.clone(),
            rbf_weights,
            pivots: tiled_pivots,
            zero_at_rest: rig.learned().is_some(),
        })
    }

    /// The squared differences of one frame's features, `[N/8][F][8]`. Numbers past N are 0.
    pub(crate) fn frame_table(&self, features: &[f32]) -> CellTable<FrameCells> {
        let mut cells = vec![[0.0; FRAME_COLUMNS]; self.centers.div_ceil(FRAME_COLUMNS) * self.edges];
        let [strain_edges, centers] = [self.edges, self.centers].map(|n| n as u32);
        let params = differences::Params { frames: 1, strain_edges, centers };
        differences::differences(params, features, self.pose_features.as_slice(), cells.as_flattened_mut());
        CellTable { rows: self.edges, cells }
    }

    /// The squared differences of frames × F features of at most [`GROUP`] frames, `[N/4][F][4][16]`. Numbers
    /// past N are 0.
    pub(crate) fn group_table(&self, features: &[f32]) -> CellTable<GroupCells> {
        let mut cells = vec![[Line::ZERO; GROUP_COLUMNS]; self.centers.div_ceil(GROUP_COLUMNS) * self.edges];
        for (lane, features) in features.chunks_exact(self.edges.max(1)).enumerate() {
            for (j, center) in self.pose_features.rows().enumerate() {
                for (e, (f, center)) in features.iter().zip(center).enumerate() {
                    let difference = f - center;
                    let at = j / GROUP_COLUMNS * self.edges + e;
                    cells[at][j % GROUP_COLUMNS].0[lane] = difference * difference;
                }
            }
        }
        CellTable { rows: self.edges, cells }
    }

    /// N.
    pub(crate) fn centers(&self) -> usize {
        self.centers
    }

    /// w of a tile.
    #[inline(always)]
    fn weights(&self, tile: usize) -> &[Line3] {
        &self.rbf_weights[tile * self.centers..(tile + 1) * self.centers]
    }

    /// d of a tile's vertices, in one frame. `influences` are α. `distances` is scratch for the distances
    /// from N centres.
    #[inline(always)]
    pub(crate) fn frame<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        influences: &TileWeights,
        table: &CellTable<FrameCells>,
        distances: &mut [Line],
    ) -> Line3 {
        let weights = self.weights(tile);
        let mut widened = Vec::new();
        let influences = influences.tile(tile, &mut widened);
        let mut d = [Line::ZERO; 3];
        for register in 0..TILE / S::F32_LANES {
            influences.frame(simd, register, table, None, distances);
            for r in distances.iter_mut() {
                Lanes::load(simd, &r.0, register).sqrt().store(&mut r.0, register);
            }
            let pivots = S::as_simd_u32s(&self.pivots[tile]).0[register];
            let is_pivot = |j: usize| simd.equal_u32s(pivots, simd.splat_u32s(j as u32));
            let mut at_pivot = Lanes::splat(simd, 0.0);
            for (j, r) in distances.iter().enumerate() {
                at_pivot.1 = simd.select_f32s(is_pivot(j), Lanes::load(simd, &r.0, register).1, at_pivot.1);
            }
            let of_pivot = if self.zero_at_rest { Lanes::splat(simd, 1.0) } else { at_pivot };
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for (j, (r, w)) in distances.iter().zip(weights).enumerate() {
                let away = Lanes::load(simd, &r.0, register) - at_pivot;
                let factor = Lanes(simd, simd.select_f32s(is_pivot(j), of_pivot.1, away.1));
                let w = load3(simd, w, register);
                for c in 0..3 {
                    sum[c] = w[c].mul_add(factor, sum[c]);
                }
            }
            store3(sum, &mut d, register);
        }
        d
    }

    /// Scratch for the distances of a few vertices from all centres in a group of frames.
    pub(crate) fn group_scratch(&self) -> [Vec<Line>; GROUP_VERTICES] {
        std::array::from_fn(|_| vec![Line::ZERO; self.centers])
    }

    /// d of the vertices from `first` on, which is a multiple of [`TILE`], in a group of frames.
    #[inline(always)]
    pub(crate) fn group<S: Simd>(
        &self,
        simd: S,
        first: usize,
        influences: &TileWeights,
        table: &CellTable<GroupCells>,
        distances: &mut [Vec<Line>; GROUP_VERTICES],
        out: &mut [Line3],
    ) {
        for (i, out) in out.chunks_mut(GROUP_VERTICES).enumerate() {
            let v = first + i * GROUP_VERTICES;
            let mut widened = Vec::new();
            let influences = influences.tile(v / TILE, &mut widened);
            for register in 0..GROUP / S::F32_LANES {
                influences.group(simd, v % TILE, register, table, None, distances);
                for r in distances.iter_mut().flatten() {
                    Lanes::load(simd, &r.0, register).sqrt().store(&mut r.0, register);
                }
                for (lane, (out, distances)) in out.iter_mut().zip(&*distances).enumerate() {
                    store3(self.group_sum(simd, v + lane, register, distances), out, register);
                }
            }
        }
    }

    /// d of vertex `v` from its distances, in some frames of a group.
    #[inline(always)]
    fn group_sum<S: Simd>(&self, simd: S, v: usize, register: usize, distances: &[Line]) -> [Lanes<S>; 3] {
        let (tile, lane) = (v / TILE, v % TILE);
        let weights = self.weights(tile);
        let pivot = self.pivots[tile][lane] as usize;
        let at_pivot = Lanes::load(simd, &distances[pivot].0, register);
        let of_pivot = if self.zero_at_rest { Lanes::splat(simd, 1.0) } else { at_pivot };
        let mut sum = [Lanes::splat(simd, 0.0); 3];
        for (j, (r, w)) in distances.iter().zip(weights).enumerate() {
            let away = Lanes::load(simd, &r.0, register) - at_pivot;
            let factor = if j == pivot { of_pivot } else { away };
            for c in 0..3 {
                sum[c] = Lanes::splat(simd, w[c].0[lane]).mul_add(factor, sum[c]);
            }
        }
        sum
    }
}
