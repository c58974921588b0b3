//! Helpers that the tests of several crates share.
//!
//! They are skips, the data beside the project, small faces, and the programs that `cargo xtask setup`
//! installs. There are also readings of `/proc`, the log, and a device that fails.
#![forbid(unsafe_code)]

mod data;
pub mod eye;
pub mod flaky;
mod glb;
pub mod lips;
mod logged;
mod memory;
pub mod points;
mod rigs;
pub mod sheet;
mod skip;
pub mod split;

pub use data::{installed, python, python_usd_24_3, root, shared};
pub use glb::glb;
pub use logged::Logged;
pub use memory::{peak, peak_of, processor_seconds, resident};
pub use rigs::{changed, triangle};
pub use skip::{FORBID_SKIPS, skip};
