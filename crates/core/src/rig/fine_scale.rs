//! The fine scale of a rig: its wrinkles.
use super::number;
use crate::Table;
use rhytid_kernels::Real;

/// The wrinkles as radial basis functions of N centres.
#[derive(Debug, Clone, PartialEq)]
pub struct FineScale<T: Real = f32> {
    /// f_j, N×F strains of the centres (section 6); row 0 is zero.
    pub pose_features: Table<T>,
    /// w, V×N of 3 (section 7), in mesh units. With the learned method, the first vector of each vertex, the
    /// rest pose's, is b.
    pub rbf_weights: Table<[T; 3]>,
}

impl<T: Real> FineScale<T> {
    pub(super) fn cast<U: Real>(&self) -> FineScale<U> {
        FineScale {
            pose_features: self.pose_features.map(|x| number(*x)),
            rbf_weights: self.rbf_weights.map(|w| w.map(number)),
        }
    }
}
