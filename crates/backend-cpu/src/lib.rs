//! The CPU backend: every core, whole batches, and the same bits as the kernels' `f32` references.
//!
//! ```
//! use rhytid_backend_cpu::Cpu;
//! use rhytid_core::{Animator, Backend, Stage, UploadOptions};
//!
//! # let rig = rhytid_test_support::triangle();
//! // `rig` is a triangle: its first vertex is a handle, the second follows it half the way, and the third stays.
//! for info in Cpu::devices()? {
//!     println!("{}: {}", info.id(), info.name);
//! }
//! if let Some(info) = Cpu::devices()?.into_iter().next() {
//!     let mut animator = Animator::new(&Cpu::open(&info)?, &rig, UploadOptions::frames(1))?;
//!     animator.evaluate(&[0.0, 0.0, 2.0])?;
//!     let mut positions = Vec::new();
//!     animator.read(Stage::Positions, &mut positions)?;
//!     assert_eq!(positions, [0.0, 0.0, 2.0, 4.0, 0.0, 1.0, 0.0, 4.0, 0.0]);
//! }
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod band_weights;
mod bands;
mod beyond;
mod blocks;
mod detail;
mod device;
mod group;
mod group_mesh;
mod lanes;
mod large_scale;
mod lines;
mod mesh;
mod one_frame;
mod prefetch;
mod session;
mod tile_weights;
mod times;
mod uploaded;
mod vectors;

pub use device::Cpu;
pub use session::CpuSession;
