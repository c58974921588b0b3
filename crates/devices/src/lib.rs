//! Devices: the list of backends, the choice of a device, and fall-back when a device fails.
//!
//! [`backends`] lists devices and opens them. A game needs no more. The rest is the feature `choose`. There,
//! [`choose_devices`] tries devices in child processes. It orders the devices that agree with the reference
//! by their speed. An [`Evaluator`] continues with the next device when one fails, and checks each device by
//! a [`Watch`].
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
//! Each backend's own types are in the module of its name. Hosts need them to lend their device or to use its
//! buffers.
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
pub use choose::{Choice, Reason, choose_devices, devices, find_device};
#[cfg(feature = "choose")]
pub use evaluator::{Evaluator, Open};
#[cfg(feature = "choose")]
pub use guard::{Guard, Heartbeat, PATIENCE};
#[cfg(feature = "choose")]
pub use listing::answer;
#[cfg(feature = "choose")]
pub use watch::Watch;
