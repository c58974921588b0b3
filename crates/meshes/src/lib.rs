//! Meshes in: OBJ, PLY, glTF and USD, told apart by their file names. See docs/meshes.md.
//!
//! Polygons, vertex order, texture coordinates and the names of materials are kept as the file has them. No
//! reader panics on any bytes, and none allocates more than a small multiple of them.

#![forbid(unsafe_code)]

mod by_corners;
mod check;
mod displacement;
mod gltf;
mod groups;
mod like;
mod looks;
mod map_image;
mod materials;
mod normal_map;
mod numbers;
mod obj;
mod ply;
mod read;
mod recognise;
mod shape_groups;
mod shapes;
mod text;
mod usd;
mod uvs;
mod weights;
mod write_obj;

pub use check::check;
pub use displacement::DisplacementMap;
pub use groups::{groups_of, read_groups};
pub use like::{Order, like, order, read_like};
pub use looks::{Looks, read_looks};
pub use normal_map::{Integrated, NormalMap, NormalMapConvention};
pub use numbers::{Numbers, decode_numbers, read_numbers, write_numbers};
pub use read::{Format, Selection, decode, read, read_file};
pub use shape_groups::{ALIKE, ShapeGroup, likeness, shape_groups};
pub use shapes::{MeshPart, Shape, Shapes, Space, has_shapes, read_shapes};
pub use weights::read_weights;
pub use write_obj::write_obj;
