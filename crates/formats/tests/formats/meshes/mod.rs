//! Meshes in, through public functions alone.

mod garbage;
mod gltf;
mod gltf_compressed;
mod gltf_targets;
mod gltf_uvs;
mod like;
mod looks;
mod obj;
mod obj_round_trip;
mod ply;
mod points;
mod shapes;
mod shared;
mod skins;
mod support;
mod usd;
