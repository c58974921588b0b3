//! What all exporters promise, and USD read back by its own library. (glTF is read back in
//! `tests/formats/gltf`.) The programs come from `cargo xtask setup`.

pub(crate) mod common;
mod usd;
mod usd_baked;
mod usd_layers;
mod usd_looks;
mod usd_place;
mod usd_shapes;
