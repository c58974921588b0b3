//! Capture: from a raw take to a clean one, pure functions, one clean-up step a file; and what a take does
//! that no example shows ([`mod@coverage`]).
//!
//! ```
//! use rhytid_capture::{Settings, Target, clean};
//! use rhytid_core::{NoProgress, RawTake};
//!
//! # let face = rhytid_demo::face(1_000);
//! # let rig = rhytid_solve::solve(&face, &NoProgress)?.rounded()?;
//! # let mut tracks = rhytid_demo::performance(&face);
//! // `rig` from rhytid_core::rig_file, `tracks` as rhytid_formats::raw_take reads them. A marker is hidden for a while:
//! let markers = tracks.labels.len();
//! (40..48).for_each(|frame| tracks.positions[frame * markers + 5] = RawTake::MISSING);
//!
//! let raw = RawTake { tracks, in_head_space: true, ..RawTake::default() };
//! let cleaned = clean(raw, &Target::from_rig(&rig), &Settings::default(), &NoProgress)?;
//! assert!(cleaned.take.positions.iter().flatten().all(|x| x.is_finite()));
//! // What was filled is not to be trusted as what was measured.
//! assert!(cleaned.take.confidence.is_some_and(|confidence| confidence[44 * markers + 5] < 1.0));
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod by_motion;
mod by_position;
mod clean;
pub mod coverage;
mod depth;
mod doubts;
mod edits;
mod event_words;
mod events;
mod expected;
mod face_cluster;
mod gaps;
mod gross_strain;
mod handles;
mod handles_in_frame;
mod head;
mod head_markers;
mod label_words;
mod labels;
mod low_pass;
mod low_rank;
mod neighbours;
mod neutral;
mod non_negative;
mod online;
mod orientation;
mod outliers;
mod placing;
mod plausible;
mod poses;
mod posture;
mod proportions;
mod report;
mod rigid_sets;
mod settings;
mod shuffles;
mod slides;
mod soft;
mod space;
mod subjects;
mod swaps;
mod target;
mod tracks;
mod typical;
mod unmeasured;
mod verdict;

pub use by_position::{Match, match_by_position};
pub use clean::{Cleaned, clean};
pub use edits::Edit;
pub use gross_strain::{GrossStrain, gross_strain, gross_strain_events};
pub use handles::{HandleSettings, PlacedHandles, place_handles};
pub use labels::{is_unlabelled, same_names};
pub use neutral::Rival;
pub use online::{Online, OnlineFrame};
pub use poses::Pose;
pub use report::{Event, Found, Kind, Mark, Report};
pub use rhytid_geometry::Axes;
pub use settings::{Settings, Step};
pub use soft::{marker_noise, soften};
pub use space::{Misfit, TakeSpace, misfit};
pub use target::{StrainLimit, Target};
