//! What to do with missing markers.

use crate::listed::listed;
use serde::{Deserialize, Serialize};
use std::fmt;

listed! {
    /// What to do where a marker is missing from a frame: one of its cells is empty, NaN or infinite.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Missing {
        /// An error that names frame and label.
        #[default]
        Error,
        /// Keep the marker where it was last seen (before its first sighting: where it is first seen).
        Hold,
        /// Leave it at [`crate::RawTake::MISSING`], for a clean-up; the head is held. A marker may also be
        /// missing from all frames.
        // No animation is made with this choice, so files do not have it.
        #[serde(skip_deserializing)]
        Leave,
    }
}

impl Missing {
    /// As it stands in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Hold => "hold",
            Self::Leave => "leave",
        }
    }
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
