//! The raw take: marker tracks before the clean-up.
use crate::Take;

/// Marker tracks as a file gives them, before the clean-up that makes a [`Take`] for a rig of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawTake {
    /// All markers of the file under distinct labels, in the file's unit and axes; a position whose three coordinates are NaN
    /// is a marker that was not seen. Its confidence is below 1 where the capture system says that it filled a gap.
    pub tracks: Take,
    /// Metres in one unit of the positions; `None` where the file does not say.
    pub metres_per_unit: Option<f64>,
    /// Whether the format promises positions in mesh units and head space, as the take's CSV does.
    pub in_head_space: bool,
    /// What the reader had to assume, or got over: a sentence each.
    pub warnings: Vec<String>,
}

impl RawTake {
    /// Where a marker is that was not seen.
    pub const MISSING: [f64; 3] = [f64::NAN; 3];

    /// The confidence of what a capture system filled itself: it is plausible, and not seen.
    pub const FILLED: f32 = 0.5;
}
