//! The heart of Rhytid: what a face is ([`Face`]), how it becomes a [`Rig`] ([`solve()`]), and the traits by
//! which any device evaluates one ([`Backend`], [`Session`], [`Animator`]).
//!
//! No unsafe code, no GPU, and no file format but the rig's own ([`rig_file`]).
#![forbid(unsafe_code)]

mod animator;
mod backend;
pub mod buffer_ring;
mod doctor;
mod error;
mod face;
mod mesh;
pub mod plan;
mod progress;
mod raw_take;
mod rig;
mod rig_check;
pub mod rig_file;
mod rigid;
pub mod solve;
mod steady_file;
mod take;
mod topology;
mod triangulate;
mod write_beside;

pub use animator::Animator;
pub use backend::{
    Backend, BasisStorage, Device, DeviceInfo, DeviceKind, HandleFrames, Session, Stage, UploadOptions,
};
pub use doctor::{Finding, Report, Severity, examine};
pub use error::{DeviceErrorKind, Error, Result};
pub use face::{Bind, Example, Face, Handles, Settings, StrainEdges};
pub use mesh::{Faces, Materials, Mesh, UpAxis, Uvs};
pub use progress::{NoProgress, Progress};
pub use raw_take::RawTake;
pub use rig::Rig;
pub use rigid::RigidMotion;
pub use solve::solve;
pub use take::Take;
pub use topology::Topology;
pub use write_beside::WriteBeside;
