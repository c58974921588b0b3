//! The rigid motion between two states of a body of which only some part is still: a head with another expression.
use super::similarity::{Similarity, fit};
use glam::DVec3;

/// The tolerance with which the search begins and the one with which it ends, in parts of the points' extent: from centimetres of a head
/// to hundredths of a millimetre.
const TOLERANCES: [f64; 2] = [0.05, 5e-5];

/// Each tolerance is this part of the one before.
const SHRINK: f64 = 0.7;

/// Fits with one tolerance.
const ITERATIONS: usize = 12;

/// The tolerance stops where less than this part of the points' weight would stay.
const LEAST: f64 = 0.1;

/// What stays of two states of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Still {
    /// Takes the first state to the second, with scale 1.
    pub motion: Similarity,
    /// The last tolerance, in the points' unit: how near what stays comes.
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

/// The rigid motion from `from` to `to`, N points each with a weight of 0 or more, by the largest part of them that moves as one: fits
/// reweighted by Geman and McClure's function, with a tolerance that shrinks (Black and Rangarajan's graduated non-convexity) as long as a
/// tenth of the weight is within it. `None` where the points have no rigid fit: less than three, or on a line.
///
/// ```
/// # use glam::{DQuat, DVec3};
/// let body: Vec<DVec3> = (0..200).map(|i| DVec3::new(f64::from(i % 7), f64::from(i % 11), f64::from(i % 13))).collect();
/// let turn = DQuat::from_rotation_y(0.1);
/// // Two thirds of it do something else besides.
/// let moved = |(i, x): (usize, &DVec3)| turn * *x + if i % 3 > 0 { DVec3::splat(0.01 * i as f64) } else { DVec3::ZERO };
/// let after: Vec<DVec3> = body.iter().enumerate().map(moved).collect();
/// let still = rhytid_geometry::registration::what_stays(&body, &after, &[1.0; 200]).unwrap();
/// assert!(still.motion.rotation.angle_between(turn) < 1e-6);
/// ```
pub fn what_stays(from: &[DVec3], to: &[DVec3], weights: &[f64]) -> Option<Still> {
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
            return Some(Still { motion, tolerance });
        }
        tolerance = next;
    }
}
