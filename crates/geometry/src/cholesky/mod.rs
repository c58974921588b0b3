//! Sparse Cholesky factorisation of large symmetric systems on meshes: an order of elimination by the
//! vertices' positions, and the multifrontal method along it.
mod columns;
mod dissection;
mod factor;

pub use columns::Columns;
pub use dissection::{Dissection, Graph, Part, dissect};
pub use factor::Factor;
