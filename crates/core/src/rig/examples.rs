//! The examples that a rig was solved from.
use super::number;
use crate::Table;
use rhytid_kernels::Real;

/// P examples.
#[derive(Debug, Clone, PartialEq)]
pub struct Examples<T: Real = f32> {
    /// P names.
    pub names: Vec<String>,
    /// P×H positions of the handles, in mesh units. Evaluating them reproduces the examples.
    pub handles: Table<[T; 3]>,
}

impl<T: Real> Examples<T> {
    /// P.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    pub(super) fn cast<U: Real>(&self) -> Examples<U> {
        Examples { names: self.names.clone(), handles: self.handles.map(|x| x.map(number)) }
    }
}
