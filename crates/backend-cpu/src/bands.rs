//! The fine detail that was learned from the examples. The squared distances of a frame's vector strains from
//! those of the centres make the linear band, and the distances make the wrinkles.
use crate::band_weights::BandWeights;
use crate::beyond::Excess;
use crate::lanes::{Lanes, load3, splat3, store3};
use crate::lines::{GROUP, Line, Line3};
use crate::tile_weights::{
    CellTable, FRAME_COLUMNS, FrameCells, GROUP_COLUMNS, GROUP_VERTICES, GroupCells, TileWeights,
};
use pulp::Simd;
use rhytid_core::{BasisStorage, Rig, Stage};
use rhytid_kernels::bands::{EDGES_SHARE, kinds};
use rhytid_kernels::tile::TILE;
use rhytid_kernels::{Number, vec3, vector_differences};

/// The data of a rig with bands that the kernels read.
#[derive(Debug)]
pub(crate) struct Bands {
    /// N, at least 2.
    centers: usize,
    /// H.
    handles: usize,
    strain_edges: Vec<[u32; 2]>,
    /// F + H.
    feature_lengths: Vec<f32>,
    /// P × (F + H).
    example_vectors: Vec<[f32; 3]>,
    /// F + H.
    feature_limits: Vec<f32>,
    /// ν. The indices are those of features.
    anchors: TileWeights,
    weights: BandWeights,
    /// Whether the wrinkles are functions of vector strains.
    wrinkles: bool,
}

/// The terms of the squared distances, in one frame or in a group of frames.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms<'a, C, T> {
    /// α.
    pub influences: &'a TileWeights,
    /// The squared differences of the vector strains.
    pub table: &'a CellTable<C>,
    /// What is taken back, where anything is.
    pub excess: Option<&'a Excess<'a, T>>,
}

impl Bands {
    /// `None` where the rig has no bands.
    pub(crate) fn new(rig: &Rig, storage: BasisStorage) -> Option<Self> {
        let learned = rig.bands()?;
        let wrinkles = rig.vector_wrinkles();
        let anchors = TileWeights::new(
            rig.vertices(),
            learned.anchors.map(|h| rig.handles().strain_edges.len() as u32 + h.0).as_slice(),
            learned.anchor_weights.as_slice(),
        );
        let narrow = storage.has_narrow_weights(wrinkles);
        Some(Self {
            centers: rig.centers(),
            handles: rig.handles().len(),
            strain_edges: rig.handles().edge_numbers().to_vec(),
            feature_lengths: rig.handles().feature_lengths().iter().map(|&length| length as f32).collect(),
            example_vectors: rig.example_vectors().into_vec(),
            feature_limits: rig.feature_limits(),
            anchors: if narrow { anchors.narrow() } else { anchors },
            weights: BandWeights::new(rig, storage),
            wrinkles,
        })
    }

    /// F + H.
    fn rows(&self) -> usize {
        self.strain_edges.len() + self.handles
    }

    /// The squared differences of one frame's vector strains, `[N/8][F + H][8]`. Numbers past N are 0. `u`
    /// has H displacements.
    pub(crate) fn frame_table(&self, u: &[[f32; 3]]) -> CellTable<FrameCells> {
        let rows = self.rows();
        let mut cells = vec![[0.0; FRAME_COLUMNS]; self.centers.div_ceil(FRAME_COLUMNS) * rows];
        let [handles, strain_edges, centers] =
            [self.handles, self.strain_edges.len(), self.centers].map(|n| n as u32);
        let params = vector_differences::Params { frames: 1, handles, strain_edges, centers };
        vector_differences::vector_differences(params, u, &self.buffers(), cells.as_flattened_mut());
        CellTable { rows, cells }
    }

