//! Point sets laid over each other: the rigid motion or similarity between points that belong together, robustly; and points that belong to
//! a surface, nobody knows where.
//!
//! ```
//! use glam::{DQuat, DVec3};
//! use rhytid_registration::{Similarity, fit_robustly};
//!
//! let from = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.0], [1.0, 1.0, 1.0]].map(DVec3::from_array);
//! let motion = Similarity { scale: 1.0, rotation: DQuat::from_rotation_z(0.5), translation: DVec3::new(1.0, 2.0, 3.0) };
//! let mut to = from.map(|x| motion.apply(x));
//! to[4] += DVec3::X; // what moved by itself
//! let (found, _) = fit_robustly(&from, &to, false, 0.01).unwrap();
//! assert!(found.rotation.angle_between(motion.rotation) < 1e-3);
//! ```
#![forbid(unsafe_code)]

mod onto_surface;
mod similarity;
mod still;
mod surface;

pub use onto_surface::{OntoSurface, Start, onto_surface};
pub use similarity::{Similarity, fit, fit_robustly};
pub use still::{Still, what_stays};
pub use surface::{Closest, Surface};

use glam::DVec3;

/// Whether a point is one: NaN stands for what was not seen.
fn seen(position: DVec3) -> bool {
    !position.is_nan()
}

/// The median of numbers, which are put in another order; NaN where there is none.
fn median_of(numbers: &mut [f64]) -> f64 {
    let (middle, is_odd) = (numbers.len() / 2, numbers.len() % 2 == 1);
    if numbers.is_empty() {
        return f64::NAN;
    }
    let (below, &mut upper, _) = numbers.select_nth_unstable_by(middle, f64::total_cmp);
    if is_odd {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}
