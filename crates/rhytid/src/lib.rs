//! Rhytid: from face scans and marker tracks to detailed facial animation, on any vendor's GPU or on none.
//!
//! A face is solved once, offline, into a [`Rig`]. The rig is uploaded once to a device. After that, only
//! marker positions are sent to the device. The result is every vertex of the face with its wrinkles. It is
//! read from the device, or stays there as vertex buffers.
//!
//! # A take into a file
//!
//! ```no_run
//! # fn main() -> rhytid::Result<()> {
//! use rhytid::{AnimateOptions, NoProgress, TakeOptions};
//!
//! // Once per face.
//! let face = rhytid::open_face("face.toml")?;
//! let rig = rhytid::solve(&face, &NoProgress)?;
//! rhytid::write_rig("face.safetensors", &rig)?;
//!
//! // Once per take: a clean one, or as a capture system wrote it.
//! let take = rhytid::open_take("take.csv", &rig, &TakeOptions::default())?;
//! rhytid::animate(rig, take, "face.usd", &AnimateOptions::default())?;
//! # Ok(())
//! # }
//! ```
//!
//! Options change the defaults:
//!
//! ```no_run
//! # fn main() -> rhytid::Result<()> {
//! # let rig = rhytid::open_rig("face.safetensors")?;
//! # let take = rhytid::open_take("take.csv", &rig, &rhytid::TakeOptions::default())?;
//! use rhytid::{AnimateOptions, Recipe};
//!
//! let recipe = Recipe { fps: Some(24.0), detail: 0.8, ..Recipe::default() };
//! let options = AnimateOptions { recipe, device: "vulkan:0", ..AnimateOptions::default() };
//! rhytid::animate(rig, take, "face.glb", &options)?;
//! # Ok(())
//! # }
//! ```
//!
//! # A game
//!
//! A program that draws the face itself holds an [`Animator`]: positions of handles in, any [`Stage`] out.
//!
//! ```
//! use rhytid::{AnimatorOptions, Stage};
//!
//! # let face = rhytid_demo::face(1_000);
//! # let rig = rhytid::solve(&face, &rhytid::NoProgress)?;
//! // let rig = rhytid::open_rig("face.safetensors")?;
//! let options = AnimatorOptions { device: Some("cpu:0"), ..AnimatorOptions::default() };
//! let mut animator = rhytid::animator(&rig, &options)?;
//! let mut handles = rig.handles().rest.clone();
//! let mut positions = Vec::new();
//! for frame in 0..3 {
//!     // The first handle rises.
//!     handles[0][1] += 0.1;
//!     animator.evaluate(handles.as_flattened())?;
//!     animator.read(Stage::Positions, &mut positions)?;
//! }
//! assert_eq!(positions.len(), 3 * rig.vertices());
//! # Ok::<(), rhytid::Error>(())
//! ```
//!
//! On a GPU, results need not be read: each backend's session gives access to its buffers ([`devices`]).
//!
//! # What is where
//!
//! The root has what most programs need. All else is in a module for each task:
//!
//! | module | contents |
//! | --- | --- |
//! | [`core`] | the data and the traits that everything stands on: meshes, settings, channels, backends, sessions |
//! | [`devices`] | the backends; which device to take; what happens when one fails |
//! | [`mod@solve`], [`geometry`] | scans to a rig, the doctor; the algorithms on meshes |
//! | [`formats`] | every file that is read or written |
//! | [`capture`], [`live`] | raw takes cleaned; markers over the network |
//! | [`playback`] | frames one by one, edits, channels, comparison of a file with a fresh evaluation |
//! | [`evaluate`](mod@evaluate), [`report`], [`transfer`] | the quality of a rig; pages of results; transfer of wrinkles to another face |
//! | [`render`], [`view`] | pictures and films; the window |
//! | [`conformance`] | devices against a float64 reference |
//!
//! # Errors
//!
//! Every error says in one sentence what is wrong and what to do. A program matches on the kind of error
//! instead of reading the text:
//!
//! ```
//! use rhytid::Error;
//!
//! match rhytid::open_rig("not-there.safetensors") {
//!     Err(Error::Io { path, .. }) => println!("choose another file than {}", path.display()),
//!     Err(error) => println!("{error}"),
//!     Ok(rig) => println!("{} vertices", rig.vertices()),
//! }
//! ```
//!
//! # Features
//!
//! All but `film` and `view` are on by default. `default-features = false` with a single backend is the
//! runtime for a game. It has no solver, no file format but the rig's, and nothing else that is needed only
//! offline.
//!
//! | feature | what it adds |
//! | --- | --- |
//! | `cpu`, `vulkan`, `opencl`, `wgpu` | that backend, in [`devices`] |
//! | `solve` | scans to a rig, and the doctor: [`solve`](mod@solve) |
//! | `formats` | meshes, takes, capture files, project files in; USD and glTF out and in: [`formats`] |
//! | `capture` | from a raw take to a clean one: [`capture`] |
//! | `playback` | a take on a rig, with overlap, fall-back and choice of device: [`playback`] |
//! | `evaluate` | how good a rig is and where not, which scans to make: [`evaluate`](mod@evaluate) |
//! | `render` | pictures: shaded, as wire, heat maps; with the backend `wgpu`: [`render`] |
//! | `film` | pictures as films, off by default: [`render::Film`] |
//! | `live` | marker positions over the network while they are captured: [`live`] |
//! | `view` | a window on a rig, in which markers are dragged, off by default: [`view`] |
//! | `transfer` | the wrinkles of one face on another one with another mesh: [`transfer`] |
//! | `report` | pages of clean-ups, evaluations, plans and transfers, with pictures if `render` is on: [`report`] |
//! | `conformance` | devices against a float64 reference: [`conformance`] |
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[cfg(feature = "playback")]
mod animate;
mod animator;
mod open;

