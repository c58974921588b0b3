//! Conformance: what a device computes, compared stage by stage with the kernels' `f64` twin.
#![forbid(unsafe_code)]

mod compare;
mod twin;

pub use compare::{Difference, worst_difference};
pub use twin::{Results, evaluate};
