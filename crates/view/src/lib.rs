//! A window on a rig: drag a marker and the face follows.
//!
//! [`ViewApp`] is the viewer, an application of [`eframe`]'s, for a window ([`run`]) as for a canvas in a browser. What it is made of needs
//! neither: a camera that a person holds ([`Orbit`]), who follows whom when markers are dragged ([`Pull`]), undo and redo ([`History`]), the play head
//! ([`Transport`]), and all of them together with a rig and a take ([`Document`]).
//!
//! ```
//! use rhytid_view::{Document, Drag};
//! use std::sync::Arc;
//!
//! # let face = rhytid_demo::face(1_000);
//! # let rig: rhytid_core::Rig = rhytid_solve::solve(&face, &rhytid_core::NoProgress)?.rounded()?;
//! // `rig` from rhytid_core::rig_file::read.
//! let mut document = Document::new(Arc::new(rig), "FACE.safetensors");
//! let before = document.handles(true);
//! document.begin_drag();
//! document.drag(Drag { grabbed: &[0], by: [0.0, 0.2, 0.0], reach: 3.0, mirrored: true, pinned: &[] });
//! document.end_drag(true);
//! assert!((document.handles(true)[0][1] - before[0][1] - 0.2).abs() < 1e-5);
//! assert!(document.undo());
//! assert_eq!(document.handles(true), before);
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod acts;
mod app;
mod canvas;
mod commands;
mod document;
mod each_frame;
mod edits;
mod frame_source;
mod history;
#[cfg(target_arch = "wasm32")]
mod inbox;
mod keys;
#[cfg(not(target_arch = "wasm32"))]
mod live;
mod open;
mod orbit;
mod panel;
mod pick;
mod pull;
#[cfg(not(target_arch = "wasm32"))]
mod save;
mod scene;
mod settings;
mod timeline;
mod transport;
mod viewport;
#[cfg(not(target_arch = "wasm32"))]
mod window;

pub use app::ViewApp;
pub use document::{Document, Incident, OpenTake, Pose};
pub use history::History;
#[cfg(target_arch = "wasm32")]
pub use inbox::{Inbox, Read};
pub use orbit::Orbit;
pub use pick::{marker, vertex};
pub use pull::{Drag, Pull};
pub use scene::Times;
pub use settings::{Before, Settings, Show};
pub use transport::Transport;
#[cfg(not(target_arch = "wasm32"))]
pub use window::{WindowOptions, run};