    fn buffers(&self) -> vector_differences::Buffers<'_, f32> {
        vector_differences::Buffers {
            strain_edges: &self.strain_edges,
            feature_lengths: &self.feature_lengths,
            example_vectors: &self.example_vectors,
            feature_limits: &self.feature_limits,
        }
    }

    /// What is not followed of each feature of one frame, F + H; `None` where everything is.
    pub(crate) fn excess(&self, u: &[[f32; 3]]) -> Option<Vec<[f32; 3]>> {
        let buffers = self.buffers();
        let excess = (0..self.rows()).map(|e| vector_differences::vector_excess(&buffers, u, e));
        let excess: Vec<[f32; 3]> = excess.collect();
        excess.iter().any(|d| *d != [0.0; 3]).then_some(excess)
    }

    /// The table of frames × H displacements of at most [`GROUP`] frames, `[N/4][F + H][4][16]`. Numbers past
    /// N are 0.
    pub(crate) fn group_table(&self, u: &[[f32; 3]]) -> CellTable<GroupCells> {
        let rows = self.rows();
        let mut all = vec![[Line::ZERO; GROUP_COLUMNS]; self.centers.div_ceil(GROUP_COLUMNS) * rows];
        for (lane, u) in u.chunks_exact(self.handles).enumerate() {
            for (i, cells) in self.frame_table(u).cells.iter().enumerate() {
                for (j, difference) in cells.iter().enumerate() {
                    let center = i / rows * FRAME_COLUMNS + j;
                    if let Some(cells) = all.get_mut(center / GROUP_COLUMNS * rows + i % rows) {
                        cells[center % GROUP_COLUMNS].0[lane] = *difference;
                    }
                }
            }
        }
        CellTable { rows, cells: all }
    }

    /// Scratch for a few vertices.
    pub(crate) fn scratch(&self) -> Scratch {
        Scratch {
            squares: std::array::from_fn(|_| vec![Line::ZERO; self.centers]),
            weights: vec![[Line::ZERO; 3]; kinds(self.wrinkles) * self.centers],
            influences: Vec::new(),
            anchors: Vec::new(),
        }
    }

    /// Changes the basis' result for the vertices of a tile in one frame to `stage`. A tile may have fewer
    /// vertices than 16. The stage is the large scale or, where the wrinkles are functions of vector strains,
    /// the detail or the positions.
    #[inline(always)]
    pub(crate) fn frame<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        stage: Stage,
        Terms { influences, table, excess }: Terms<'_, FrameCells, f32>,
        scratch: &mut Scratch,
        out: &mut [[f32; 3]],
    ) {
        let Scratch { squares: [squares, _], weights, influences: of_edges, anchors } = scratch;
        let weights = self.weights.tile(simd, tile, weights);
        let (influences, anchors) = (influences.tile(tile, of_edges), self.anchors.tile(tile, anchors));
        let (mut offsets, mut details) = ([Line::ZERO; 3], [Line::ZERO; 3]);
        for register in 0..TILE / S::F32_LANES {
            influences.frame(simd, register, table, None, squares);
            anchors.frame(simd, register, table, Some(EDGES_SHARE as f32), squares);
            let load = |vector: &Line3| load3(simd, vector, register);
            let [mut offset, detail] = self.sums(simd, register, squares, weights, load);
            if let Some(excess) = excess {
                offset = vec3::sub(offset, excess.of_tile(simd, tile, register));
            }
            store3(offset, &mut offsets, register);
            store3(detail, &mut details, register);
        }
        for (lane, x) in out.iter_mut().enumerate() {
            let at = |lines: &Line3| lines.each_ref().map(|line| line.0[lane]);
            *x = finished(stage, *x, at(&offsets), at(&details));
        }
    }

    /// The same for the vertices from `first` on, which is a multiple of [`TILE`], in a group of frames.
    #[inline(always)]
    pub(crate) fn group<S: Simd>(
        &self,
        simd: S,
        first: usize,
        stage: Stage,
        Terms { influences, table, excess }: Terms<'_, GroupCells, Line>,
        scratch: &mut Scratch,
        out: &mut [Line3],
    ) {
        let Scratch { squares, weights, influences: of_edges, anchors: of_handles } = scratch;
        for (i, out) in out.chunks_mut(TILE).enumerate() {
            let tile = first / TILE + i;
            let weights = self.weights.tile(simd, tile, weights);
            let (influences, anchors) =
                (influences.tile(tile, of_edges), self.anchors.tile(tile, of_handles));
            for (i, out) in out.chunks_mut(GROUP_VERTICES).enumerate() {
                let first = i * GROUP_VERTICES;
                for register in 0..GROUP / S::F32_LANES {
                    influences.group(simd, first, register, table, None, squares);
                    anchors.group(simd, first, register, table, Some(EDGES_SHARE as f32), squares);
                    for (lane, (x, squares)) in out.iter_mut().zip(&*squares).enumerate() {
                        let lane = first + lane;
                        let excess =
                            excess.map(|excess| excess.of_vertex(simd, tile * TILE + lane, register));
                        let load = |vector: &Line3| splat3(simd, &vector.each_ref().map(|row| row.0[lane]));
                        let [mut offset, detail] = self.sums(simd, register, squares, weights, load);
                        if let Some(excess) = excess {
                            offset = vec3::sub(offset, excess);
                        }
                        store3(finished(stage, load3(simd, x, register), offset, detail), x, register);
                    }
                }
            }
        }
    }

    /// o and d from the squared distances and the vectors of a tile, of which `load` takes what it needs.
    #[inline(always)]
    fn sums<S: Simd, L: Fn(&Line3) -> [Lanes<S>; 3]>(
        &self,
        simd: S,
        register: usize,
        squares: &[Line],
        weights: &[Line3],
        load: L,
    ) -> [[Lanes<S>; 3]; 2] {
        match self.wrinkles {
            true => sums::<S, L, 2>(simd, register, squares, weights, load),
            false => sums::<S, L, 1>(simd, register, squares, weights, load),
        }
    }
}

