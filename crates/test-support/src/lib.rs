//! Help that the tests of several crates share: how one says that it does nothing here, the data beside the project, a small face, the programs that
//! `cargo xtask setup` installs, readings of `/proc`, what was logged, and a device that fails.
#![forbid(unsafe_code)]

mod data;
pub mod flaky;
mod logged;
mod memory;
mod rigs;
pub mod sheet;
mod skip;

pub use data::{installed, python, python_usd_24_3, root, shared};
pub use logged::Logged;
pub use memory::{peak, peak_of, resident};
pub use rigs::{changed, triangle};
pub use skip::{FORBID_SKIPS, skip};
