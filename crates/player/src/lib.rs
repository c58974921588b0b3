//! The WebAssembly inside `@rhytid/player`, the npm package that draws Rhytid's faces with three.js.
//! `npm/` has the JavaScript of the package. `cargo xtask player` builds the package's folder, and
//! `docs/player.md` is its page.
//!
//! A [`Face`] reads a rig, evaluates it on the processor, and knows how three.js draws it. Where the renderer
//! has WebGPU, a [`DevicePlan`] tells JavaScript which buffers to make and which kernels to run. A [`Track`]
//! is a take for a face. `browser` has what JavaScript calls, and is compiled for browsers alone.

#[cfg(target_arch = "wasm32")]
pub mod browser;
mod device_plan;
mod drawing;
mod face;
mod names;
mod track;

pub use device_plan::{DeviceInput, DevicePlan};
pub use drawing::{Drawing, Group};
pub use face::Face;
pub use names::{basis_named, javascript, kind_of, missing_named, stage_named, types};
pub use track::{HeadPose, Track};