/// The same for [`kinds`] vectors of each centre: a and b, then c / 2 and w of each example.
#[inline(always)]
fn sums<S: Simd, L: Fn(&Line3) -> [Lanes<S>; 3], const KINDS: usize>(
    simd: S,
    register: usize,
    squares: &[Line],
    weights: &[Line3],
    load: L,
) -> [[Lanes<S>; 3]; 2] {
    let zero = [Lanes::splat(simd, 0.0); 3];
    let (weights, _) = weights.as_chunks::<KINDS>();
    let ([at_rest, squares @ ..], [rest, examples @ ..]) = (squares, weights) else { return [zero; 2] };
    let at_rest = Lanes::load(simd, &at_rest.0, register);
    let root = at_rest.sqrt();
    let [mut x, mut y, mut z] = load(&rest[0]);
    let [mut dx, mut dy, mut dz] = if KINDS > 1 { load(&rest[KINDS - 1]) } else { zero };
    for (squared, weights) in squares.iter().zip(examples) {
        let squared = Lanes::load(simd, &squared.0, register);
        let (along, c) = (at_rest - squared, load(&weights[0]));
        (x, y, z) = (c[0].mul_add(along, x), c[1].mul_add(along, y), c[2].mul_add(along, z));
        if KINDS > 1 {
            let (farther, w) = (squared.sqrt() - root, load(&weights[KINDS - 1]));
            (dx, dy, dz) = (w[0].mul_add(farther, dx), w[1].mul_add(farther, dy), w[2].mul_add(farther, dz));
        }
    }
    [[x, y, z], [dx, dy, dz]]
}

/// The result of `stage`, from the basis' result and both bands.
#[inline(always)]
fn finished<T: Number>(stage: Stage, of_basis: [T; 3], offset: [T; 3], detail: [T; 3]) -> [T; 3] {
    let smooth = vec3::add(of_basis, offset);
    match stage {
        Stage::Detail => detail,
        Stage::Positions => vec3::add(smooth, detail),
        _ => smooth,
    }
}

/// A thread's scratch.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// The squared distances. In one frame, only the first is used, for a tile's vertices. In a group there
    /// is one for each of [`GROUP_VERTICES`] vertices.
    squares: [Vec<Line>; GROUP_VERTICES],
    /// The weights of a tile, of its strain edges and of its anchors, where they are kept in 16 bits.
    weights: Vec<Line3>,
    influences: Vec<Line>,
    anchors: Vec<Line>,
}
