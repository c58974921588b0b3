//! The Vulkan backend: any driver of Vulkan 1.1 or later, found when the program runs.
//!
//! A machine without a Vulkan loader or without a driver has no devices, which is no error. The backend needs
//! no feature or extension. It needs no limit above Vulkan 1.1's minimum, except for seven storage buffers in
//! a shader. All known drivers have these.
//!
//! `RHYTID_VULKAN_VALIDATION=1` turns on Khronos' validation layer with synchronization validation. Its
//! messages are then errors.
//!
//! A renderer can lend its own device ([`Vulkan::from_device`]). It then uses the results in their buffers
//! without a copy ([`VulkanSession::result`]). Semaphores synchronise both sides
//! ([`VulkanSession::evaluate_with`]).
//!
//! ```
//! use rhytid_backend_vulkan::Vulkan;
//! use rhytid_core::{Animator, Backend, Stage, UploadOptions};
//!
//! # let rig = rhytid_test_support::triangle();
//! // `rig` is a triangle: its first vertex is a handle, the second follows it half the way, and the third stays.
//! for info in Vulkan::devices()? {
//!     println!("{}: {}", info.id(), info.name);
//! }
//! if let Some(info) = Vulkan::devices()?.into_iter().next() {
//!     let mut animator = Animator::new(&Vulkan::open(&info)?, &rig, UploadOptions::frames(1))?;
//!     animator.evaluate(&[0.0, 0.0, 2.0])?;
//!     let mut positions = Vec::new();
//!     animator.read(Stage::Positions, &mut positions)?;
//!     assert_eq!(positions, [0.0, 0.0, 2.0, 4.0, 0.0, 1.0, 0.0, 4.0, 0.0]);
//! }
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![allow(unsafe_code, reason = "Vulkan's functions are C functions")]

mod barrier;
mod buffer;
mod commands;
mod context;
mod copy;
mod device;
mod error;
mod instance;
mod physical;
mod pipeline;
mod session;
#[cfg(test)]
mod tests;
mod validation;

pub use ash;
pub use device::{HostDevice, Vulkan};
pub use session::{ResultSlice, VulkanSession};
