//! The trait that every animation format implements, and the result of an export.

use super::Frame;
use rhytid_core::{Progress, Result};

/// One animation file being written. Memory does not grow with the frames' data, or by a gigabyte where they
/// are compressed.
pub trait Exporter: Send {
    /// Adds the next frame with the scene's channels. A constant channel is in the first frame alone.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if a channel is missing or not of the scene, a length is wrong, a number
    /// is not finite or there are too many frames; [`rhytid_core::Error::Io`].
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()>;

    /// Writes the rest and gives the file its name. An exporter that is dropped before this leaves nothing
    /// behind, and an older file of that name stays as it was.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if frames are missing or the options' bound cannot be met;
    /// [`rhytid_core::Error::Io`]; [`rhytid_core::Error::Cancelled`].
    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written>;
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Bytes of all files together.
    pub bytes: u64,
    /// Morph targets, in a format that has them.
    pub targets: Option<usize>,
    /// The deviation of each clip from the frames that came in; empty if the file has every bit of them.
    pub errors: Vec<Deviation>,
}

/// How far one animation of a mesh is from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The largest distance of a vertex from its place in any frame, in mesh units.
    pub worst: f64,
    /// The frame, counted from 0 in its clip, and the vertex of the largest distance.
    pub at: (usize, usize),
    /// The root mean square of all distances, in mesh units.
    pub rms: f64,
}
