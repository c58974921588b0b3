//! The settings of a clean-up.
use crate::{Axes, Edit};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// What is known of an actor and a take, and what to do. By default everything is found, and every step is
/// done.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Handles whose markers have another label in the file: handle → label.
    pub markers: BTreeMap<String, String>,
    /// The subject whose markers are the face's, such as `Anna` for labels like `Anna:jaw00`. `None`: the
    /// only one whose labels are the handles'.
    pub subject: Option<String>,
    /// The labels in the file of the rigid markers. `None`: markers of no handle that keep their distances
    /// and travel with the face.
    pub rigid: Option<Vec<String>>,
    /// Metres in one unit of the file; `None`: what the file says, or the unit that fits the rig's size.
    pub metres_per_unit: Option<f64>,
    /// The file's axes; `None`: those in which the actor looks where the rig looks.
    pub axes: Option<Axes>,
    /// The neutral frames, from 0; `None`: the half second that is most neutral, with the start
    /// and the end of the take before all others.
    pub neutral: Option<Range<usize>>,
    /// Steps to leave out.
    pub skip: BTreeSet<Step>,
    /// Gaps longer than this many seconds are flagged.
    pub max_gap: f64,
    /// Cut-off of the markers' low-pass filter in Hz. `None`: 12 Hz if the take is noisy, and no more is
    /// taken than noise; no filter otherwise.
    pub low_pass: Option<f64>,
    /// The head motion's low-pass filter's cut-off in Hz.
    pub head_low_pass: f64,
    /// Frames in which the actor does what an example of the rig shows: example → frame.
    pub poses: BTreeMap<String, usize>,
    /// Repairs by hand.
    pub edits: Vec<Edit>,
    /// Frames per second to resample to; `None`: the take's own.
    pub fps: Option<f64>,
    /// Whether a result that no face can have is kept, with a warning in place of the error.
    pub force: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            markers: BTreeMap::new(),
            subject: None,
            rigid: None,
            metres_per_unit: None,
            axes: None,
            neutral: None,
            skip: BTreeSet::new(),
            max_gap: 2.0,
            low_pass: None,
            head_low_pass: 8.0,
            poses: BTreeMap::new(),
            edits: Vec::new(),
            fps: None,
            force: false,
        }
    }
}

/// A step of the clean-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Step {
    /// The head's motion is taken out.
    Head,
    /// The head's motion is smoothed.
    HeadLowPass,
    /// The actor is brought onto the rig, and each marker's offset from its handle taken out.
    Align,
    /// Each marker's motion is made larger or smaller where the rig's face is, compared with the actor's.
    Proportions,
    /// Swapped labels are found.
    Swaps,
    /// Outliers are dropped.
    Outliers,
    /// Labels that slide off their markers are cut out.
    Slides,
    /// Gaps are filled. Without this step gaps and dropped outliers are [`rhytid_core::RawTake::MISSING`] in
    /// the clean take.
    Gaps,
    /// The markers are low-pass filtered.
    LowPass,
}
