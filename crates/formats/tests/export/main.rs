//! The exporters, read back by others' readers: USD's own library, the `gltf` crate and Khronos' validator.
//! The programs come from `cargo xtask setup`.

mod animation;
mod common;
mod glb;
mod usda;
