//! The runtime kernels of Rhytid, one folder each: the maths and the buffers (`README.md`), the parameter block
//! shared by every backend, a plain Rust *twin* that is the reference for all of them, and the same kernel in GLSL
//! (`NAME.comp`, and the SPIR-V made from it), OpenCL C (`NAME.cl`) and WGSL (`NAME.wgsl`). [`table`] says what all
//! languages must have in common.
//!
//! The twins are generic over [`Real`]: in `f64` they are the reference that conformance compares devices
//! with; in `f32` they say in which order a device adds up.

pub mod detail;
pub mod differences;
pub mod fine_scale;
pub mod large_scale;
pub mod normals;
mod number;
mod params;
mod real;
pub mod strain;
pub mod table;
pub mod vec3;

pub use number::Number;
pub use real::Real;
