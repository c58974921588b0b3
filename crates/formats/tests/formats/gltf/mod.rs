//! glTF out, read back by others: Khronos' validator, three.js' decoder of compressed buffers and, for the
//! numbers themselves, the `gltf` crate and plain arithmetic in `f64`. And in again, by the reader that
//! `rhytid verify` uses. The programs come from `cargo xtask setup`.

mod cases;
mod damaged;
mod files;
mod limits;
mod motion;
mod reader;
mod shapes;
mod surface;
pub(crate) mod textures;
mod tools;
mod validator;
mod viewer;

pub(crate) use tools::node;
pub(crate) use validator::assert_valid;
