//! The trait that every animation format implements, what goes in, and what came of it.

use rhytid_core::{PrincipalStrains, Progress, Result};

/// One frame of an animation.
#[derive(Debug, Clone, Copy)]
pub struct Frame<'a> {
    /// 3V positions in mesh units.
    pub positions: &'a [f32],
    /// 3V normals of length 1 (or 0), if the scene has normals.
    pub normals: Option<&'a [f32]>,
    /// 3V velocities in mesh units per second, if the scene has velocities.
    pub velocities: Option<&'a [f32]>,
    /// V standard deviations in mesh units: how far each vertex may be from where a scan of the frame would have it. If the scene has
    /// them; formats without a place for them leave them out.
    pub sigma: Option<&'a [f32]>,
    /// The principal strains of the frame's V vertices, if the scene has them.
    pub strain: Option<&'a PrincipalStrains>,
}

/// One animation file being written. Memory does not grow with the frames' data, or by a gigabyte where they are
/// compressed.
pub trait Exporter: Send {
    /// Adds the next frame.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if a length is wrong, a number is not finite or the frame is one too many;
    /// [`rhytid_core::Error::Io`].
    fn frame(&mut self, frame: Frame<'_>) -> Result<()>;

    /// Writes what remains and gives the file its name. Dropped without it, nothing is left behind, and what
    /// stood under the name before is untouched.
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
    /// How far the file is from the frames that came in; `None` where it has every bit of them.
    pub error: Option<Deviation>,
}

/// How far one animation of a mesh is from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The largest distance of a vertex from its place in any frame, in mesh units.
    pub worst: f64,
    /// The frame, counted from 0, and the vertex of the largest distance.
    pub at: (usize, usize),
    /// The root mean square of all distances, in mesh units.
    pub rms: f64,
}
