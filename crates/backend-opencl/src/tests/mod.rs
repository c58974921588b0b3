//! Tests on the devices of this machine. The description of a device is true, its results agree with the CPU
//! backend's, and failures are errors.
mod agreement;
mod failures;
mod memory;
mod oclgrind;
pub(crate) mod support;
