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
