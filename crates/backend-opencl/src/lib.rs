//! The OpenCL backend: every device of every platform that compiles OpenCL C 1.2.
//!
//! The `OpenCL` library, the *ICD loader*, is linked when a program is: on Debian `ocl-icd-opencl-dev` has it for
//! building and `ocl-icd-libopencl1` for running; on Windows GPU drivers and their SDKs bring it along. This library
//! alone compiles without. The loader finds the drivers when the program runs, and there may be none: then
//! [`Backend::devices`](rhytid_core::Backend::devices) is empty.
//!
//! Of `ocl` the bindings to the C functions are used. Its wrappers, those of `ocl::core` too, panic on what happens
//! in the field: a status that they do not know, an object that cannot be released since its device is gone. They
//! take a failed build without a log for a success, and where there is no platform they wait for one. `cl.rs` is the
//! small part of OpenCL that is needed here, without any of that.
#![allow(unsafe_code, reason = "OpenCL is a C interface")]

mod cl;
mod device;
mod session;
mod status;
#[cfg(test)]
mod tests;

pub use device::OpenCl;
pub use session::OpenClSession;
