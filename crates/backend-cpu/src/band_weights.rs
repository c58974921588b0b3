//! The weights of the bands, laid out for the processor.
use crate::lanes::Lanes;
use crate::lines::{Line, Line3};
use pulp::Simd;
use rhytid_core::{BasisStorage, Rig};
use rhytid_kernels::bands::kinds;
use rhytid_kernels::tile::TILE;

/// The vectors of each tile: a and b, then c / 2 and w of each example.
#[derive(Debug)]
pub(crate) struct BandWeights {
    tiles: Vec<Tile>,
    singles: Vec<Line3>,
    /// A unit for each vector of integers.
    units: Vec<f32>,
    integers: Vec<[[i16; TILE]; 3]>,
    /// Vectors of a tile for the rest pose.
    kinds: usize,
    /// Vectors of a tile.
    vectors: usize,
}

/// Where the vectors of a tile are.
#[derive(Debug, Clone, Copy)]
struct Tile {
    first_single: usize,
    /// Where the examples have integers.
    first_integer: Option<usize>,
}

impl BandWeights {
    /// The weights of a rig that has bands.
    pub(crate) fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let weights = rhytid_core::BandWeights::new(rig, storage);
        let kinds = kinds(rig.vector_wrinkles());
        let mut all = Self {
            tiles: Vec::new(),
            singles: Vec::new(),
            units: Vec::new(),
            integers: Vec::new(),
            kinds,
            vectors: kinds * rig.centers(),
        };
        for tile in 0..rig.vertices().div_ceil(TILE) {
            let (tile, first_single) = (weights.tile(tile), all.singles.len());
            let lines = tile.singles().iter().map(|row| Line(row.map(f32::from_bits)));
            all.singles.extend(lines.collect::<Vec<_>>().as_chunks::<3>().0);
            let first_integer = tile.integers().map(|(units, integers)| {
                let first = all.integers.len();
                all.units.extend(units);
                all.integers.extend(integers.as_chunks::<3>().0);
                first
            });
            all.tiles.push(Tile { first_single, first_integer });
        }
        all
    }

    /// The vectors of a tile. Integers are widened into `scratch`, which has a place for each vector.
    #[inline(always)]
    pub(crate) fn tile<'a, S: Simd>(&'a self, simd: S, tile: usize, scratch: &'a mut [Line3]) -> &'a [Line3] {
        let Tile { first_single, first_integer } = self.tiles[tile];
        let singles = &self.singles[first_single..];
        let Some(first) = first_integer else { return &singles[..self.vectors] };
        let (rest, examples) = scratch.split_at_mut(self.kinds);
        rest.copy_from_slice(&singles[..self.kinds]);
        // One long loop is compiled to vectors.
        let integers = self.integers[first..first + examples.len()].as_flattened().as_flattened();
        let numbers: &mut [f32] = bytemuck::cast_slice_mut(examples.as_flattened_mut());
        numbers.iter_mut().zip(integers).for_each(|(out, &x)| *out = f32::from(x));
        for (vector, unit) in examples.iter_mut().zip(&self.units[first..]) {
            let unit = Lanes::splat(simd, *unit);
            for row in vector {
                for register in 0..TILE / S::F32_LANES {
                    (unit * Lanes::load(simd, &row.0, register)).store(&mut row.0, register);
                }
            }
        }
        scratch
    }
}
