//! The client `gltf_crate`, an example, reads exports with the crate gltf. `clients.py` runs it beside other
//! clients.
#![forbid(unsafe_code)]
