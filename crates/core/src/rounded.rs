//! A rig's numbers rounded to what devices keep.
use crate::band_weights::unit;
use crate::{BasisStorage, ClusteredBasis, Result, Rig, Table, VertexId};
use half::f16;
use rayon::prelude::*;
use rhytid_kernels::bands::{bits_of_weight, weight_of_bits};
use rhytid_kernels::tile::TILE;
use rhytid_kernels::vec3;

/// A rig's weights in 16 bits. In a tile, c / 2 and w of each example are integers with a common unit.
pub(crate) struct Rounded {
    /// α, V×K.
    alphas: Table<f32>,
    /// ν, V×A.
    nus: Table<f32>,
    /// c, V×P, or without columns.
    example_weights: Table<[f32; 3]>,
    /// b and w, V×N.
    rbf_weights: Table<[f32; 3]>,
}

/// The vector strains of examples and of frames in which no handle moves farther than
/// [`BasisStorage::motion`].
struct Strains {
    /// D, P×(F + H).
    examples: Table<[f64; 3]>,
    /// The largest |D_e| of such a frame, F + H.
    farthest: Vec<f64>,
}

impl Strains {
    fn new(rig: &Rig) -> Self {
        let edges = rig.handles().strain_edges.len();
        // The two ends of a strain edge can move apart by twice as much as either moves.
        let ends = |e: usize| if e < edges { 2.0 } else { 1.0 };
        let motion = BasisStorage::motion(rig);
        let lengths = rig.handles().feature_lengths().into_iter().zip(rig.feature_limits());
        let farthest = lengths.enumerate().map(|(e, (length, limit))| {
            // Strains are followed up to their limits.
            (ends(e) * motion / length).min(limit.into())
        });
        Self { examples: rig.widened_example_vectors(), farthest: farthest.collect() }
    }

    /// A bound of how far a vertex with these influences moves along an axis if c of the examples changes by
    /// `of_bands`, and w by `of_wrinkles`.
    fn error(&self, omegas: &[(usize, f64)], of_bands: &[[f64; 3]], of_wrinkles: &[[f64; 3]]) -> f64 {
        // A distance ‖D − D_p‖ differs from ‖D‖ and from ‖D_p‖ by at most the other one. What counts is how
        // ‖D − D_p‖ − ‖D‖ differs from ‖D_p‖, which it is at rest.
        let length = |square: &dyn Fn(usize) -> f64| {
            omegas.iter().map(|&(e, omega)| omega * square(e)).sum::<f64>().sqrt()
        };
        let farthest = length(&|e| self.farthest[e].powi(2));
        let distances: Vec<f64> = of_wrinkles
            .iter()
            .zip(self.examples.rows())
            .map(|(_, strains)| 2.0 * farthest.min(length(&|e| vec3::dot(strains[e], strains[e]))))
            .collect();
        let of_axis = |axis: usize| {
            let mut error = 0.0;
            for &(e, omega) in omegas {
                let mut sum = [0.0; 3];
                for (change, strains) in of_bands.iter().zip(self.examples.rows()) {
                    sum = vec3::add(sum, strains[e].map(|d| change[axis] * d));
                }
                error += omega * self.farthest[e] * vec3::length(sum);
            }
            let of_wrinkles = of_wrinkles.iter().zip(&distances);
            error + of_wrinkles.map(|(change, distance)| change[axis].abs() * distance).sum::<f64>()
        };
        (0..3).map(of_axis).fold(0.0, f64::max)
    }
}

