//! What comes in and goes out of Rhytid: meshes ([`mesh`]), tables of handles and strain edges ([`tables`]),
//! takes ([`take`]), capture files ([`raw_take`]), the project file ([`project`]) and the exporters ([`export`]).
#![forbid(unsafe_code)]

pub mod export;
mod gltf;
pub mod mesh;
pub mod project;
pub mod raw_take;
pub mod recording;
pub mod tables;
pub mod take;
pub mod usd;
