//! Point sets laid over each other: the rigid motion or similarity between points that belong together, robustly; and points that
//! belong to a surface, nobody knows where.
mod onto_surface;
mod similarity;
mod still;

pub use onto_surface::{OntoSurface, Start, onto_surface};
pub use similarity::{Similarity, fit, fit_robustly};
pub use still::{Still, what_stays};

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