impl Rounded {
    /// `None` if this storage keeps the weights as they are.
    pub(crate) fn of(rig: &Rig, storage: BasisStorage) -> Option<Self> {
        let learned = rig.learned().filter(|_| storage.has_narrow_weights(rig.vector_wrinkles()))?;
        let kept = |x: &f32| weight_of_bits(bits_of_weight(*x));
        let mut rounded = Self {
            alphas: rig.influences().weights.map(kept),
            nus: learned.anchor_weights.map(kept),
            example_weights: learned.example_weights.clone(),
            rbf_weights: rig.fine_scale().rbf_weights.clone(),
        };
        let strains = Strains::new(rig);
        let mut is_held = vec![false; rig.vertices()];
        rig.handles().held().for_each(|v: VertexId| is_held[v.index()] = true);
        let tiles = rig.vertices().div_ceil(TILE);
        let of_tile = |tile: usize| rounded.tile(rig, &strains, &is_held, tile);
        let all: Vec<Option<Vec<[[f32; 3]; 2]>>> = (0..tiles).into_par_iter().map(of_tile).collect();
        let examples = rig.examples().len();
        for (tile, vectors) in all.into_iter().enumerate() {
            for (i, &[c, w]) in vectors.iter().flatten().enumerate() {
                let (v, p) = (tile * TILE + i / examples, i % examples);
                if rounded.example_weights.columns() > 0 {
                    rounded.example_weights.row_mut(v)[p] = c;
                }
                rounded.rbf_weights.row_mut(v)[p + 1] = w;
            }
        }
        rounded.keep_rest(rig, &strains);
        Some(rounded)
    }

    /// ω of a vertex.
    fn omegas(&self, rig: &Rig, v: usize) -> Vec<(usize, f64)> {
        rig.weighted_influences(v, self.alphas.row(v), self.nus.row(v)).collect()
    }

    /// c and w of a tile's vertices and examples as integers times a unit. `None` if they stay as they are.
    /// They do where a handle holds one of the vertices, or where one could be moved too far.
    fn tile(
        &self,
        rig: &Rig,
        strains: &Strains,
        is_held: &[bool],
        tile: usize,
    ) -> Option<Vec<[[f32; 3]; 2]>> {
        let vertices = tile * TILE..((tile + 1) * TILE).min(rig.vertices());
        let examples = rig.examples().len();
        let largest_error = ClusteredBasis::LARGEST_ERROR * BasisStorage::motion(rig);
        let exact = |v: usize, p: usize| -> [[f32; 3]; 2] {
            let c = self.example_weights.row(v).get(p).copied().unwrap_or_default();
            [c, self.rbf_weights.row(v)[p + 1]]
        };
        let units: Vec<[f32; 2]> = (0..examples)
            .map(|p| {
                let of = |kind: usize| {
                    let vectors: Vec<[f32; 3]> = vertices.clone().map(|v| exact(v, p)[kind]).collect();
                    unit(vectors.as_flattened())
                };
                [of(0), of(1)]
            })
            .collect();
        let mut all = Vec::new();
        for v in vertices {
            let mut changes = [Vec::new(), Vec::new()];
            for (p, units) in units.iter().enumerate() {
                let exact = exact(v, p);
                let rounded: [[f32; 3]; 2] =
                    std::array::from_fn(|kind| exact[kind].map(|x| (x / units[kind]).round() * units[kind]));
                for (kind, changes) in changes.iter_mut().enumerate() {
                    changes.push(vec3::sub(rounded[kind].map(f64::from), exact[kind].map(f64::from)));
                }
                all.push(rounded);
            }
            let [of_bands, of_wrinkles] = &changes;
            let error = strains.error(&self.omegas(rig, v), of_bands, of_wrinkles);
            if error > largest_error || (is_held[v] && error > 0.0) {
                return None;
            }
        }
        Some(all)
    }

