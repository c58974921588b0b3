//! The wgpu backend: one set of kernels (WGSL) on Vulkan, Metal, Direct3D 12, OpenGL ES and, in browsers,
//! WebGPU, within WebGPU's default limits.
//!
//! A host application that renders with wgpu can lend its own device ([`Wgpu::from_device`]). It then draws
//! with the buffers of the results ([`WgpuSession::results`]), without a copy. Browsers do not allow waiting.
//! There, a device is opened with [`Wgpu::request`], and results are read with [`WgpuSession::read_async`].
//!
//! ```
//! use rhytid_backend_wgpu::Wgpu;
//! use rhytid_core::{Animator, Backend, Stage, UploadOptions};
//!
//! # let rig = rhytid_test_support::triangle();
//! // `rig` is a triangle: its first vertex is a handle, the second follows it half the way, and the third stays.
//! for info in Wgpu::devices()? {
//!     println!("{}: {}", info.id(), info.name);
//! }
//! if let Some(info) = Wgpu::devices()?.into_iter().next() {
//!     let mut animator = Animator::new(&Wgpu::open(&info)?, &rig, UploadOptions::frames(1))?;
//!     animator.evaluate(&[0.0, 0.0, 2.0])?;
//!     let mut positions = Vec::new();
//!     animator.read(Stage::Positions, &mut positions)?;
//!     assert_eq!(positions, [0.0, 0.0, 2.0, 4.0, 0.0, 1.0, 0.0, 4.0, 0.0]);
//! }
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod device;
mod faults;
mod gpu;
mod limits;
mod session;
#[cfg(test)]
mod tests;

pub use device::Wgpu;
pub use session::WgpuSession;
