//! What is told of a device is true, whatever is evaluated agrees with the CPU backend, and failures are errors.
mod agreement;
mod failures;
mod memory;
mod oclgrind;
pub(crate) mod support;
