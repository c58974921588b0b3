//! What all exporters promise, and USD read back by its own library. (glTF is read back in `tests/gltf`.)
//! The programs come from `cargo xtask setup`.

mod animation;
mod common;
mod usd;
mod usd_layers;
mod usd_shapes;
