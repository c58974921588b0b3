//! The weights of the bands as devices keep them.
use crate::rounded::Rounded;
use crate::{BasisStorage, Rig, Table};
use rayon::prelude::*;
use rhytid_kernels::bands::{EDGES_SHARE, kinds};
use rhytid_kernels::tile::TILE;
use rhytid_kernels::{Real, vec3};
use std::ops::Range;

/// The largest integer of 16 bits.
const LARGEST_INTEGER: f32 = 32_767.0;

/// The array `band_weights` of the kernel `bands`, without its first words: the vectors of each tile, in rows
/// of 16 words.
///
/// The vectors of the examples are integers where that loses nothing, as [`Rig::as_stored`] rounds them.
/// Otherwise they are fp32.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BandWeights {
    /// Vectors of a vertex for each centre.
    kinds: usize,
    /// N.
    centers: usize,
    /// The first row of each tile, and the end of the last one's.
    first_rows: Vec<usize>,
    /// Whether a tile has integers.
    narrow: Vec<bool>,
    rows: Vec<[u32; TILE]>,
}

/// The vectors of a tile.
#[derive(Debug, Clone, Copy)]
pub struct TileVectors<'a> {
    kinds: usize,
    centers: usize,
    narrow: bool,
    rows: &'a [[u32; TILE]],
}

impl BandWeights {
    /// The weights of a rig that is stored in this way. A rig without bands has none.
    pub fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let rounded = Rounded::of(rig, storage);
        let vectors = match &rounded {
            Some(rounded) => rounded.band_weights(rig),
            None => rig.band_weights(),
        };
        let (kinds, centers) = (kinds(rig.vector_wrinkles()), rig.centers());
        let tiles = if vectors.is_empty() { 0 } else { rig.vertices().div_ceil(TILE) };
        let of_tile = |tile: usize| {
            let vertices = tile * TILE..((tile + 1) * TILE).min(rig.vertices());
            let numbers = |j: usize, axis: usize| -> [f32; TILE] {
                std::array::from_fn(|lane| match vertices.clone().nth(lane) {
                    Some(v) => vectors.row(v)[j][axis],
                    None => 0.0,
                })
            };
            let all: Vec<[[f32; TILE]; 3]> =
                (0..kinds * centers).map(|j| std::array::from_fn(|axis| numbers(j, axis))).collect();
            rows_of(&all, kinds)
        };
        let all: Vec<(bool, Vec<[u32; TILE]>)> = (0..tiles).into_par_iter().map(of_tile).collect();
        let mut weights = Self { kinds, centers, first_rows: vec![0], narrow: Vec::new(), rows: Vec::new() };
        for (narrow, rows) in all {
            weights.narrow.push(narrow);
            weights.rows.extend(rows);
            weights.first_rows.push(weights.rows.len());
        }
        weights
    }

    /// The vectors of a tile.
    pub fn tile(&self, tile: usize) -> TileVectors<'_> {
        let rows = &self.rows[self.first_rows[tile]..self.first_rows[tile + 1]];
        TileVectors { kinds: self.kinds, centers: self.centers, narrow: self.narrow[tile], rows }
    }

    /// The part of all tiles, 0 to 1, whose examples have integers.
    pub fn narrow_part(&self) -> f64 {
        let narrow = self.narrow.iter().filter(|narrow| **narrow).count();
        narrow as f64 / self.narrow.len().max(1) as f64
    }

    /// The bytes of all tiles.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.rows[..])
    }

    /// The bytes of the kernel's array for some tiles.
    pub(crate) fn bytes_of(&self, tiles: &Range<usize>) -> usize {
        if self.narrow.is_empty() {
            return 0;
        }
        let rows = self.first_rows[tiles.end] - self.first_rows[tiles.start];
        (tiles.len().div_ceil(TILE) + rows) * size_of::<[u32; TILE]>()
    }

    /// The kernel's array for some tiles: a word for each, and then the rows.
    pub(crate) fn words_of(&self, tiles: &Range<usize>) -> Vec<u32> {
        if self.narrow.is_empty() {
            return Vec::new();
        }
        let before = self.first_rows[tiles.start];
        let first = tiles.len().div_ceil(TILE);
        let word = |tile: usize| {
            let row = first + self.first_rows[tile] - before;
            (row * TILE) as u32 | u32::from(self.narrow[tile])
        };
        let mut words: Vec<u32> = tiles.clone().map(word).collect();
        words.resize(first * TILE, 0);
        words.extend(self.rows[before..self.first_rows[tiles.end]].as_flattened());
        words
    }
}

impl<'a> TileVectors<'a> {
    /// The rows of the rest pose, and those of the examples if they are fp32: x, y and z of each vector.
    pub fn singles(&self) -> &'a [[u32; TILE]] {
        match self.narrow {
            true => &self.rows[..3 * self.kinds],
            false => self.rows,
        }
    }

    /// The integers of the examples, with the unit of each vector; `None` if they are fp32.
    pub fn integers(&self) -> Option<(&'a [f32], &'a [[i16; TILE]])> {
        let vectors = self.kinds * (self.centers - 1);
        let (units, rows) = self.rows[3 * self.kinds..].split_at(unit_rows(vectors));
        self.narrow.then(|| {
            let integers = bytemuck::cast_slice::<u32, [i16; TILE]>(rows.as_flattened());
            (&bytemuck::cast_slice(units.as_flattened())[..vectors], &integers[..3 * vectors])
        })
    }
}

/// Rows of 16 words for the units of so many vectors.
fn unit_rows(vectors: usize) -> usize {
    vectors.div_ceil(TILE)
}

