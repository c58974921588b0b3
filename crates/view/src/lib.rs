//! A window on a rig: drag a marker and the face follows.
//!
//! [`ViewApp`] is the viewer, an application of [`eframe`]. It runs in a window ([`run`]) or in a canvas in a
//! browser. Its parts need neither: the camera that the user moves ([`Orbit`]), the soft selection
//! ([`SoftSelection`]), undo and redo ([`History`]), and the play head ([`Transport`]). A [`Document`] joins
//! them with a rig and a take.
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
mod busy;
mod canvas;
mod commands;
#[cfg(not(target_arch = "wasm32"))]
mod dialog;
mod document;
mod each_frame;
mod edits;
mod events;
#[cfg(not(target_arch = "wasm32"))]
mod export;
mod files;
mod frame_source;
mod gpu;
mod history;
#[cfg(target_arch = "wasm32")]
mod inbox;
mod keys;
#[cfg(not(target_arch = "wasm32"))]
mod leaving;
mod legend;
#[cfg(not(target_arch = "wasm32"))]
mod live;
mod marker_dots;
mod marker_guides;
mod marker_values;
mod open;
mod open_mesh;
mod orbit;
mod order;
mod pace;
mod painter;
mod panel;
mod panel_place;
mod pick;
mod problems;
mod pull_panel;
mod pulls;
#[cfg(not(target_arch = "wasm32"))]
mod recent;
#[cfg(not(target_arch = "wasm32"))]
mod repairs;
mod ruler;
mod same;
#[cfg(not(target_arch = "wasm32"))]
mod save;
mod scene;
mod screen;
mod settings;
mod slow_frames;
mod soft_selection;
mod studio;
mod theme;
mod timeline;
mod transport;
mod viewport;
mod welcome;
#[cfg(not(target_arch = "wasm32"))]
mod window;
mod work;
#[cfg(not(target_arch = "wasm32"))]
mod world;

pub use app::ViewApp;
pub use document::{Document, NewPulls, OpenTake, Pose, Reading, TimelineEvent};
pub use history::History;
#[cfg(target_arch = "wasm32")]
pub use inbox::{Inbox, Read};
#[cfg(not(target_arch = "wasm32"))]
pub use live::Listen;
pub use orbit::Orbit;
pub use pick::{marker, vertex};
pub use problems::{Problem, ProblemKind};
pub use pulls::{Pull, Span, When};
pub use scene::Times;
pub use settings::{Before, Settings, Show};
pub use soft_selection::{Drag, SoftSelection};
pub use transport::{Repeat, Transport};
#[cfg(not(target_arch = "wasm32"))]
pub use window::{WindowOptions, run};
