//! The part of the basis that is taken back in a frame beyond the rig's reach: `Σ_e g_ve (D_e −
//! limited(D_e))`.
use crate::bands::Bands;
use crate::lanes::Lanes;
use crate::lines::{Line, Line3};
use crate::tile_weights::TileWeights;
use pulp::Simd;
use rhytid_core::Rig;
use rhytid_kernels::Number;
use rhytid_kernels::tile::TILE;

/// g, as the tiles of [`TileWeights`] have it.
#[derive(Debug)]
pub(crate) struct Beyond {
    gains: TileWeights,
}

/// g, and how far each feature is beyond the reach in a frame or a group of frames.
#[derive(Debug)]
pub(crate) struct Excess<'a, T> {
    gains: &'a TileWeights,
    /// F + H; `None` where a feature is within. Few are beyond in most frames, and the gains of the others
    /// are not read.
    of_features: Vec<Option<[T; 3]>>,
}

impl Beyond {
    /// `None` where nothing in the basis is limited.
    pub(crate) fn new(rig: &Rig) -> Option<Self> {
        let learned = rig.learned().filter(|_| rig.limits_basis())?;
        let features = |v: usize| rig.influences_of(v).map(|(feature, _)| feature as u32);
        let features: Vec<u32> = (0..rig.vertices()).flat_map(features).collect();
        Some(Self { gains: TileWeights::new(rig.vertices(), &features, learned.feature_gains.as_slice()) })
    }

    /// What is beyond in one frame, given the displacements of the handles. `None` where nothing is.
    pub(crate) fn frame(&self, bands: &Bands, u: &[[f32; 3]]) -> Option<Excess<'_, f32>> {
        let of_features = bands.excess(u)?.into_iter().map(|d| (d != [0.0; 3]).then_some(d)).collect();
        Some(Excess { gains: &self.gains, of_features })
    }

    /// The same for frames × H displacements of a group of frames. `handles` is H.
    pub(crate) fn group(&self, bands: &Bands, u: &[[f32; 3]], handles: usize) -> Option<Excess<'_, Line>> {
        let mut of_features: Vec<Option<Line3>> = Vec::new();
        for (lane, u) in u.chunks_exact(handles).enumerate() {
            let Some(excess) = bands.excess(u) else { continue };
            of_features.resize(excess.len(), None);
            for (lines, excess) in of_features.iter_mut().zip(excess).filter(|(_, d)| *d != [0.0; 3]) {
                let lines = lines.get_or_insert([Line::ZERO; 3]);
                (0..3).for_each(|c| lines[c].0[lane] = excess[c]);
            }
        }
        (!of_features.is_empty()).then_some(Excess { gains: &self.gains, of_features })
    }
}

impl Excess<'_, f32> {
    /// A register of what is taken back of a tile's vertices.
    #[inline(always)]
    pub(crate) fn of_tile<S: Simd>(&self, simd: S, tile: usize, register: usize) -> [Lanes<S>; 3] {
        let mut sums = [Lanes::splat(simd, 0.0); 3];
        let mut widened = Vec::new();
        let rows = self.gains.tile(tile, &mut widened);
        for (feature, gains) in rows.indices.iter().zip(rows.weights) {
            if let Some(excess) = self.of_features[*feature as usize] {
                let gains = Lanes::load(simd, &gains.0, register);
                (0..3).for_each(|c| sums[c] = gains.mul_add(Lanes::splat(simd, excess[c]), sums[c]));
            }
        }
        sums
    }
}

impl Excess<'_, Line> {
    /// A register of what is taken back of the vertex `v`.
    #[inline(always)]
    pub(crate) fn of_vertex<S: Simd>(&self, simd: S, v: usize, register: usize) -> [Lanes<S>; 3] {
        let mut sums = [Lanes::splat(simd, 0.0); 3];
        let mut widened = Vec::new();
        let rows = self.gains.tile(v / TILE, &mut widened);
        for (feature, gains) in rows.indices.iter().zip(rows.weights) {
            if let Some(excess) = &self.of_features[*feature as usize] {
                let gain = Lanes::splat(simd, gains.0[v % TILE]);
                (0..3).for_each(|c| {
                    sums[c] = gain.mul_add(Lanes::load(simd, &excess[c].0, register), sums[c]);
                });
            }
        }
        sums
    }
}
