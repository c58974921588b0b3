//! Registration of point sets: robust rigid motions and similarities between points that belong together, and
//! points laid over a surface without known places.
mod onto_surface;
mod rigid_inliers;
mod similarity;

pub use onto_surface::{OntoSurface, Start, onto_surface};
pub use rigid_inliers::{RigidInliers, rigid_inliers};
pub use similarity::{Similarity, fit, fit_robustly};

use glam::DVec3;

/// Whether a point was seen; NaN stands for a point that was not.
fn seen(position: DVec3) -> bool {
    !position.is_nan()
}
