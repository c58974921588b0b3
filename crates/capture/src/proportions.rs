//! Proportions: markers move more where the rig's face is larger than the actor's, and less where it is
//! smaller.
use crate::tracks::extent;
use glam::DVec3;
use rhytid_core::numbers::median;

/// Neighbours within about this part of the face's extent are of the same region.
const REGION: f64 = 0.15;

/// Pairs that are nearer than this part of the extent are ignored: markers are not glued on to the
/// millimetre.
const NEAR: f64 = 0.05;

/// Smallest and largest scale of a handle.
const SCALES: [f64; 2] = [0.7, 1.4];

/// For each handle, how large the rig is around it compared with the actor. The scale is a weighted median
/// over the pairs of handles in its region. Each pair gives its distance on the rig (`rest`) divided by the
/// distance of its markers at neutral. `markers` are in the rig's space, with the actor's size taken out; NaN
/// where they were not seen.
pub(crate) fn scales(markers: &[DVec3], rest: &[DVec3]) -> Vec<f64> {
    let extent = extent(rest.iter().copied());
    let weight = |a: usize, b: usize| (-0.5 * (rest[a].distance(rest[b]) / (REGION * extent)).powi(2)).exp();
    let of_handle = |j: usize| {
        // All pairs of the region count, not only those of the handle: a misplaced handle must not set its
        // own scale.
        let region: Vec<usize> = (0..rest.len()).filter(|&k| weight(j, k) > 0.1).collect();
        let mut ratios = Vec::new();
        for (i, &a) in region.iter().enumerate() {
            for &b in &region[i + 1..] {
                let (rig, actor) = (rest[a].distance(rest[b]), markers[a].distance(markers[b]));
                if rig > NEAR * extent && actor > 0.0 {
                    ratios.push((rig / actor, weight(j, a) * weight(j, b)));
                }
            }
        }
        weighted_median(&mut ratios).unwrap_or(1.0)
    };
    let scales: Vec<f64> = (0..rest.len()).map(of_handle).collect();
    // The overall size belongs to the alignment.
    let whole = median(&mut scales.clone());
    scales
        .iter()
        .map(|scale| if whole > 0.0 { (scale / whole).clamp(SCALES[0], SCALES[1]) } else { 1.0 })
        .collect()
}

fn weighted_median(values: &mut [(f64, f64)]) -> Option<f64> {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    values.iter().find_map(|(value, weight)| {
        sum += weight;
        (sum >= half).then_some(*value)
    })
}
