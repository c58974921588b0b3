//! The data of the learned method for a rig that is made without a solve.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{HandleId, Learned, RigParts, StrainEdgeId, Table, WrinkleStrains};

/// A, as in a solve.
const ANCHORS: usize = 8;

/// The share of anchors in a vertex's weights.
const ANCHORS_SHARE: f64 = 0.1;

/// The influence that is subtracted from all of a vertex's influences: that of the first one that is not
/// kept.
const THRESHOLD: f64 = 0.025;

/// Gives the rig of the chapter's method the influences, anchors and linear band of the learned one. They are
/// as in the solve, except that distances are straight.
pub(crate) fn learn(parts: &mut RigParts<f64>) {
    let RigParts { surface, handles, examples, influences, .. } = &*parts;
    let (vertices, k) = (surface.rest.len(), influences.per_vertex());
    let (a, rest_lengths) = (ANCHORS.min(handles.len()), handles.rest_lengths());
    let mean = rest_lengths.iter().sum::<f64>() / rest_lengths.len() as f64;
    let (mut edges, mut weights) =
        (Table::filled(vertices, k, StrainEdgeId(0)), Table::filled(vertices, k, 0.0));
    let (mut anchors, mut anchor_weights) =
        (Table::filled(vertices, a, HandleId(0)), Table::filled(vertices, a, 0.0));
    let of_edges = edges.par_rows_mut().zip(weights.par_rows_mut());
    let of_anchors = anchors.par_rows_mut().zip(anchor_weights.par_rows_mut());
    of_edges.zip(of_anchors).zip(&surface.rest).for_each(
        |(((edges, weights), (anchors, anchor_weights)), vertex)| {
            let to_handle: Vec<f64> =
                handles.rest.iter().map(|h| DVec3::from(*vertex).distance(DVec3::from(*h))).collect();
            let excess = handles.strain_edges.iter().zip(&rest_lengths);
            let excess = excess.map(|(&[a, b], length)| to_handle[a.index()] + to_handle[b.index()] - length);
            let (near, next) = nearest(excess, k);
            let least = near.iter().fold(f64::INFINITY, |least, (_, s)| least.min(*s));
            let gap = (next - least).max(0.1 * mean);
            let alpha = |s: f64| ((THRESHOLD.ln() * (s - least) / gap).exp() - THRESHOLD).max(0.0);
            edges.iter_mut().zip(&near).for_each(|(edge, (i, _))| *edge = StrainEdgeId::from_index(*i));
            put(&near, alpha, 1.0, weights);
            let (near, _) = nearest(to_handle.into_iter(), a);
            let nu = |g: f64| (-(g / (1.5 * mean)).powi(2)).exp();
            anchors.iter_mut().zip(&near).for_each(|(anchor, (i, _))| *anchor = HandleId::from_index(*i));
            put(&near, nu, ANCHORS_SHARE, anchor_weights);
        },
    );
    let wave = |i: usize| (i as f64 * 0.618).cos();
    let p = examples.len();
    let example_weights = (0..vertices * p).map(|i| [0.3, 0.2, 0.1].map(|c| c * wave(i))).collect();
    parts.influences.edges = edges;
    parts.influences.weights = weights;
    parts.learned = Some(Learned {
        share: 1.0,
        ridge: 1e-2,
        wrinkle_ridge: 1e-3,
        marker_noise: 0.005,
        reach: 1.0,
        prior_lengths: Vec::new(),
        wrinkle_strains: WrinkleStrains::Vectors,
        anchors,
        anchor_weights,
        feature_gains: Table::filled(vertices, k + a, 0.0),
        example_weights: Table::new(vertices, p, example_weights),
        variances: vec![1.0; vertices],
        contact: <_>::default(),
    });
}

/// The `count` smallest numbers with their indices, which ascend, and the next larger number.
fn nearest(numbers: impl Iterator<Item = f64>, count: usize) -> (Vec<(usize, f64)>, f64) {
    let mut all: Vec<(usize, f64)> = numbers.enumerate().collect();
    let last = count.min(all.len() - 1);
    let (_, (_, next), _) = all.select_nth_unstable_by(last, |a, b| a.1.total_cmp(&b.1));
    let next = *next;
    all.truncate(count);
    all.sort_unstable_by_key(|&(i, _)| i);
    (all, next)
}

/// Puts weights that are proportional to `weight` of the numbers and sum to `share`.
fn put(near: &[(usize, f64)], weight: impl Fn(f64) -> f64, share: f64, weights: &mut [f64]) {
    let sum: f64 = near.iter().map(|(_, x)| weight(*x)).sum();
    for (to, (_, x)) in weights.iter_mut().zip(near) {
        *to = share * weight(*x) / sum;
    }
}