/// The rows of a tile, and whether the examples have integers. The first `kinds` vectors are of the rest
/// pose.
fn rows_of(vectors: &[[[f32; TILE]; 3]], kinds: usize) -> (bool, Vec<[u32; TILE]>) {
    let singles = |vectors: &[[[f32; TILE]; 3]]| -> Vec<[u32; TILE]> {
        vectors.as_flattened().iter().map(|row| row.map(f32::to_bits)).collect()
    };
    let (rest, examples) = vectors.split_at(kinds);
    let units: Vec<f32> = examples.iter().map(|vector| unit(vector.as_flattened())).collect();
    let mut integers: Vec<[i16; TILE]> = Vec::new();
    for (vector, unit) in examples.iter().zip(&units) {
        for row in vector {
            let row = row.map(|x| (x / unit, (x / unit).round() as i16));
            if row.iter().any(|(x, integer)| f32::from(*integer) != *x) {
                return (false, singles(vectors));
            }
            integers.push(row.map(|(_, integer)| integer));
        }
    }
    let mut rows = singles(rest);
    let mut words: Vec<u32> = units.iter().map(|unit| unit.to_bits()).collect();
    words.resize(unit_rows(units.len()) * TILE, 0);
    words.extend(bytemuck::cast_slice::<i16, u32>(integers.as_flattened()));
    words.resize(words.len().next_multiple_of(TILE), 0);
    rows.extend(words.as_chunks::<TILE>().0);
    (true, rows)
}

/// The unit in which these numbers are integers of 16 bits: a power of two, so that a product with it is not
/// rounded.
pub(crate) fn unit(numbers: &[f32]) -> f32 {
    let largest = numbers.iter().fold(0.0_f32, |largest, x| largest.max(x.abs()));
    if largest == 0.0 { 1.0 } else { next_power_of_two(largest / LARGEST_INTEGER) }
}

/// The smallest power of two that is not less than a positive number.
pub(crate) fn next_power_of_two(x: f32) -> f32 {
    const MANTISSA: u32 = (1 << 23) - 1;
    f32::from_bits((x.max(f32::MIN_POSITIVE).to_bits() + MANTISSA) & !MANTISSA)
}

impl<T: Real> Rig<T> {
    /// a and b, then c / 2 and w of each example, as devices have them: V×N×2 in mesh units. Where the
    /// wrinkles are functions of strain lengths, a and c / 2 alone, V×N. The table has no columns where the
    /// rig has no [`Rig::bands`].
    pub fn band_weights(&self) -> Table<[T; 3]> {
        let Some(learned) = self.bands() else { return Table::without_columns(self.vertices()) };
        self.assembled_band_weights(
            |v| self.influences_of(v).collect(),
            &learned.example_weights,
            &self.fine_scale().rbf_weights,
        )
    }

    /// The same with other weights: `omegas` of each vertex, c, and b and w.
    pub(crate) fn assembled_band_weights(
        &self,
        omegas: impl Fn(usize) -> Vec<(usize, f64)> + Sync,
        example_weights: &Table<[T; 3]>,
        rbf_weights: &Table<[T; 3]>,
    ) -> Table<[T; 3]> {
        let at_rest: Table<f64> = self.widened_example_vectors().map(|d| vec3::dot(*d, *d));
        let (wrinkles, columns) = (self.vector_wrinkles(), kinds(self.vector_wrinkles()) * self.centers());
        let mut weights = Table::filled(self.vertices(), columns, [T::ZERO; 3]);
        weights.par_rows_mut().enumerate().for_each(|(v, row)| {
            let omegas = omegas(v);
            let mut constant = [0.0; 3];
            let mut centers = row.chunks_exact_mut(kinds(wrinkles));
            let rest = centers.next();
            for (p, of_example) in centers.enumerate() {
                let half = example_weights.row(v).get(p).copied().unwrap_or_default();
                let half = half.map(|c| T::round_from(0.5 * c.widen()));
                let square: f64 = omegas.iter().map(|&(e, omega)| omega * at_rest.row(p)[e]).sum();
                constant = vec3::add(constant, half.map(|c| c.widen() * square));
                of_example[0] = half;
                if wrinkles {
                    of_example[1] = rbf_weights.row(v)[p + 1];
                }
            }
            if let Some(rest) = rest {
                rest[0] = constant.map(T::round_from);
                if wrinkles {
                    rest[1] = rbf_weights.row(v)[0];
                }
            }
        });
        weights
    }

    /// The influences of vertex `v` with other weights: α and ν.
    pub(crate) fn weighted_influences<'a>(
        &'a self,
        v: usize,
        alphas: &'a [T],
        nus: &'a [T],
    ) -> impl Iterator<Item = (usize, f64)> + 'a {
        let edges = self.handles().strain_edges.len();
        let of_edges = self.influences().edges.row(v).iter().zip(alphas);
        let of_edges = of_edges.map(|(e, alpha)| (e.index(), EDGES_SHARE * alpha.widen()));
        let anchors = self.learned().into_iter().flat_map(move |learned| learned.anchors.row(v));
        of_edges.chain(anchors.zip(nus).map(move |(h, nu)| (edges + h.index(), nu.widen())))
    }

    /// The influences of vertex `v` in a rig of the learned method: features and their weights ω. K strain
    /// edges come first, then A anchors.
    pub fn influences_of(&self, v: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let nus = self.learned().map_or(&[][..], |learned| learned.anchor_weights.row(v));
        self.weighted_influences(v, self.influences().weights.row(v), nus)
    }
}
