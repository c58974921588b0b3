//! The product of a sparse matrix and a small table. The matrix has a row for each vertex, such as α of the
//! strain edges. The table belongs to a frame or to a group of frames.
//!
//! Vertices that lie side by side have weights for nearly the same indices. So the vertices of a tile share
//! one list of indices: all that any of them has. Where a vertex has no weight for an index, the weight is
//! zero, which changes no sum. So nothing is gathered.
use crate::lanes::Lanes;
use crate::lines::{Line, Line3};
use pulp::Simd;
use rhytid_kernels::Number;
use rhytid_kernels::differences::CENTERS_AT_ONCE;
use rhytid_kernels::tile::{TILE, tile_influences};
use std::slice::ChunksExact;

/// Columns of the table that are summed together in one frame.
pub(crate) const FRAME_COLUMNS: usize = CENTERS_AT_ONCE;

/// Columns and vertices that are summed together in a group of frames. Each loaded number is used in several
/// sums.
pub(crate) const GROUP_COLUMNS: usize = 4;
pub(crate) const GROUP_VERTICES: usize = 2;

/// The cells of an index in some of the columns, in one frame.
pub(crate) type FrameCells = [f32; FRAME_COLUMNS];

/// The same in a group of frames.
pub(crate) type GroupCells = [Line; GROUP_COLUMNS];

/// The table: `[columns/8][rows][8]` of a frame, `[columns/4][rows][4][16]` of a group of frames.
#[derive(Debug)]
pub(crate) struct CellTable<C> {
    /// The number of rows. The matrix's indices are rows of the table.
    pub rows: usize,
    /// The first few columns of every row, then the next few.
    pub cells: Vec<C>,
}

impl<C> CellTable<C> {
    /// All rows of the first few columns, then of the next few.
    #[inline(always)]
    fn columns(&self) -> ChunksExact<'_, C> {
        self.cells.chunks_exact(self.rows.max(1))
    }
}

/// The matrix.
#[derive(Debug, Default)]
pub(crate) struct TileWeights {
    /// The first index of each tile, and the end of the last one's.
    first: Vec<usize>,
    /// Ascending in each tile.
    indices: Vec<u32>,
    /// A row for each index. Zero where a vertex has no weight.
    weights: Vec<Line>,
}

impl TileWeights {
    /// From `per_vertex` indices and weights for each of V vertices.
    pub(crate) fn new(vertices: usize, indices: &[u32], weights: &[f32]) -> Self {
        let per_vertex = indices.len().checked_div(vertices).unwrap_or(0);
        let mut all = Self { first: vec![0], ..Self::default() };
        for first in (0..vertices).step_by(TILE) {
            let here = first * per_vertex..(first + TILE).min(vertices) * per_vertex;
            let (indices, weights) = tile_influences(per_vertex, &indices[here.clone()], &weights[here]);
            all.indices.extend(indices);
            all.weights.extend(weights.into_iter().map(Line));
            all.first.push(all.indices.len());
        }
        all
    }

    /// A tile's indices, and a row of weights for each.
    #[inline(always)]
    pub(crate) fn at(&self, tile: usize) -> (&[u32], &[Line]) {
        let range = self.first[tile]..self.first[tile + 1];
        (&self.indices[range.clone()], &self.weights[range])
    }

