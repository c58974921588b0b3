//! Section 4: the influences of strain edges on vertices, and their weights.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{HandleId, Influences, StrainEdgeId, Table};

/// α below this counts as none.
pub const INFLUENCE_THRESHOLD: f64 = 0.025;

/// The K strain edges that influence each vertex, and their weights α.
///
/// They are the edges of smallest `s = ‖v − p_i1‖ + ‖v − p_i2‖ − l` at rest (ties: the lower edge index),
/// with K = min(`max_influences`, F). The weights are `α = exp(−β (s − min s))`, with the smallest β for
/// which no vertex has a (K+1)-th edge over the threshold. β is 0 where F ≤ K. α is 1 for a vertex's nearest
/// edge, and 0 below [`INFLUENCE_THRESHOLD`].
///
/// `rest` is V×3, `handle_rest` H×3, `rest_lengths` F. The caller ensures `max_influences ≥ 1`.
pub fn influences(
    rest: &[[f64; 3]],
    handle_rest: &[[f64; 3]],
    strain_edges: &[[HandleId; 2]],
    rest_lengths: &[f64],
    max_influences: usize,
) -> Influences<f64> {
    let k = max_influences.min(strain_edges.len());
    let mut edges = Table::filled(rest.len(), k, StrainEdgeId(0));
    let mut weights = Table::filled(rest.len(), k, 0.0);
    if k == 0 {
        return Influences { edges, weights, beta: 0.0 };
    }
    // The weights hold s − min s until β is known.
    let beta =
        edges
            .par_rows_mut()
            .zip(weights.par_rows_mut())
            .zip(rest)
            .map_init(
                || (vec![0.0; handle_rest.len()], Vec::with_capacity(strain_edges.len())),
                |(to_handle, order), ((edges, excess), v)| {
                    for (d, p) in to_handle.iter_mut().zip(handle_rest) {
                        *d = DVec3::from_array(*v).distance(DVec3::from_array(*p));
                    }
                    order.clear();
                    order.extend(strain_edges.iter().zip(rest_lengths).enumerate().map(
                        |(i, (&[a, b], l))| (to_handle[a.index()] + to_handle[b.index()] - l, i as u32),
                    ));
                    let nearer = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
                    let next = (k < order.len()).then(|| order.select_nth_unstable_by(k, nearer).1.0);
                    let least = order[..k].iter().fold(f64::INFINITY, |least, &(s, _)| least.min(s));
                    order[..k].sort_unstable_by_key(|&(_, edge)| edge);
                    for (i, &(s, edge)) in order[..k].iter().enumerate() {
                        edges[i] = StrainEdgeId(edge);
                        excess[i] = s - least;
                    }
                    next.map_or(0.0, |s| -INFLUENCE_THRESHOLD.ln() / (s - least))
                },
            )
            .reduce(|| 0.0, f64::max);
    weights.as_mut_slice().par_iter_mut().for_each(|w| {
        // A tie of more than K edges makes β infinite. The nearest edge still keeps its weight of 1.
        let alpha = if *w == 0.0 { 1.0 } else { (-beta * *w).exp() };
        *w = if alpha < INFLUENCE_THRESHOLD { 0.0 } else { alpha };
    });
    Influences { edges, weights, beta }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_edges_of_three_on_a_line() {
        let handle_rest = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        let strain_edges = [[0, 1], [1, 2], [2, 3]].map(|pair| pair.map(HandleId));
        let got = influences(&[[0.5, 0.0, 0.0], [1.0, 0.0, 0.0]], &handle_rest, &strain_edges, &[1.0; 3], 2);
        // s of vertex 0: 0, 1, 3; of vertex 1: 0, 0, 2. The third edge decides: ln 40 / 2.
        assert_eq!(StrainEdgeId::numbers(got.edges.as_slice()), [0, 1, 0, 1]);
        let weights = got.weights.as_slice();
        let beta = 40f64.ln() / 2.0;
        assert!((got.beta - beta).abs() < 1e-15);
        assert!((weights[1] - (-beta).exp()).abs() < 1e-15);
        assert_eq!([weights[0], weights[2], weights[3]], [1.0; 3]);
        let all = influences(&[[0.5, 0.0, 0.0]], &handle_rest, &strain_edges, &[1.0; 3], 9);
        assert_eq!(StrainEdgeId::numbers(all.edges.as_slice()), [0, 1, 2]);
        assert_eq!((all.beta, all.weights), (0.0, Table::filled(1, 3, 1.0)));
    }
}
