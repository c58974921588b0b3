//! Playback of a take on a rig, on the fastest device that can be trusted, and on the next one if that fails.
//!
//! Frames are evaluated in batches, one batch ahead of their use. Playback can also add normals, velocities
//! and the head's motion. Wrinkles fade where the take is not to be trusted. Triangles that the fine detail
//! turns over are turned back.
//!
//! ```
//! use rhytid_core::NoProgress;
//! use rhytid_formats::export::Recipe;
//! use rhytid_devices::{Guard, choose_devices};
//! use rhytid_playback::{Playback, Selection};
//!
//! # let face = rhytid_demo::face(1_000);
//! # let rig = rhytid_solve::solve(&face, &NoProgress)?.rounded()?;
//! # let take = rhytid_demo::performance(&face).slice(0..20);
//! // `rig` from rhytid_core::rig_file::read, `take` from read_take.
//! let selection = Selection::all(take)?;
//! // Or "auto".
//! let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress)?.devices;
//! let mut playback = Playback::new(&rig, &devices, selection.take.frames())?;
//! let mut highest = f32::MIN;
//! playback.play(&selection, &Recipe::default(), &NoProgress, |frame| {
//!     highest = frame.positions().iter().skip(1).step_by(3).copied().fold(highest, f32::max);
//!     Ok(())
//! })?;
//! assert!(highest > 0.0);
//! # Ok::<(), rhytid_core::Error>(())
//! ```
//! [`Playback::export`] plays into a USD or glTF file.
#![forbid(unsafe_code)]

mod affected_region;
mod bake;
mod batch;
mod channels;
mod contact;
mod context;
mod correction;
mod curve_take;
mod edit_falloff;
mod edited_take;
mod example_residuals;
mod export;
mod fade;
mod fit;
mod layers;
mod levels;
mod local_normals;
mod named_shapes;
mod pack;
mod performance;
mod pipeline;
mod playback;
mod poses;
mod refined;
mod regions;
mod rig_diff;
mod selection;
mod shape_set;
mod shape_space;
mod shapes;
mod stages;
mod takes;
mod untangle;
mod velocities;
mod verify;

pub use batch::{batch_frames, frame_bytes, rig_bytes};
pub use channels::of_recipe as channels_of;
pub use correction::Correction;
pub use edited_take::EditedTake;
pub use example_residuals::{ExampleResiduals, example_residuals};
pub use export::{check_export, export_clips};
pub use layers::{FrameEdits, Layers};
pub use levels::{LevelOfDetail, levels};
pub use pack::{Packed, pack};
pub use performance::Performance;
pub use playback::Playback;
pub use regions::{check_gains, region_of, scale_wrinkles};
pub use rig_diff::{Change, rig_diff};
pub use selection::{FrameRange, Selection, uneven_step};
pub use shape_set::read_shape_set;
pub use shapes::handle_shapes;
pub use stages::finishes_frames_on_host;
pub use takes::{CleanUp, ReadTake, read_raw_take, read_take, shapes_hash, space_of_take};
pub use verify::{ChannelDifference, Verified, verify};
