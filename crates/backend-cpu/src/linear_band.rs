//! The linear band: how much of each example's vector strains there is in a frame's, times what that example does.
use crate::lanes::{Lanes, load3, splat3, store3};
use crate::lines::{GROUP, Line, Line3};
use crate::tile_weights::{
    FRAME_COLUMNS, FrameCells, GROUP_COLUMNS, GROUP_VERTICES, GroupCells, TileWeights, tiled3,
};
use half::f16;
use half::slice::HalfFloatSliceExt;
use pulp::Simd;
use rhytid_core::{BasisStorage, Rig};
use rhytid_kernels::linear_band::EDGES_SHARE;
use rhytid_kernels::table::TILE;
use rhytid_kernels::{Number, products, vec3};

/// What the kernels read of a rig that has a linear band beyond its basis.
#[derive(Debug)]
pub(crate) struct LinearBand {
    /// P, at least 1.
    examples: usize,
    /// H.
    handles: usize,
    strain_edges: Vec<[u32; 2]>,
    /// P × (F + H).
    example_vectors: Vec<[f32; 3]>,
    /// 2 × (F + H).
    feature_bounds: Vec<[f32; 3]>,
    /// ν; the indices are those of features.
    anchors: TileWeights,
    /// c, tiled, `[V/16][P][3][16]`.
    weights: Weights,
}

#[derive(Debug)]
enum Weights {
    F32(Vec<Line3>),
    F16(Vec<[[f16; TILE]; 3]>),
}

impl LinearBand {
    /// `None` where all there is is the basis.
    pub(crate) fn new(rig: &Rig, storage: BasisStorage) -> Option<Self> {
        let learned = rig.learned.as_ref().filter(|learned| !learned.example_weights.is_empty())?;
        let weights = tiled3(&learned.example_weights, rig.example_names.len());
        Some(Self {
            examples: rig.example_names.len(),
            handles: rig.handles.len(),
            strain_edges: rig.strain_edges.clone(),
            example_vectors: rig.example_vectors(),
            feature_bounds: rig.feature_bounds(),
            anchors: TileWeights::new(
                rig.vertices(),
                &learned.anchors.iter().map(|h| rig.strain_edges.len() as u32 + h).collect::<Vec<_>>(),
                &learned.anchor_weights,
            ),
            weights: match storage {
                BasisStorage::F32 => Weights::F32(weights),
                BasisStorage::F16 => Weights::F16(
                    weights.iter().map(|rows| rows.each_ref().map(|row| row.0.map(f16::from_f32))).collect(),
                ),
            },
        })
    }

    /// F + H.
    fn rows(&self) -> usize {
        self.strain_edges.len() + self.handles
    }

    /// T of one frame, `[P/8][F + H][8]`; past P, 0. `u` has H displacements.
    pub(crate) fn frame_table(&self, u: &[[f32; 3]]) -> Vec<FrameCells> {
        let mut table = vec![[0.0; FRAME_COLUMNS]; self.examples.div_ceil(FRAME_COLUMNS) * self.rows()];
        let [handles, strain_edges, examples] =
            [self.handles, self.strain_edges.len(), self.examples].map(|n| n as u32);
        let params = products::Params { frames: 1, handles, strain_edges, examples };
        let out = table.as_flattened_mut();
        let (vectors, bounds) = (&self.example_vectors, &self.feature_bounds);
        products::products(params, u, &self.strain_edges, vectors, bounds, out);
        table
    }

    /// T of frames × H displacements of at most [`GROUP`] frames, `[P/4][F + H][4][16]`; past P, 0.
    pub(crate) fn group_table(&self, u: &[[f32; 3]]) -> Vec<GroupCells> {
        let rows = self.rows();
        let mut table = vec![[Line::ZERO; GROUP_COLUMNS]; self.examples.div_ceil(GROUP_COLUMNS) * rows];
        for (lane, u) in u.chunks_exact(self.handles).enumerate() {
            for (i, cells) in self.frame_table(u).iter().enumerate() {
                for (j, product) in cells.iter().enumerate() {
                    let p = i / rows * FRAME_COLUMNS + j;
                    if let Some(cells) = table.get_mut(p / GROUP_COLUMNS * rows + i % rows) {
                        cells[p % GROUP_COLUMNS].0[lane] = *product;
                    }
                }
            }
        }
        table
    }

