//! Files in and out of Rhytid, each opened by its extension.
//!
//! These are read: meshes ([`mesh`]), tables of handles and strain edges ([`tables`]), takes ([`take`]),
//! capture files ([`raw_take`]), weights of shapes ([`curves`]), the project file ([`project`]) and edits
//! ([`edits`]). Animations ([`animation`]) are written and read back. Code that the animation formats share
//! is in [`export`]; USD layers are in [`usd`].
//!
//! ```
//! use rhytid_core::{NoProgress, UpAxis};
//! use rhytid_formats::export::{Frame, Options, Scene, StatedRecipe};
//! use rhytid_formats::{animation, mesh};
//!
//! let obj = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let square = mesh::decode(obj, mesh::Format::Obj, "square.obj")?;
//! let rest: Vec<[f32; 3]> = square.positions.iter().map(|p| p.map(|x| x as f32)).collect();
//! let recipe = StatedRecipe::default();
//! let scene = Scene {
//!     name: "square",
//!     rest: &rest,
//!     rest_normals: None,
//!     channels: &[],
//!     faces: &square.faces,
//!     triangle_corners: &[[0, 1, 2], [0, 2, 3]],
//!     uvs: None,
//!     materials: None,
//!     head: None,
//!     metres_per_unit: 0.01,
//!     up_axis: UpAxis::Y,
//!     frames: 2,
//!     rate: 24.0,
//!     first_time_code: 0.0,
//!     recipe: &recipe,
//!     further: &[],
//! };
//! let raised: Vec<f32> = rest.iter().flat_map(|[x, y, z]| [*x, *y, z + 1.0]).collect();
//!
//! # let folder = tempfile::tempdir().unwrap();
//! # let path = folder.path().join("square.usda");
//! # let path = path.as_path();
//! // `path` could as well end in .usd, .usdz, .glb or .gltf.
//! let mut exporter = animation::create(path, &scene, &Options::default())?;
//! for positions in [rest.as_flattened(), &raised] {
//!     exporter.frame(&Frame::new(positions))?;
//! }
//! exporter.finish(&NoProgress)?;
//!
//! let mut reader = animation::open(path)?;
//! assert_eq!(reader.summary().frames, 2);
//! let mut positions = Vec::new();
//! reader.positions(1, &mut positions)?;
//! assert_eq!(positions, raised);
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

pub mod animation;
mod file_kind;
mod npy;
mod pc2;
pub mod sequence;

pub use file_kind::FileKind;
pub use rhytid_core::{Reach, named_file, named_output, refuse_inputs};
pub use rhytid_export as export;
pub use rhytid_meshes as mesh;
pub use rhytid_projects::{edits, project};
pub use rhytid_takes::{curves, raw_take, tables, take};
pub use rhytid_usd as usd;
