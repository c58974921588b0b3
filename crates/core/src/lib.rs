//! The heart of Rhytid: everything that is needed to play a rig. It has the data: [`Rig`], its file in
//! [`rig_file`], and [`Take`]. It has the traits by which any device evaluates a rig: [`Backend`],
//! [`Session`] and [`Animator`]. And it has [`Face`], the data from which `rhytid-solve` makes a rig.
//!
//! It has no unsafe code, no GPU code, no solver, and no file format except the rig's own.
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
mod band_weights;
pub mod buffer_ring;
pub mod channel;
mod clustered_basis;
mod contact;
mod error;
mod explain;
mod face;
#[cfg(target_arch = "wasm32")]
mod held_files;
mod horn;
pub mod human;
mod ids;
pub mod input_file;
mod learned;
mod level;
mod listed;
mod materials;
mod mesh;
mod missing;
mod named_file;
pub mod numbers;
pub mod openings;
mod outputs;
mod pixels;
pub mod plan;
mod progress;
mod protected;
mod raw_take;
mod remedy;
mod rig;
mod rig_check;
pub mod rig_file;
mod rig_part;
mod rig_rows;
mod rigid;
mod rotations;
mod rounded;
pub mod scale;
mod steady_file;
mod surface_point;
mod table;
mod take;
mod temporary;
pub mod text;
mod units;

pub use animator::Animator;
pub use atomic_file::AtomicFile;
pub use backend::{
    Backend, BasisStorage, Device, DeviceInfo, DeviceKind, HandleFrames, Session, Stage, UploadOptions,
};
pub use band_weights::{BandWeights, TileVectors};
pub use channel::{Channel, ChannelKind};
pub use clustered_basis::{Cluster, ClusteredBasis};
pub use contact::{Contact, Eyeball, LidVertex};
pub use error::DeviceErrorKind;
pub use error::Error;
pub use error::InputError;
pub use error::InputErrorKind;
pub use error::Result;
pub use explain::EdgeShare;
pub use explain::ExampleShare;
pub use explain::Explanation;
pub use explain::HandleShare;
pub use face::{
    Bind, ContactSettings, Example, Face, Handles, LearnedSettings, Method, Pins, Prior, Settings,
    StrainEdges, WrinkleStrains,
};
#[cfg(target_arch = "wasm32")]
pub use held_files::HeldFile;
pub use horn::Horn;
pub use horn::horn;
pub use horn::nearest_turn;
pub use ids::HandleId;
pub use ids::StrainEdgeId;
pub use ids::VertexId;
pub use learned::Learned;
pub use level::{Level, LevelCorner, LevelTriangle};
pub use materials::{Look, Material, Materials, StatedLook, Texture, TextureFormat, Tissue, Transparency};
pub use mesh::{Faces, Mesh, UpAxis, Uvs};
pub use missing::Missing;
pub use named_file::{Reach, folder_of, is_below, named_file, named_folder, named_output};
pub use openings::{Openings, RimFollower, RimVertex};
pub use outputs::refuse_inputs;
pub use pixels::{MOST_PIXELS, check_palette, check_pixels, set_most_pixels};
pub use progress::{NoProgress, Progress};
pub use protected::protect_inputs;
pub use raw_take::{RawTake, Recording, TakeEvent, Timecode};
pub use remedy::Remedy;
pub use remedy::Warning;
pub use rig::Examples;
pub use rig::FineScale;
pub use rig::HandleSet;
pub use rig::Influences;
pub use rig::MOST_AROUND_JOINED;
pub use rig::Motions;
pub use rig::Rig;
pub use rig::RigParts;
pub use rig::Surface;
pub use rigid::RigidMotion;
pub use rotations::Rotations;
pub use surface_point::SurfacePoint;
pub use table::Table;
pub use take::Take;
pub use units::LengthUnit;