    /// Scratch for κ of a few vertices.
    pub(crate) fn scratch(&self) -> Scratch {
        Scratch {
            kappa: std::array::from_fn(|_| vec![Line::ZERO; self.examples]),
            weights: vec![[Line::ZERO; 3]; self.examples],
        }
    }

    /// c of a tile; widened into `scratch` where it is fp16.
    #[inline(always)]
    fn weights<'a>(&'a self, tile: usize, scratch: &'a mut [Line3]) -> &'a [Line3] {
        let range = tile * self.examples..(tile + 1) * self.examples;
        match &self.weights {
            Weights::F32(weights) => &weights[range],
            Weights::F16(weights) => {
                let halves = weights[range].as_flattened().as_flattened();
                halves.convert_to_f32_slice(bytemuck::cast_slice_mut(scratch));
                scratch
            }
        }
    }

    /// Adds the linear band of a tile's vertices to `positions`, those of them that there are, in one frame. `influences` are α.
    #[inline(always)]
    pub(crate) fn add_to_frame<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        (influences, table): (&TileWeights, &[FrameCells]),
        scratch: &mut Scratch,
        positions: &mut [[f32; 3]],
    ) {
        let Scratch { kappa: [kappa, _], weights } = scratch;
        let weights = self.weights(tile, weights);
        let mut offsets = [Line::ZERO; 3];
        for register in 0..TILE / S::F32_LANES {
            let (at, table) = ((tile, register), (table, self.rows()));
            influences.frame(simd, at, table, None, kappa);
            self.anchors.frame(simd, at, table, Some(EDGES_SHARE as f32), kappa);
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for (kappa, c) in kappa.iter().zip(weights) {
                let kappa = Lanes::load(simd, &kappa.0, register);
                let c = load3(simd, c, register);
                for axis in 0..3 {
                    sum[axis] = c[axis].mul_add(kappa, sum[axis]);
                }
            }
            store3(sum, &mut offsets, register);
        }
        for (lane, x) in positions.iter_mut().enumerate() {
            for axis in 0..3 {
                x[axis] += offsets[axis].0[lane];
            }
        }
    }

    /// The same for the vertices from `first` on, a multiple of [`TILE`], in a group of frames.
    #[inline(always)]
    pub(crate) fn add_to_group<S: Simd>(
        &self,
        simd: S,
        first: usize,
        (influences, table): (&TileWeights, &[GroupCells]),
        scratch: &mut Scratch,
        positions: &mut [Line3],
    ) {
        let Scratch { kappa, weights } = scratch;
        for (tile, positions) in positions.chunks_mut(TILE).enumerate() {
            let weights = self.weights(first / TILE + tile, weights);
            for (i, positions) in positions.chunks_mut(GROUP_VERTICES).enumerate() {
                let v = first + tile * TILE + i * GROUP_VERTICES;
                for register in 0..GROUP / S::F32_LANES {
                    let (at, table) = ((v, register), (table, self.rows()));
                    influences.group(simd, at, table, None, kappa);
                    self.anchors.group(simd, at, table, Some(EDGES_SHARE as f32), kappa);
                    for (lane, (x, kappa)) in positions.iter_mut().zip(&*kappa).enumerate() {
                        let mut sum = [Lanes::splat(simd, 0.0); 3];
                        for (kappa, c) in kappa.iter().zip(weights) {
                            let kappa = Lanes::load(simd, &kappa.0, register);
                            let c = splat3(simd, &c.each_ref().map(|row| row.0[v % TILE + lane]));
                            for axis in 0..3 {
                                sum[axis] = c[axis].mul_add(kappa, sum[axis]);
                            }
                        }
                        let moved = vec3::add(load3(simd, x, register), sum);
                        store3(moved, x, register);
                    }
                }
            }
        }
    }
}

/// What a thread computes on the way.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// Of a tile's vertices in one frame, the first; of [`GROUP_VERTICES`] vertices in a group.
    kappa: [Vec<Line>; GROUP_VERTICES],
    /// c of a tile.
    weights: Vec<Line3>,
}
