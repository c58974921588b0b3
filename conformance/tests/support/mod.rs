//! Shared parts of tests: data that lies beside the project, random faces, and a check of similar poses.
#![allow(dead_code, reason = "every test binary uses a part of it")]
pub(crate) mod golden_learned;
pub(crate) mod head;
pub(crate) mod random_face;
pub(crate) mod real;

use rhytid_core::{Rig, StrainEdgeId};

/// Whether every two poses differ in the strains that influence vertex `v`, including the rest pose. They
/// must differ by more than `part` of the largest difference.
pub(crate) fn told_apart(rig: &Rig<f64>, v: usize, part: f64) -> bool {
    let features = &rig.fine_scale().pose_features;
    let mut distances = Vec::new();
    for i in 0..rig.centers() {
        for j in 0..i {
            let (a, b) = (features.row(i), features.row(j));
            let square = |(e, alpha): (StrainEdgeId, f64)| {
                let difference = a[e.index()] - b[e.index()];
                alpha * difference * difference
            };
            let square: f64 = rig.influences().at(v).map(square).sum();
            distances.push(square.sqrt());
        }
    }
    let largest = distances.iter().copied().fold(0.0, f64::max);
    distances.iter().all(|&d| d > part * largest)
}
