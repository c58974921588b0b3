//! A take with edits, together with the take before them.

use rhytid_core::{Result, Take};
use std::ops::Range;

/// A take with edited handles, together with the take before the edits; or a take without edits.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EditedTake {
    /// The take, with the edits.
    pub take: Take,
    /// The same frames and labels without them; `None` where nothing was edited.
    before: Option<Take>,
    /// The labels of the handles that are edited in any frame.
    edited: Vec<String>,
}

impl From<Take> for EditedTake {
    /// Without edits.
    fn from(take: Take) -> Self {
        Self { take, before: None, edited: Vec::new() }
    }
}

impl EditedTake {
    /// Makes an edited take of the take `before` the edits and the take after them. Labels and times are the
    /// same.
    pub(crate) fn new(before: Take, take: Take) -> Self {
        let markers = take.labels.len();
        let is_edited = |column: &usize| {
            let of_column = |take: &'_ Take, frame: usize| take.positions[frame * markers + column];
            (0..take.frames()).any(|frame| of_column(&take, frame) != of_column(&before, frame))
        };
        let edited: Vec<String> =
            (0..markers).filter(is_edited).map(|column| take.labels[column].clone()).collect();
        let before = Some(before).filter(|_| !edited.is_empty());
        Self { take, before, edited }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.take.frames()
    }

    /// The take without the edits. Where there are none, it is the take itself.
    pub fn before(&self) -> &Take {
        self.before.as_ref().unwrap_or(&self.take)
    }

    /// Whether the handle with this label is edited in any frame.
    pub fn is_edited(&self, label: &String) -> bool {
        self.edited.contains(label)
    }

    /// As [`Take::slice`]; handles that are edited in other frames stay so.
    #[must_use]
    pub fn slice(&self, range: Range<usize>) -> Self {
        self.both(|take| take.slice(range.clone()))
    }

    /// As [`Take::pick`]; handles that are edited in other frames stay so.
    #[must_use]
    pub fn pick(&self, frames: &[usize]) -> Self {
        self.both(|take| take.pick(frames))
    }

    /// As [`Take::resample`].
    ///
    /// # Errors
    /// As [`Take::resample`].
    pub fn resample(&self, fps: f64) -> Result<Self> {
        let before = self.before.as_ref().map(|before| before.resample(fps)).transpose()?;
        Ok(Self { take: self.take.resample(fps)?, before, edited: self.edited.clone() })
    }

    fn both(&self, change: impl Fn(&Take) -> Take) -> Self {
        Self {
            take: change(&self.take),
            before: self.before.as_ref().map(&change),
            edited: self.edited.clone(),
        }
    }
}
