//! The raw take: marker tracks before the clean-up.
use crate::Take;

/// Marker tracks as a file gives them. The clean-up makes a [`Take`] for a rig from them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawTake {
    /// All markers of the file under distinct labels, in the file's unit and axes. A marker that was not seen
    /// has NaN for all three coordinates. The confidence is below 1 where the capture system says that it
    /// filled a gap.
    pub tracks: Take,
    /// Metres in one unit of the positions; `None` where the file does not say.
    pub metres_per_unit: Option<f64>,
    /// Whether the format promises positions in mesh units and head space, as the take's CSV does.
    pub in_head_space: bool,
    /// Whether the markers are landmarks that a program found in a video, with z pointing to the camera. Such
    /// frames have no common scale, and their depth is less sure than their place in the image.
    pub is_video: bool,
    /// What the reader had to assume or to repair, one sentence each.
    pub warnings: Vec<String>,
}

impl RawTake {
    /// The position of a marker that was not seen.
    pub const MISSING: [f64; 3] = [f64::NAN; 3];

    /// The confidence of a position that the capture system filled in: it is plausible, but was not seen.
    pub const FILLED: f32 = 0.5;
}
