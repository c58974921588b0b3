//! USD: one description of a layer ([`layer`]), written as text or binary ([`mod@write`]) and read back
//! ([`read`]). Animations in parts are put together ([`stitch()`]), and levels of detail become variants
//! ([`levels()`]).

#![forbid(unsafe_code)]

mod build;
mod channels;
mod compare;
pub mod layer;
mod levels;
pub mod read;
mod stitch;
pub mod write;

pub use levels::{Levels, levels};
pub use stitch::{Stitched, stitch};
