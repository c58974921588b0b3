//! The four runtime kernels of Rhytid, one folder each: the maths and the buffers (`README.md`), the
//! parameter block shared by every backend, and a plain Rust *twin* that is the reference for all of them.
//!
//! The twins are generic over [`Real`]: in `f64` they are the reference that conformance compares devices
//! with; in `f32` they say in which order a device adds up.

pub mod fine_scale;
pub mod large_scale;
pub mod normals;
mod real;
pub mod strain;
pub mod vec3;

pub use real::Real;
