//! glTF 2.0 out, and what was written back in: animations and shapes as morph targets. (Other people's meshes are read
//! by [`crate::mesh`].)

pub(crate) mod attributes;
mod meshopt;
pub(crate) mod morphs;
mod node;
pub(crate) mod read;
pub(crate) mod write;

pub(crate) use node::local_transform;
