//! The strain edges that influence each vertex of a rig.
use super::number;
use crate::{StrainEdgeId, Table};
use rhytid_kernels::Real;

/// K influences of each of V vertices (section 4).
#[derive(Debug, Clone, PartialEq)]
pub struct Influences<T: Real = f32> {
    /// V×K strain edges, ascending in each row.
    pub edges: Table<StrainEdgeId>,
    /// α, V×K in [0, 1].
    pub weights: Table<T>,
    /// β in 1/mesh unit. 0 where F ≤ K, and in the learned method, where each vertex has its own.
    pub beta: f64,
}

impl<T: Real> Influences<T> {
    /// K.
    pub fn per_vertex(&self) -> usize {
        self.edges.columns()
    }

    /// The influences of vertex `v`: strain edges and α.
    pub fn at(&self, v: usize) -> impl Iterator<Item = (StrainEdgeId, T)> + Clone {
        self.edges.row(v).iter().copied().zip(self.weights.row(v).iter().copied())
    }

    pub(super) fn cast<U: Real>(&self) -> Influences<U> {
        Influences { edges: self.edges.clone(), weights: self.weights.map(|x| number(*x)), beta: self.beta }
    }
}
