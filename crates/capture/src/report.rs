//! The report of a clean-up, as data.
use crate::{Pose, Rival};
use rhytid_core::Warning;
use serde::Serialize;
use std::ops::Range;

/// What was found in a raw take, what was assumed and what was done: everything a report shows.
///
/// Markers are named by the index of their handle in [`Report::labels`]; frames are those of the raw take,
/// counted from 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The H handles' labels, in the rig's order.
    pub labels: Vec<String>,
    /// Frames of the raw take.
    pub frames: usize,
    /// Its frames per second.
    pub rate: f64,
    /// Time of its first frame in seconds.
    pub start: f64,
    /// The time code of its first frame, such as `01:02:03:04`; `None` where the file has none.
    pub timecode: Option<String>,
    /// The moments that the file names, in its order.
    pub marks: Vec<Mark>,
    /// What the file's numbers mean and how it was brought onto the rig.
    pub setup: Found,
    /// What is not as it was measured, ordered by kind, frame and marker.
    pub events: Vec<Event>,
    /// RMS distance of the head's markers from where the fitted motion puts them, in millimetres, one per
    /// frame. 0 in frames without a fit.
    pub head_residuals_mm: Vec<f32>,
    /// RMS noise of a position (of all three coordinates together) in millimetres. The low-rank model or the
    /// second differences tell noise from motion.
    pub noise_mm: f64,
    /// The cut-off of the markers' low-pass filter in Hz; `None` where they were not filtered.
    pub low_pass_hz: Option<f64>,
    /// A sentence each: what the reader and the clean-up had to assume, and what a person should look at.
    pub warnings: Vec<Warning>,
}

/// A moment that the file names, such as a clap.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mark {
    /// The name in the file.
    pub name: String,
    /// The nearest frame of the raw take, counted from 0. It is below 0 before the take.
    pub frame: i64,
}

/// How the file's markers and numbers were understood.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// The label in the file of each handle's marker, in the order of the handles; `None` where there is
    /// none.
    pub markers: Vec<Option<String>>,
    /// The subject whose markers are used; `None` where the file has but one.
    pub subject: Option<String>,
    /// The labels in the file of the rigid markers that the head's motion was fitted to; empty where it was
    /// fitted to the face's own.
    pub rigid: Vec<String>,
    /// Labels in the file that are not used.
    pub unused: Vec<String>,
    /// Metres in one unit of the file.
    pub metres_per_unit: f64,
    /// Whether that is a guess.
    pub unit_is_guessed: bool,
    /// The file's axes that the mesh's x, y and z are, such as `+x+z-y`.
    pub axes: String,
    /// Whether that is a guess.
    pub axes_are_guessed: bool,
    /// The neutral frames.
    pub neutral: Range<usize>,
    /// Whether they were found rather than given.
    pub neutral_is_found: bool,
    /// Other frames that may be the neutral ones; `None` where the choice is sure, or was given.
    pub neutral_rival: Option<Rival>,
    /// How large the actor is compared with the rig.
    pub scale: f64,
    /// Whether the take was in head space and mesh units already. Then it was neither stabilised nor aligned.
    pub in_head_space: bool,
    /// Distance of each handle's marker from its handle at neutral, in millimetres. It is measured after the
    /// alignment and before this offset is taken out. `None` where the marker was never seen at neutral.
    pub offsets_mm: Vec<Option<f64>>,
    /// For each handle, how large the rig is around it compared with the actor at the same size. The marker's
    /// motion was multiplied by this number.
    pub scales: Vec<f64>,
    /// The actor's poses. A linear map for each region was made from them.
    pub poses: Vec<Pose>,
}

/// Something that is not as it was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Event {
    /// Its kind.
    pub kind: Kind,
    /// The handle whose marker it concerns; `None` for the head's rigid markers together.
    pub marker: Option<usize>,
    /// [`Kind::Swap`]: the other marker. [`Kind::Slide`]: the marker that the label slid to, if any.
    /// [`Kind::Strain`]: the other end.
    pub other: Option<usize>,
    /// First frame.
    pub first: usize,
    /// Number of frames.
    pub frames: usize,
    /// [`Kind::Outlier`] and [`Kind::Step`]: how far away it was, in millimetres on the rig.
    pub distance_mm: Option<f64>,
    /// [`Kind::Strain`]: the greatest strain, 1 for twice the length at rest.
    pub strain: Option<f64>,
    /// The lowest confidence that its samples were given.
    pub confidence: f32,
}

/// The kinds of [`Event`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Two markers had each other's label; undone.
    Swap,
    /// A label that changed places with others, other than in a [`Kind::Swap`], or that is not where it is
    /// expected near such a change. Put right where that is clear; dropped and filled as a gap elsewhere.
    Shuffled,
    /// A position where no marker can have been; dropped, then filled as a gap.
    Outlier,
    /// Positions that were dropped by hand, then filled as a gap.
    Dropped,
    /// A marker that was held by hand where it was on the face.
    Held,
    /// A label that slid off its marker, to another or to none; cut out, then filled as a gap.
    Slide,
    /// A gap that the capture system had filled.
    FilledBefore,
    /// A short gap, filled by a spline.
    Spline,
    /// A longer gap, filled by the low-rank model of this take.
    Model,
    /// A gap past the limit, or of all markers: filled as well as possible, but not reliable.
    Lost,
    /// A marker that was never seen: it moves with its neighbours.
    NeverSeen,
    /// A gap that was left open, with [`crate::Step::Gaps`] skipped.
    Left,
    /// A stretch between two handles that no skin has, far beyond what the rig's examples show; left as it
    /// is.
    Strain,
    /// A marker that moves against its neighbours faster than skin does, and does not return; left as it is.
    Step,
    /// The head's rigid markers were not seen: the head's motion comes from the face's markers, or is held.
    Head,
}

impl Kind {
    /// Its name in a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::FilledBefore => "filled before",
            Self::Spline => "spline",
            Self::Model => "model",
            Self::Head => "head not seen",
            Self::Lost => "lost",
            Self::NeverSeen => "never seen",
            Self::Left => "left",
            Self::Swap => "swap",
            Self::Shuffled => "shuffled",
            Self::Slide => "slide",
            Self::Dropped => "dropped",
            Self::Held => "held",
            Self::Strain => "strain",
            Self::Step => "step",
            Self::Outlier => "outlier",
        }
    }
}
