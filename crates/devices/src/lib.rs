//! Devices: the list of backends, which device to take, and what is done when one fails.
//!
//! [`backends`] lists what is there and opens it, no more: all that a game needs. The rest is the feature `choose`:
//! [`choose_devices`] tries devices in child processes, and orders those that compute what the reference does by their speed. An
//! [`Evaluator`] goes on with the next device when one fails, and watches each by a [`Watch`].
//!
//! ```
//! use rhytid_core::NoProgress;
//! use rhytid_devices::{Guard, choose_devices};
//!
//! // Or "auto": all that conform, the fastest first.
//! let choice = choose_devices("cpu:0", Guard::NONE, &NoProgress)?;
//! assert_eq!(choice.devices[0].backend, "cpu");
//! # Ok::<(), rhytid_core::Error>(())
//! ```
//!
//! Each backend's own types, for hosts that hand in their device or take its buffers, are in the module of its name.
#![forbid(unsafe_code)]

#[cfg(feature = "cpu")]
pub use rhytid_backend_cpu as cpu;
#[cfg(feature = "opencl")]
pub use rhytid_backend_opencl as opencl;
#[cfg(feature = "vulkan")]
pub use rhytid_backend_vulkan as vulkan;
#[cfg(feature = "wgpu")]
pub use rhytid_backend_wgpu as wgpu;

pub mod backends;
#[cfg(feature = "choose")]
mod choose;
#[cfg(feature = "choose")]
mod evaluator;
#[cfg(feature = "choose")]
mod guard;
#[cfg(feature = "choose")]
mod listing;
#[cfg(feature = "choose")]
mod manifests;
#[cfg(feature = "choose")]
mod trial;
#[cfg(feature = "choose")]
mod watch;

#[cfg(feature = "choose")]
pub use choose::{Choice, choose_devices, devices, find_device};
#[cfg(feature = "choose")]
pub use evaluator::{Evaluator, Open};
#[cfg(feature = "choose")]
pub use guard::{Guard, PATIENCE, Signs};
#[cfg(feature = "choose")]
pub use listing::answer;
#[cfg(feature = "choose")]
pub use watch::Watch;
