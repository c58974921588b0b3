//! The rigid motion between two states of a body of which only a part is rigid, such as a head with another
//! expression.
use super::similarity::{Similarity, fit};
use glam::DVec3;

/// The first and the last tolerance of the search, in parts of the points' extent. On a head they are
/// centimetres and hundredths of a millimetre.
const TOLERANCES: [f64; 2] = [0.05, 5e-5];

/// Each tolerance is this part of the one before.
const SHRINK: f64 = 0.7;

/// The number of fits with one tolerance.
const ITERATIONS: usize = 12;

/// The tolerance stops shrinking before less than this part of the weight would be within it.
const LEAST: f64 = 0.1;

/// The rigid part of two states of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidInliers {
    /// Takes the first state to the second, with scale 1.
    pub motion: Similarity,
    /// The last tolerance, in the points' unit: about how near the rigid part comes.
    pub tolerance: f64,
}

fn share(motion: &Similarity, from: &[DVec3], to: &[DVec3], weights: &[f64], distance: f64) -> f64 {
    let (mut near, mut all) = (0.0, 0.0);
    for ((a, b), w) in from.iter().zip(to).zip(weights) {
        all += w;
        if motion.apply(*a).distance(*b) <= distance {
            near += w;
        }
    }
    near / all
}

/// The rigid motion of the largest part of N points that moves as one, from `from` to `to`. Each point has a
/// weight of 0 or more.
///
/// Fits are reweighted by Geman and McClure's function (Black and Rangarajan's graduated non-convexity). The
/// tolerance shrinks as long as a tenth of the weight is within it. `None` if the points have no rigid fit:
/// there are fewer than three, or they lie on a line.
///
/// ```
/// # use glam::{DQuat, DVec3};
/// let body: Vec<DVec3> = (0..200).map(|i| DVec3::new(f64::from(i % 7), f64::from(i % 11), f64::from(i % 13))).collect();
/// let turn = DQuat::from_rotation_y(0.1);
/// // Two thirds of it do something else besides.
/// let moved = |(i, x): (usize, &DVec3)| turn * *x + if i % 3 > 0 { DVec3::splat(0.01 * i as f64) } else { DVec3::ZERO };
/// let after: Vec<DVec3> = body.iter().enumerate().map(moved).collect();
/// let still = rhytid_geometry::registration::rigid_inliers(&body, &after, &[1.0; 200]).unwrap();
/// assert!(still.motion.rotation.angle_between(turn) < 1e-6);
/// ```
pub fn rigid_inliers(from: &[DVec3], to: &[DVec3], weights: &[f64]) -> Option<RigidInliers> {
    let first = from.first()?;
    let (low, high) = from.iter().fold((*first, *first), |(low, high), x| (low.min(*x), high.max(*x)));
    let extent = low.distance(high);
    let mut motion = fit(from, to, weights, false)?;
    let mut tolerance = TOLERANCES[0] * extent;
    let mut reweighted = weights.to_vec();
    loop {
        for _ in 0..ITERATIONS {
            for (((w, before), a), b) in reweighted.iter_mut().zip(weights).zip(from).zip(to) {
                let ratio = motion.apply(*a).distance(*b) / tolerance;
                *w = before / (1.0 + ratio * ratio).powi(2);
            }
            motion = fit(from, to, &reweighted, false)?;
        }
        let next = SHRINK * tolerance;
        if next < TOLERANCES[1] * extent || share(&motion, from, to, weights, next) < LEAST {
            return Some(RigidInliers { motion, tolerance });
        }
        tolerance = next;
    }
}
