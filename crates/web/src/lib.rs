//! Rhytid in a browser, on WebGPU: so far the conformance suite as a page. `cargo xtask web` builds it into a folder that any static host
//! serves; `pages/` has what else is in there.
//!
//! What needs no browser is compiled, and tested, everywhere; `browser::conform`, which the page calls, in browsers alone.

#[cfg(target_arch = "wasm32")]
pub mod browser;
pub mod face;
pub mod page;