#[cfg(feature = "playback")]
pub use animate::{AnimateOptions, animate};
pub use animator::{AnimatorOptions, animator};
#[cfg(feature = "formats")]
pub use open::open_face;
#[cfg(feature = "playback")]
pub use open::{TakeOptions, open_take};
pub use open::{open_rig, write_rig};

pub use rhytid_core::{
    Animator, BandWeights, BasisStorage, ClusteredBasis, DeviceErrorKind, Error, Face, InputError,
    InputErrorKind, Missing, NoProgress, Progress, Result, Rig, Session, Stage, Take, UploadOptions,
};
#[cfg(feature = "formats")]
pub use rhytid_formats::export::Recipe;

/// Solves a face: the rig that animates it.
///
/// A solve takes seconds: under fifteen for 530,000 vertices on two cores. It reports to `progress`, and
/// stops when that says so. [`solve::solve`](solve::solve()) gives the rig before it is rounded to float32,
/// and [`solve::solve_in_full`] also a report.
///
/// # Errors
/// [`Error::Input`] with the first error that [`solve::examine`] finds; [`Error::Cancelled`].
#[cfg(feature = "solve")]
pub fn solve(face: &Face, progress: &dyn Progress) -> Result<Rig> {
    rhytid_solve::solve(face, progress)?.rounded()
}

#[doc(inline)]
pub use rhytid_core as core;

#[cfg(feature = "capture")]
#[doc(inline)]
pub use rhytid_capture as capture;
#[cfg(feature = "conformance")]
#[doc(inline)]
pub use rhytid_conformance as conformance;
#[doc(inline)]
pub use rhytid_devices as devices;
#[cfg(feature = "evaluate")]
#[doc(inline)]
pub use rhytid_evaluate as evaluate;
#[cfg(feature = "formats")]
#[doc(inline)]
pub use rhytid_formats as formats;
#[cfg(feature = "geometry")]
#[doc(inline)]
pub use rhytid_geometry as geometry;
#[cfg(feature = "live")]
#[doc(inline)]
pub use rhytid_live as live;
#[cfg(feature = "playback")]
#[doc(inline)]
pub use rhytid_playback as playback;
#[cfg(feature = "render")]
#[doc(inline)]
pub use rhytid_render as render;
#[cfg(feature = "report")]
#[doc(inline)]
pub use rhytid_report as report;
#[cfg(feature = "solve")]
#[doc(inline)]
pub use rhytid_solve as solve;
#[cfg(feature = "transfer")]
#[doc(inline)]
pub use rhytid_transfer as transfer;
#[cfg(feature = "view")]
#[doc(inline)]
pub use rhytid_view as view;
