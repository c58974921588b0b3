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
use rhytid_kernels::bands::{bits_of_weight, weight_of_bits};
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
    rows: Rows,
}

/// A row for each index. A weight is zero where a vertex has none.
#[derive(Debug)]
enum Rows {
    F32(Vec<Line>),
    /// [`bits_of_weight`].
    Bits(Vec<[u16; TILE]>),
}

impl Default for Rows {
    fn default() -> Self {
        Self::F32(Vec::new())
    }
}

impl TileWeights {
    /// From `per_vertex` indices and weights for each of V vertices.
    pub(crate) fn new(vertices: usize, indices: &[u32], weights: &[f32]) -> Self {
        let per_vertex = indices.len().checked_div(vertices).unwrap_or(0);
        let mut all = Self { first: vec![0], ..Self::default() };
        let mut rows = Vec::new();
        for first in (0..vertices).step_by(TILE) {
            let here = first * per_vertex..(first + TILE).min(vertices) * per_vertex;
            let (indices, weights) = tile_influences(per_vertex, &indices[here.clone()], &weights[here]);
            all.indices.extend(indices);
            rows.extend(weights.into_iter().map(Line));
            all.first.push(all.indices.len());
        }
        all.rows = Rows::F32(rows);
        all
    }

    /// The same with weights of 16 bits.
    pub(crate) fn narrow(mut self) -> Self {
        if let Rows::F32(rows) = self.rows {
            self.rows = Rows::Bits(rows.iter().map(|row| row.0.map(bits_of_weight)).collect());
        }
        self
    }

    /// The rows of a tile. `scratch` is used where weights have 16 bits.
    #[inline(always)]
    pub(crate) fn tile<'a>(&'a self, tile: usize, scratch: &'a mut Vec<Line>) -> TileRows<'a> {
        let range = self.first[tile]..self.first[tile + 1];
        let indices = &self.indices[range.clone()];
        let weights = match &self.rows {
            Rows::F32(rows) => &rows[range],
            Rows::Bits(rows) => {
                if scratch.len() < range.len() {
                    scratch.resize(range.len(), Line::ZERO);
                }
                let widened = &mut scratch[..range.len()];
                // One long loop is compiled to vectors.
                let (out, bits): (&mut [f32], &[u16]) =
                    (bytemuck::cast_slice_mut(widened), rows[range].as_flattened());
                out.iter_mut().zip(bits).for_each(|(out, &bits)| *out = weight_of_bits(bits));
                widened
            }
        };
        TileRows { indices, weights }
    }
}

/// The rows of a tile: indices, and a row of weights for each.
#[derive(Clone, Copy)]
pub(crate) struct TileRows<'a> {
    pub indices: &'a [u32],
    pub weights: &'a [Line],
}

impl TileRows<'_> {
    /// The sums of a tile in one frame, with a register of a line for each column. They begin with `start`
    /// times `sums`, or with 0.
    #[inline(always)]
    pub(crate) fn frame<S: Simd>(
        &self,
        simd: S,
        register: usize,
        table: &CellTable<FrameCells>,
        start: Option<f32>,
        sums: &mut [Line],
    ) {
        for (sums, table) in sums.chunks_mut(FRAME_COLUMNS).zip(table.columns()) {
            match sums.len() {
                1 => self.frame_columns::<S, 1>(simd, register, table, start, sums),
                2 => self.frame_columns::<S, 2>(simd, register, table, start, sums),
                3 => self.frame_columns::<S, 3>(simd, register, table, start, sums),
                4 => self.frame_columns::<S, 4>(simd, register, table, start, sums),
                5 => self.frame_columns::<S, 5>(simd, register, table, start, sums),
                6 => self.frame_columns::<S, 6>(simd, register, table, start, sums),
                7 => self.frame_columns::<S, 7>(simd, register, table, start, sums),
                _ => self.frame_columns::<S, FRAME_COLUMNS>(simd, register, table, start, sums),
            }
        }
    }

    /// The same for the first `N` columns of the table.
    #[inline(always)]
    fn frame_columns<S: Simd, const N: usize>(
        &self,
        simd: S,
        register: usize,
        table: &[FrameCells],
        start: Option<f32>,
        sums: &mut [Line],
    ) {
        let mut all = [Lanes::splat(simd, 0.0); N];
        if let Some(start) = start {
            for j in 0..N {
                all[j] = Lanes::splat(simd, start) * Lanes::load(simd, &sums[j].0, register);
            }
        }
        for (i, weight) in self.indices.iter().zip(self.weights) {
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

    /// The sums of [`GROUP_VERTICES`] vertices from `lane` of the tile on, in some frames of a group.
    #[inline(always)]
    pub(crate) fn group<S: Simd>(
        &self,
        simd: S,
        lane: usize,
        register: usize,
        table: &CellTable<GroupCells>,
        start: Option<f32>,
        sums: &mut [Vec<Line>; GROUP_VERTICES],
    ) {
        for (chunk, table) in table.columns().enumerate() {
            let sums = sums.each_mut().map(|sums| &mut sums[chunk * GROUP_COLUMNS..]);
            match sums[0].len() {
                1 => self.group_columns::<S, 1>(simd, lane, register, table, start, sums),
                2 => self.group_columns::<S, 2>(simd, lane, register, table, start, sums),
                3 => self.group_columns::<S, 3>(simd, lane, register, table, start, sums),
                _ => self.group_columns::<S, GROUP_COLUMNS>(simd, lane, register, table, start, sums),
            }
        }
    }

    /// The same for the first `N` columns of the table.
    #[inline(always)]
    fn group_columns<S: Simd, const N: usize>(
        &self,
        simd: S,
        lane: usize,
        register: usize,
        table: &[GroupCells],
        start: Option<f32>,
        sums: [&mut [Line]; GROUP_VERTICES],
    ) {
        let mut all = [[Lanes::splat(simd, 0.0); N]; GROUP_VERTICES];
        if let Some(start) = start {
            for i in 0..GROUP_VERTICES {
                for j in 0..N {
                    let sum = Lanes::load(simd, &sums[i][j].0, register);
                    all[i][j] = Lanes::splat(simd, start) * sum;
                }
            }
        }
        for (i, weights) in self.indices.iter().zip(self.weights) {
            let cells = &table[*i as usize];
            let (weights, _) = weights.0.as_chunks::<GROUP_VERTICES>();
            let weights = &weights[lane / GROUP_VERTICES];
            for j in 0..N {
                let cells = Lanes::load(simd, &cells[j].0, register);
                for i in 0..GROUP_VERTICES {
                    all[i][j] = Lanes::splat(simd, weights[i]).mul_add(cells, all[i][j]);
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
