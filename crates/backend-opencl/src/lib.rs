//! The OpenCL backend: every device of every platform that compiles OpenCL C 1.2.
//!
//! Nothing is linked. The `OpenCL` library, the *ICD loader*, is searched for when the program asks for
//! devices. GPU drivers bring it along, or the system has it (Debian: `ocl-icd-libopencl1`). The loader finds
//! the drivers. Without a loader or without a driver, [`Backend::devices`](rhytid_core::Backend::devices) is
//! empty. [`has_loader`] tells which of the two is missing.
//!
//! ```
//! use rhytid_backend_opencl::{OpenCl, has_loader};
//! use rhytid_core::Backend;
//!
//! let devices = OpenCl::devices()?;
//! for device in &devices {
//!     println!("{}: {}, {}", device.id(), device.name, device.driver);
//! }
//! assert!(has_loader() || devices.is_empty());
//! # Ok::<(), rhytid_core::Error>(())
//! ```
//!
//! `opencl-sys` has OpenCL's types, constants and the functions' signatures. `loader.rs` finds the functions.
//! `cl.rs` is the small part of OpenCL that this backend needs.
#![allow(unsafe_code, reason = "OpenCL is a C interface")]

mod cl;
mod device;
mod loader;
mod session;
mod status;
#[cfg(test)]
mod tests;

pub use device::OpenCl;
pub use loader::has_loader;
pub use session::OpenClSession;
