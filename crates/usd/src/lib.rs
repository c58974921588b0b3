//! USD: one description of a layer ([`layer`]), written as text or binary ([`mod@write`]) and read back
//! ([`read`]), and animations in parts put together ([`stitch()`]).

#![forbid(unsafe_code)]

mod build;
mod channels;
mod compare;
pub mod layer;
pub mod read;
mod stitch;
pub mod write;

pub use stitch::{Stitched, stitch};
