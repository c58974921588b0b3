//! What several tests need: data that lies beside the project, random faces, and when poses look the same.
#![allow(dead_code, reason = "every test binary uses a part of it")]
pub(crate) mod golden_learned;
pub(crate) mod head;
pub(crate) mod random_face;
pub(crate) mod real;

use rhytid_core::Rig;

/// Whether every two poses, the rest pose included, differ in the strains that vertex `v` listens to by more than
/// `part` of the largest difference.
pub(crate) fn told_apart(rig: &Rig<f64>, v: usize, part: f64) -> bool {
    let (k, f, n) = (rig.influences(), rig.strain_edges.len(), rig.centers());
    let mut distances = Vec::new();
    for i in 0..n {
        for j in 0..i {
            let square: f64 = (0..k)
                .map(|m| {
                    let e = rig.influence_edges[v * k + m] as usize;
                    let difference = rig.pose_features[i * f + e] - rig.pose_features[j * f + e];
                    rig.influence_weights[v * k + m] * difference * difference
                })
                .sum();
            distances.push(square.sqrt());
        }
    }
    let largest = distances.iter().copied().fold(0.0, f64::max);
    distances.iter().all(|&d| d > part * largest)
}
