//! Rhytid: from face scans and marker tracks to detailed facial animation, on any vendor's GPU or on none.
//!
//! A face is solved once, offline, into a [`Rig`]. The rig is uploaded once to a device, and from then on only marker positions
//! cross to it; what comes back, or stays there as vertex buffers, is every vertex of the face with its wrinkles.
//!
//! # A take into a file
//!
//! Scans and a project file become a rig ([`solve`]), the rig and a take an animation ([`playback`]). A device that fails on the
//! way is replaced by the next one.
//!
//! ```no_run
//! use rhytid::formats::export::{Options, Recipe};
//! use rhytid::formats::{Reach, project, take::Missing};
//! use rhytid::playback::{CleanUp, Guard, Performance, choose_devices, read_take};
//! use rhytid::{NoProgress, rig_file};
//! use std::path::Path;
//!
//! # fn main() -> rhytid::Result<()> {
//! // Once per face. Without a solver, rig_file::read gives a rig that was written before.
//! let rig = rhytid::solve::solve(&project::read(Path::new("face.toml"), Reach::Below)?, &NoProgress)?.rounded()?;
//! rig_file::write(Path::new("face.safetensors"), &rig)?;
//!
//! // Once per take, be it clean or as a capture system wrote it.
//! let take = read_take(Path::new("take.csv"), &rig, Missing::Error, &CleanUp::default(), &NoProgress)?;
//! let performance = Performance::new(Recipe::default(), rig, take, None)?;
//! let devices = choose_devices("auto", Guard::NONE, &NoProgress)?.devices;
//! let mut playback = performance.playback(&devices, &NoProgress)?;
//! playback.export(&performance, Path::new("face.usd"), &Options::default(), &NoProgress)?;
//! # Ok(())
//! # }
//! ```
//!
//! # In a host application
//!
//! A game or a tool that draws the face itself holds an [`Animator`]: positions of handles in, any [`Stage`] out. On a GPU
//! nothing needs to come back: each backend's session gives its buffers away ([`backends`]).
//!
//! ```
//! use rhytid::{NoProgress, Stage, UploadOptions, backends};
//!
//! # let face = rhytid_demo::face(1_000);
//! # let rig = rhytid::solve::solve(&face, &NoProgress)?.rounded()?;
//! // `rig` from rhytid::rig_file::read.
//! let device = backends::devices().devices.into_iter().find(|device| device.backend == "cpu").expect("a processor");
//! let mut animator = backends::open(&device)?.upload(&rig, UploadOptions::frames(1))?;
//! // The handles in the order of rig.labels, in mesh units: where they are at rest, but for the first.
//! let mut handles: Vec<f32> = rig.handles.iter().flat_map(|&v| rig.rest[v as usize]).collect();
//! handles[1] += 0.5;
//! animator.evaluate(&handles)?;
//! let mut positions = Vec::new();
//! animator.read(Stage::Positions, &mut positions)?;
//! // Every marker is met exactly.
//! let first = rig.handles[0] as usize;
//! assert!((positions[3 * first + 1] - handles[1]).abs() < 1e-5);
//! # Ok::<(), rhytid::Error>(())
//! ```
//!
//! # Features
//!
//! All but `film` and `view` are on by default. `default-features = false` with a backend alone is the runtime for a game: no solver, no file format but
//! the rig's, nothing that was only needed before.
//!
//! | feature | what it adds |
//! | --- | --- |
//! | `cpu`, `vulkan`, `opencl`, `wgpu` | that backend, in [`backends`] |
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
//! | `report` | what a clean-up did, and what an evaluation found, as pages, with pictures where `render` is: [`report`] |
//! | `conformance` | devices against a float64 reference: [`conformance`] |
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

#[doc(inline)]
pub use rhytid_core::*;

#[doc(inline)]
pub use rhytid_backends as backends;
#[cfg(feature = "capture")]
#[doc(inline)]
pub use rhytid_capture as capture;
#[cfg(feature = "conformance")]
#[doc(inline)]
pub use rhytid_conformance as conformance;
#[cfg(feature = "evaluate")]
#[doc(inline)]
pub use rhytid_evaluate as evaluate;
#[cfg(feature = "formats")]
#[doc(inline)]
pub use rhytid_formats as formats;
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