    /// Changes b by what the others have changed at rest.
    fn keep_rest(&mut self, rig: &Rig, strains: &Strains) {
        let at_rest: Table<f64> = strains.examples.map(|d| vec3::dot(*d, *d));
        let wrinkles = |omegas: &[(usize, f64)], weights: &[[f32; 3]]| {
            let mut sum = [0.0; 3];
            for (w, squares) in weights[1..].iter().zip(at_rest.rows()) {
                let square: f64 = omegas.iter().map(|&(e, omega)| omega * squares[e]).sum();
                sum = vec3::add(sum, w.map(|w| f64::from(w) * square.sqrt()));
            }
            sum
        };
        let constants = (0..rig.vertices()).into_par_iter().map(|v| {
            let exact = rig.fine_scale().rbf_weights.row(v);
            let omegas: Vec<(usize, f64)> = rig.influences_of(v).collect();
            let change =
                vec3::sub(wrinkles(&omegas, exact), wrinkles(&self.omegas(rig, v), self.rbf_weights.row(v)));
            vec3::add(exact[0].map(f64::from), change).map(|b| b as f32)
        });
        let constants: Vec<[f32; 3]> = constants.collect();
        for (weights, constant) in self.rbf_weights.rows_mut().zip(constants) {
            weights[0] = constant;
        }
    }

    /// As [`Rig::band_weights`].
    pub(crate) fn band_weights(&self, rig: &Rig) -> Table<[f32; 3]> {
        rig.assembled_band_weights(|v| self.omegas(rig, v), &self.example_weights, &self.rbf_weights)
    }
}

impl Rig {
    /// The rig with the numbers that a device keeps. Conformance compares devices with its reference.
    ///
    /// - [`BasisStorage::F16`] rounds the basis. [`BasisStorage::Clustered`] does not: the factors of a
    ///   [`ClusteredBasis`] are not a rig's.
    /// - Both have α and ν, and c and w of each example, in 16 bits, if the wrinkles are functions of vector
    ///   strains. b is what makes the wrinkles zero at rest.
    /// - [`BasisStorage::F32`] changes nothing.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if a number of the basis is too large for fp16.
    pub fn as_stored(self, storage: BasisStorage) -> Result<Self> {
        let rounded = Rounded::of(&self, storage);
        let mut parts = self.into_parts();
        if storage == BasisStorage::F16 {
            parts.basis = parts.basis.map(|b| f16::from_f32(*b).to_f32());
        }
        if let (Some(rounded), Some(learned)) = (rounded, &mut parts.learned) {
            parts.influences.weights = rounded.alphas;
            parts.fine_scale.rbf_weights = rounded.rbf_weights;
            learned.anchor_weights = rounded.nus;
            learned.example_weights = rounded.example_weights;
        }
        Self::new(parts)
    }

    /// A bound for each of the V vertices of how far 16 bits move it along an axis, in mesh units, if no
    /// handle moves farther than [`BasisStorage::motion`]. 0 if this storage keeps the weights as they are.
    /// Changes of α and ν count for the linear band alone: a distance of the wrinkles changes by at most a
    /// 4096th.
    pub(crate) fn errors_of_bands(&self, storage: BasisStorage) -> Vec<f64> {
        let Some(rounded) = Rounded::of(self, storage) else { return vec![0.0; self.vertices()] };
        let Some(learned) = self.learned() else { return vec![0.0; self.vertices()] };
        let strains = Strains::new(self);
        let difference = |a: &[[f32; 3]], b: &[[f32; 3]]| -> Vec<[f64; 3]> {
            a.iter().zip(b).map(|(a, b)| vec3::sub(a.map(f64::from), b.map(f64::from))).collect()
        };
        let of_vertex = |v: usize| {
            let exact: Vec<(usize, f64)> = self.influences_of(v).collect();
            let omegas = rounded.omegas(self, v);
            let of_bands = difference(rounded.example_weights.row(v), learned.example_weights.row(v));
            let wrinkles = [&rounded.rbf_weights, &self.fine_scale().rbf_weights].map(|w| &w.row(v)[1..]);
            let of_wrinkles = difference(wrinkles[0], wrinkles[1]);
            let changed =
                exact.iter().zip(&omegas).map(|(a, b)| (a.0, (a.1 - b.1).abs())).collect::<Vec<_>>();
            let c: Vec<[f64; 3]> = learned.example_weights.row(v).iter().map(|c| c.map(f64::from)).collect();
            strains.error(&omegas, &of_bands, &of_wrinkles) + strains.error(&changed, &c, &[])
        };
        (0..self.vertices()).into_par_iter().map(of_vertex).collect()
    }
}
