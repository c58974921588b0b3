//! Distances of a frame's vector strains from those of each centre, as each vertex sees them, with bounds for
//! their rounding.
use crate::expected::Expected;
use crate::tolerance::{self, TINY, gamma};
use rhytid_core::{Learned, Rig, Table};
use rhytid_kernels::bands::EDGES_SHARE;
use rhytid_kernels::vec3;
use rhytid_kernels::vector_differences::limited;

/// The distances of every frame of a batch.
pub(crate) struct Distances<'a> {
    rig: &'a Rig<f64>,
    learned: &'a Learned<f64>,
    /// (frames × N)×(F + H).
    table: Table<Expected>,
    /// frames×(F + H): what is not followed of each vector strain.
    excess: Table<[Expected; 3]>,
}

impl<'a> Distances<'a> {
    /// `None` where the rig has no bands. `handle_positions` is frames × H.
    pub(crate) fn new(rig: &'a Rig<f64>, handle_positions: &[[f64; 3]]) -> Option<Self> {
        let learned = rig.bands()?;
        let handles = rig.handles();
        let (features, lengths) = (handles.features(), handles.feature_lengths());
        let (examples, limits) = (rig.example_vectors(), rig.feature_limits());
        let rest = &handles.rest;
        let (mut table, mut excess) = (Vec::new(), Vec::new());
        for positions in handle_positions.chunks_exact(rest.len()) {
            let u: Vec<[f64; 3]> = positions.iter().zip(rest).map(|(p, rest)| vec3::sub(*p, *rest)).collect();
            for j in 0..rig.centers() {
                table.extend((0..features).map(|e| {
                    let ends = match handles.strain_edges.get(e) {
                        Some(&[a, b]) => [u[b.index()], u[a.index()]],
                        None => [u[e - handles.strain_edges.len()], [0.0; 3]],
                    };
                    let of_example = if j == 0 { [0.0; 3] } else { examples.row(j - 1)[e] };
                    let sizes = [0, 1, 2].map(|c| (ends[0][c].abs() + ends[1][c].abs()) / lengths[e]);
                    let errors = sizes.map(|size| gamma(tolerance::VECTOR_STRAIN) * size);
                    let unlimited = vec3::sub(ends[0], ends[1]).map(|x| x / lengths[e]);
                    let followed = limited(unlimited, limits[e]);
                    // A vector whose length has an error is limited to another part of each component.
                    let may_be_limited = vec3::length(unlimited) + vec3::length(errors) >= limits[e];
                    if j == 0 {
                        excess.push([0, 1, 2].map(|c| match may_be_limited {
                            true => Expected {
                                value: unlimited[c] - followed[c],
                                bound: errors[c]
                                    + vec3::length(errors)
                                    + gamma(tolerance::LIMITED + 1.0) * unlimited[c].abs()
                                    + TINY,
                            },
                            false => Expected::default(),
                        }));
                    }
                    let mut square = Expected::default();
                    for c in 0..3 {
                        let d = followed[c];
                        let away = d - of_example[c];
                        let of_limit = match may_be_limited {
                            true => vec3::length(errors) + gamma(tolerance::LIMITED) * d.abs(),
                            false => 0.0,
                        };
                        let error = errors[c]
                            + of_limit
                            + gamma(tolerance::ROUNDED) * (d.abs() + of_example[c].abs())
                            + gamma(1.0) * away.abs()
                            + 3.0 * TINY;
                        square.value += away * away;
                        square.bound += (2.0 * away.abs() + error) * error + TINY;
                    }
                    square.bound += gamma(tolerance::SQUARED_DIFFERENCE) * (square.value + square.bound);
                    square
                }));
            }
        }
        let rows = handle_positions.len() / rest.len() * rig.centers();
        let excess = Table::new(handle_positions.len() / rest.len(), features, excess);
        Some(Self { rig, learned, table: Table::new(rows, features, table), excess })
    }

    /// What the basis does to a vertex beyond the rig's reach, which is taken back.
    pub(crate) fn beyond(&self, frame: usize, v: usize) -> [Expected; 3] {
        let mut sum = [Expected::default(); 3];
        if !self.rig.limits_basis() {
            return sum;
        }
        let gains = self.learned.feature_gains.row(v);
        let roundings = gamma(tolerance::beyond(gains.len()));
        for ((e, _), gain) in self.rig.influences_of(v).zip(gains) {
            for (sum, d) in sum.iter_mut().zip(self.excess.row(frame)[e]) {
                sum.value += gain * d.value;
                sum.bound += (1.0 + roundings) * gain.abs() * d.bound + roundings * (gain * d.value).abs();
            }
        }
        sum
    }

    /// The squared distance S of a vertex in a frame, from each of N centres.
    pub(crate) fn squares(&self, frame: usize, v: usize) -> Vec<Expected> {
        let Self { rig, learned, table, .. } = self;
        let edges = rig.handles().strain_edges.len();
        let (k, a) = (rig.influences().per_vertex(), learned.anchors_per_vertex());
        let of_edges = rig.influences().at(v).map(|(e, alpha)| (e.index(), EDGES_SHARE * alpha));
        let of_anchors = learned.anchors_of(v).map(|(h, nu)| (edges + h.index(), nu));
        let listens: Vec<(usize, f64)> = of_edges.chain(of_anchors).collect();
        let roundings = gamma(tolerance::squared_distance(k + a));
        let centers = rig.centers();
        (0..centers)
            .map(|j| {
                let of_center = table.row(frame * centers + j);
                let value: f64 = listens.iter().map(|(e, omega)| omega * of_center[*e].value).sum();
                let error: f64 = listens.iter().map(|(e, omega)| omega * of_center[*e].bound + TINY).sum();
                Expected { value, bound: error + roundings * (value + error) }
            })
            .collect()
    }
}
