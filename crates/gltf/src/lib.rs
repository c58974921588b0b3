//! Writes animations and shapes as glTF 2.0 with morph targets, and reads back such files. (`rhytid-meshes`
//! reads the meshes of other programs.)

#![forbid(unsafe_code)]

mod attributes;
pub mod meshopt;
mod node;
pub mod read;
pub mod write;

pub use attributes::{Attribute, carries};
pub use node::local_transform;
