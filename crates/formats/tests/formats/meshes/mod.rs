//! Meshes in, through public functions alone.

mod garbage;
mod gltf;
mod like;
mod obj;
mod obj_round_trip;
mod ply;
mod points;
mod shapes;
mod shared;
mod support;
