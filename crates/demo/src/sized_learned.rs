//! What the learned method adds to a rig that is made without solving.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{FoldStrains, Learned, Rig};

/// A, as of a solve's vertices.
const ANCHORS: usize = 8;

/// The part of a vertex's weights that its anchors have.
const ANCHORS_SHARE: f64 = 0.1;

/// The influence that is taken off all of a vertex's: the next one beyond those that are kept has as much.
const THRESHOLD: f64 = 0.025;

/// The rig of the chapter's method with the influences, anchors and linear band of the learned one: as the solve has them, but for distances, which are
/// straight.
///
/// `handle_rest` is H×3 and `rest_lengths` F, in mesh units.
pub(crate) fn learned(mut rig: Rig<f64>, handle_rest: &[[f64; 3]], rest_lengths: &[f64]) -> Rig<f64> {
    let (vertices, examples, k) = (rig.vertices(), rig.example_names.len(), rig.influences());
    let a = ANCHORS.min(handle_rest.len());
    let mean = rest_lengths.iter().sum::<f64>() / rest_lengths.len() as f64;
    let (mut edges, mut weights) = (vec![0; vertices * k], vec![0.0; vertices * k]);
    let (mut anchors, mut anchor_weights) = (vec![0; vertices * a], vec![0.0; vertices * a]);
    let of_edges = edges.par_chunks_mut(k).zip(weights.par_chunks_mut(k));
    let of_anchors = anchors.par_chunks_mut(a).zip(anchor_weights.par_chunks_mut(a));
    of_edges.zip(of_anchors).zip(&rig.rest).for_each(
        |(((edges, weights), (anchors, anchor_weights)), vertex)| {
            let to_handle: Vec<f64> =
                handle_rest.iter().map(|h| DVec3::from(*vertex).distance(DVec3::from(*h))).collect();
            let excess = rig.strain_edges.iter().zip(rest_lengths);
            let excess =
                excess.map(|(&[a, b], length)| to_handle[a as usize] + to_handle[b as usize] - length);
            let (near, next) = nearest(excess, k);
            let least = near.iter().fold(f64::INFINITY, |least, (_, s)| least.min(*s));
            let gap = (next - least).max(0.1 * mean);
            let alpha = |s: f64| ((THRESHOLD.ln() * (s - least) / gap).exp() - THRESHOLD).max(0.0);
            put(&near, alpha, 1.0, edges, weights);
            let (near, _) = nearest(to_handle.into_iter(), a);
            let nu = |g: f64| (-(g / (1.5 * mean)).powi(2)).exp();
            put(&near, nu, ANCHORS_SHARE, anchors, anchor_weights);
        },
    );
    let wave = |i: usize| (i as f64 * 0.618).cos();
    rig.influence_edges = edges;
    rig.influence_weights = weights;
    rig.learned = Some(Learned {
        share: 1.0,
        ridge: 1e-2,
        fold_ridge: 1e-3,
        marker_noise: 0.005,
        reach: 1.0,
        fold_strains: FoldStrains::Vectors,
        anchors,
        anchor_weights,
        feature_gains: vec![0.0; vertices * (k + a)],
        example_weights: (0..vertices * examples).map(|i| [0.3, 0.2, 0.1].map(|c| c * wave(i))).collect(),
        variances: vec![1.0; vertices],
    });
    rig
}

/// The `count` smallest numbers with their indices, which ascend, and the next larger one.
fn nearest(numbers: impl Iterator<Item = f64>, count: usize) -> (Vec<(u32, f64)>, f64) {
    let mut all: Vec<(u32, f64)> = (0..).zip(numbers).collect();
    let last = count.min(all.len() - 1);
    let (_, (_, next), _) = all.select_nth_unstable_by(last, |a, b| a.1.total_cmp(&b.1));
    let next = *next;
    all.truncate(count);
    all.sort_unstable_by_key(|&(i, _)| i);
    (all, next)
}

/// The indices, and weights that are in proportion to what `weight` makes of the numbers and add up to `share`.
fn put(
    near: &[(u32, f64)],
    weight: impl Fn(f64) -> f64,
    share: f64,
    indices: &mut [u32],
    weights: &mut [f64],
) {
    let sum: f64 = near.iter().map(|(_, x)| weight(*x)).sum();
    for ((index, to), (i, x)) in indices.iter_mut().zip(weights).zip(near) {
        (*index, *to) = (*i, share * weight(*x) / sum);
    }
}