    /// The sums of a tile in one frame, with a register of a line for each column. They begin with `start`
    /// times `sums`, or with 0.
    #[inline(always)]
    pub(crate) fn frame<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        register: usize,
        table: &CellTable<FrameCells>,
        start: Option<f32>,
        sums: &mut [Line],
    ) {
        for (sums, table) in sums.chunks_mut(FRAME_COLUMNS).zip(table.columns()) {
            match sums.len() {
                1 => self.frame_columns::<S, 1>(simd, tile, register, table, start, sums),
                2 => self.frame_columns::<S, 2>(simd, tile, register, table, start, sums),
                3 => self.frame_columns::<S, 3>(simd, tile, register, table, start, sums),
                4 => self.frame_columns::<S, 4>(simd, tile, register, table, start, sums),
                5 => self.frame_columns::<S, 5>(simd, tile, register, table, start, sums),
                6 => self.frame_columns::<S, 6>(simd, tile, register, table, start, sums),
                7 => self.frame_columns::<S, 7>(simd, tile, register, table, start, sums),
                _ => self.frame_columns::<S, FRAME_COLUMNS>(simd, tile, register, table, start, sums),
            }
        }
    }

    /// The same for the first `N` columns of the table.
    #[inline(always)]
    fn frame_columns<S: Simd, const N: usize>(
        &self,
        simd: S,
        tile: usize,
        register: usize,
        table: &[FrameCells],
        start: Option<f32>,
        sums: &mut [Line],
    ) {
        let (indices, weights) = self.at(tile);
        let mut all = [Lanes::splat(simd, 0.0); N];
        if let Some(start) = start {
            for j in 0..N {
                all[j] = Lanes::splat(simd, start) * Lanes::load(simd, &sums[j].0, register);
            }
        }
        for (i, weight) in indices.iter().zip(weights) {
            let cells = &table[*i as usize];
            let weight = Lanes::load(simd, &weight.0, register);
            for j in 0..N {
                all[j] = weight.mul_add(Lanes::splat(simd, cells[j]), all[j]);
            }
        }
        for (out, sum) in sums.iter_mut().zip(all) {
            sum.store(&mut out.0, register);
        }
    }

    /// The sums of [`GROUP_VERTICES`] vertices from `v` on, in some frames of a group.
    #[inline(always)]
    pub(crate) fn group<S: Simd>(
        &self,
        simd: S,
        v: usize,
        register: usize,
        table: &CellTable<GroupCells>,
        start: Option<f32>,
        sums: &mut [Vec<Line>; GROUP_VERTICES],
    ) {
        for (chunk, table) in table.columns().enumerate() {
            let sums = sums.each_mut().map(|sums| &mut sums[chunk * GROUP_COLUMNS..]);
            match sums[0].len() {
                1 => self.group_columns::<S, 1>(simd, v, register, table, start, sums),
                2 => self.group_columns::<S, 2>(simd, v, register, table, start, sums),
                3 => self.group_columns::<S, 3>(simd, v, register, table, start, sums),
                _ => self.group_columns::<S, GROUP_COLUMNS>(simd, v, register, table, start, sums),
            }
        }
    }

    /// The same for the first `N` columns of the table.
    #[inline(always)]
    fn group_columns<S: Simd, const N: usize>(
        &self,
        simd: S,
        v: usize,
        register: usize,
        table: &[GroupCells],
        start: Option<f32>,
        sums: [&mut [Line]; GROUP_VERTICES],
    ) {
        let (indices, weights) = self.at(v / TILE);
        let mut all = [[Lanes::splat(simd, 0.0); N]; GROUP_VERTICES];
        if let Some(start) = start {
            for lane in 0..GROUP_VERTICES {
                for j in 0..N {
                    let sum = Lanes::load(simd, &sums[lane][j].0, register);
                    all[lane][j] = Lanes::splat(simd, start) * sum;
                }
            }
        }
        for (i, weights) in indices.iter().zip(weights) {
            let cells = &table[*i as usize];
            let (weights, _) = weights.0.as_chunks::<GROUP_VERTICES>();
            let weights = &weights[v % TILE / GROUP_VERTICES];
            for j in 0..N {
                let cells = Lanes::load(simd, &cells[j].0, register);
                for lane in 0..GROUP_VERTICES {
                    all[lane][j] = Lanes::splat(simd, weights[lane]).mul_add(cells, all[lane][j]);
                }
            }
        }
        for (out, all) in sums.into_iter().zip(all) {
            for (out, sum) in out.iter_mut().zip(all) {
                sum.store(&mut out.0, register);
            }
        }
    }
}

/// `n` vectors for each vertex as `[V/16][n][3][16]`. Numbers past V are 0.
pub(crate) fn tiled3(vectors: &[[f32; 3]], n: usize) -> Vec<Line3> {
    let mut lines = vec![[Line::ZERO; 3]; (vectors.len() / n).div_ceil(TILE) * n];
    for (i, vector) in vectors.iter().enumerate() {
        let (v, j) = (i / n, i % n);
        for c in 0..3 {
            lines[v / TILE * n + j][c].0[v % TILE] = vector[c];
        }
    }
    lines
}
