//! What is likely wrong with a sender, each said once.

use std::collections::BTreeSet;

/// What a warning is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum About {
    /// Times that are not seconds.
    Unit,
    /// Times that are not in the unit that was said at first.
    OtherUnit,
    /// Times that are too coarse.
    Coarse,
    /// Times that stand still.
    StillTimes,
    /// Numbers that stand still.
    StillNumbers,
    /// Two markers of one name.
    Names,
    /// Markers that came too late to be recorded.
    TooManyMarkers,
}

/// Warnings in the order in which they arose.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    said: BTreeSet<About>,
    pub sentences: Vec<String>,
}

impl Warnings {
    /// Says it, if nothing has been said about it yet.
    pub(crate) fn say(&mut self, about: About, sentence: impl FnOnce() -> String) {
        if self.said.insert(about) {
            self.sentences.push(sentence());
        }
    }
}
