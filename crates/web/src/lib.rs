//! Rhytid in a browser, on WebGPU: the viewer and the conformance suite as pages. `cargo xtask web` builds
//! them into a folder that any static host serves. `pages/` has the other files of that folder.
//!
//! Code that needs no browser is compiled and tested everywhere. `browser::conform` and `viewer::view`, which
//! the pages call, are compiled for browsers alone.

#[cfg(target_arch = "wasm32")]
pub mod browser;
pub mod face;
pub mod page;
#[cfg(target_arch = "wasm32")]
pub mod viewer;
