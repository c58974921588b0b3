//! glTF 2.0 out, and what was written back in: animations and shapes as morph targets. (Other people's meshes are read
//! by `rhytid-meshes`.)

#![forbid(unsafe_code)]

mod attributes;
mod meshopt;
mod node;
pub mod read;
pub mod write;

pub use attributes::{Attribute, carries};
pub use node::local_transform;
