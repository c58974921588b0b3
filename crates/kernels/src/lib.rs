//! The runtime kernels of Rhytid, one folder each. A folder has the maths and the buffers (`README.md`), the
//! parameter block that every backend shares, and the *reference* in plain Rust. It has the same kernel in
//! GLSL (`NAME.comp`, and the SPIR-V made from it), OpenCL C (`NAME.cl`) and WGSL (`NAME.wgsl`). The module
//! [`table`] says what all languages must have in common.
//!
//! The references are generic over [`Real`]. Conformance compares devices with the reference in `f64`. The
//! reference in `f32` defines the order in which a device adds.
//!
//! ```
//! use rhytid_kernels::strain::{Params, strain};
//! use rhytid_kernels::table::Kernel;
//!
//! // Two handles, 2 apart at rest and 3 apart in a frame: the edge between them is stretched by a half.
//! let rest = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
//! let moved = [[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
//! let mut features = [0.0];
//! let params = Params { frames: 1, handles: 2, strain_edges: 1 };
//! strain(params, &moved, &rest, &[[0, 1]], &[2.0], &mut features);
//! assert_eq!(features, [0.5]);
//!
//! // The same kernel for a GPU: its buffers, in the order in which they are bound.
//! let buffers = Kernel::Strain.entry().bindings.iter().map(|binding| binding.buffer.name());
//! assert_eq!(buffers.last(), Some("features"));
//! ```

pub mod bands;
pub mod beyond;
pub mod clusters;
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
pub mod tile;
pub mod vec3;
pub mod vector_differences;

pub use number::{IS_FUSED, Number};
pub use real::Real;
