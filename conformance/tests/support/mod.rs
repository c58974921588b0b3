//! What several tests need: data that lies beside the project, random faces, and when poses look the same.
#![allow(dead_code, reason = "every test binary uses a part of it")]
pub mod head;
pub mod random_face;
pub mod real;

use rhytid_core::Rig;
use std::io::Write;
use std::path::PathBuf;

/// The folder `../shared` beside the repository, or `None`, said loudly, where it is not there.
///
/// # Panics
/// Where it is missing and `RHYTID_REQUIRE_SHARED` is set.
pub fn shared() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared"));
    if folder.is_dir() {
        return Some(folder);
    }
    let required = std::env::var_os("RHYTID_REQUIRE_SHARED").is_some_and(|v| !v.is_empty());
    assert!(!required, "{} is not there, but RHYTID_REQUIRE_SHARED is set", folder.display());
    // Written past the test harness, which would keep it to itself.
    let _ = writeln!(
        std::io::stderr(),
        "\n*** NOT TESTED: {} is not there, so this test did nothing ***\n",
        folder.display()
    );
    None
}

/// Whether every two poses, the rest pose included, differ in the strains that vertex `v` listens to by more than
/// `part` of the largest difference.
pub fn told_apart(rig: &Rig<f64>, v: usize, part: f64) -> bool {
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
