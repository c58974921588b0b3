//! Sites: the points of the domain, and where it is cut.

/// The domain's half width.
pub(crate) const HALF_WIDTH: f64 = 10.0;
/// The domain's lower end, at the neck.
pub(crate) const BOTTOM: f64 = -15.2;
/// The domain's upper end, at the hairline.
pub(crate) const TOP: f64 = 8.6;
/// `up` of the cut through the eyes.
pub(crate) const EYE_LINE: f64 = 0.0;
/// The cut through an eye lies between these distances from the midline.
pub(crate) const EYE_CUT: [f64; 2] = [1.75, 4.7];
/// `up` of the cut through the mouth.
pub(crate) const MOUTH_LINE: f64 = -6.45;
/// The cut through the mouth goes to this distance from the midline on both sides.
pub(crate) const MOUTH_CUT: f64 = 2.65;

/// A point of the domain. On a cut, the flags say to which side it belongs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Site {
    /// Across the face, in [-[`HALF_WIDTH`], [`HALF_WIDTH`]].
    pub across: f64,
    /// Up the face, in [[`BOTTOM`], [`TOP`]].
    pub up: f64,
    /// Whether it belongs to the upper side of the eyes' line.
    pub above_eyes: bool,
    /// Whether it belongs to the upper side of the mouth's line.
    pub above_mouth: bool,
}

impl Site {
    pub(super) fn shifted(self, across: f64, up: f64) -> Self {
        Self { across: self.across + across, up: self.up + up, ..self }
    }
}
