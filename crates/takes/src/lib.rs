//! Marker takes in Rhytid's format ([`take`]) and in the formats of capture systems ([`raw_take`]), and the
//! small tables beside them ([`tables`]). Weights of shapes over time are [`curves`].
//!
//! ```
//! use rhytid_core::Missing;
//! use rhytid_takes::take;
//!
//! let csv = b"time,chin_x,chin_y,chin_z\n0,0,0,0\n0.1,0,3,0\n";
//! let take = take::decode(csv, "take.csv", None, Missing::Error)?;
//! assert_eq!((take.labels.len(), take.frames()), (1, 2));
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

pub mod curves;
mod header;
pub mod raw_take;
mod stamps;
pub mod tables;
pub mod take;
mod text;
mod timecode;
