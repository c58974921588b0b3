//! The heart of Rhytid, all that plays a rig needs: the data ([`Rig`], its file in [`rig_file`], [`Take`]), and the traits by
//! which any device evaluates a rig ([`Backend`], [`Session`], [`Animator`]); and [`Face`], the data that `rhytid-solve` makes
//! a rig of.
//!
//! No unsafe code, no GPU, no solver, and no file format but the rig's own.
//!
//! ```
//! use rhytid_core::Take;
//!
//! // One marker that rises 3 units in a tenth of a second, at 10 frames a second; then at 30.
//! let take = Take {
//!     labels: vec!["chin".into()],
//!     times: vec![0.0, 0.1],
//!     positions: vec![[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
//!     ..Take::default()
//! };
//! let fine = take.resample(30.0)?;
//! assert_eq!(fine.frames(), 4);
//! assert!((fine.positions[1][1] - 1.0).abs() < 1e-9);
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod animator;
mod atomic_file;
mod backend;
pub mod buffer_ring;
pub mod channel;
mod error;
mod explain;
mod face;
pub mod human;
mod ids;
pub mod input_file;
pub mod laplacian;
mod learned;
mod mesh;
pub mod plan;
mod progress;
mod raw_take;
mod rig;
mod rig_check;
pub mod rig_file;
mod rig_part;
mod rigid;
mod rotations;
mod steady_file;
mod strain_gauge;
mod table;
mod take;
mod temporary;

pub use animator::Animator;
pub use atomic_file::AtomicFile;
pub use backend::{
    Backend, BasisStorage, Device, DeviceInfo, DeviceKind, HandleFrames, Session, Stage, UploadOptions,
};
pub use channel::{Channel, ChannelKind};
pub use error::{DeviceErrorKind, Error, Result};
pub use explain::{EdgeShare, ExampleShare, Explanation, HandleShare};
pub use face::{
    Bind, Example, Face, FoldStrains, Handles, LearnedSettings, Method, Pins, Settings, StrainEdges,
};
pub use ids::{HandleId, StrainEdgeId, VertexId};
pub use learned::Learned;
pub use mesh::{Faces, Materials, Mesh, UpAxis, Uvs};
pub use progress::{NoProgress, Progress};
pub use raw_take::RawTake;
pub use rig::{Examples, FineScale, HandleSet, Influences, Motions, Rig, RigParts, Surface};
pub use rigid::RigidMotion;
pub use rotations::{Rotations, nearest_turn};
pub use strain_gauge::{PrincipalStrains, StrainGauge};
pub use table::Table;
pub use take::Take;
