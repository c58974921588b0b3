//! Conformance: what a device computes, compared stage by stage with the kernels' `f64` twin.
//!
//! [`run`] gives each kernel's twin the inputs that the device's kernel had, so that a difference is pinned to
//! one kernel and may be no larger than the rounding of that kernel alone ([`mod@reference`]).
#![forbid(unsafe_code)]

mod case;
mod compare;
mod numbers;
pub mod reference;
mod run;
mod twin;

pub use case::{Case, cases};
pub use compare::{Difference, worst_difference};
pub use numbers::Numbers;
pub use run::{StageResult, run};
pub use twin::{Results, evaluate};
