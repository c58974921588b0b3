//! What several tests need: data that lies beside the project, random faces, and when poses look the same.
#![allow(dead_code, reason = "every test binary uses a part of it")]
pub(crate) mod golden_learned;
pub(crate) mod head;
pub(crate) mod random_face;
pub(crate) mod real;

use rhytid_core::{Rig, StrainEdgeId};

/// Whether every two poses, the rest pose included, differ in the strains that vertex `v` listens to by more than
/// `part` of the largest difference.
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
            let square: f64 = rig.influences().of(v).map(square).sum();
            distances.push(square.sqrt());
        }
    }
    let largest = distances.iter().copied().fold(0.0, f64::max);
    distances.iter().all(|&d| d > part * largest)
}
