//! The TOML files of a face: the [`project`], which names its scans and handles, and [`edits`] of a take.
//!
//! ```
//! use rhytid_projects::edits;
//!
//! let text = "[region.chin]\nmarkers = [\"chin\"]\n[[gain]]\nregion = \"chin\"\nby = 1.5\n";
//! let edits = edits::parse(text, "EDIT.toml")?;
//! assert_eq!(edits.gains.len(), 1);
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod document;
pub mod edits;
mod pattern;
pub mod project;
