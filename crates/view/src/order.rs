//! What a picture is to show.

use crate::document::Document;
use crate::edits::EditedFrame;
use crate::problems::Problem;
use crate::same::Same;
use crate::settings::{Before, Settings};
use rhytid_formats::mesh::Numbers;
use rhytid_render::{Camera, SkinRenderer};

/// Everything that a picture depends on. Equal orders have equal pictures.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Order {
    /// The frame of a mesh without a rig.
    pub frame: usize,
    pub handles: Vec<[f32; 3]>,
    /// The handles without drags and edits, if they are shown, too.
    pub undragged: Option<Vec<[f32; 3]>>,
    pub edits: Option<EditedFrame>,
    pub camera: Camera,
    pub settings: Settings,
    /// In pixels.
    pub size: [u32; 2],
    /// Pixels in a point of the window.
    pub scale: f32,
    pub background: [u8; 4],
    pub selected: Vec<usize>,
    pub pinned: Vec<bool>,
    /// The confidence of a live frame's markers.
    pub confidence: Vec<f32>,
    /// The marker under the pointer.
    pub under: Option<usize>,
    /// H: how far each handle would follow a drag, from 0 to 1. Empty where no marker is held.
    pub follows: Vec<f32>,
    /// What is wrong with markers.
    pub problems: Vec<Problem>,
    /// The vertex that was picked.
    pub vertex: Option<usize>,
    pub numbers: Same<Vec<Numbers>>,
    /// `None` while skin is not shown or not prepared.
    pub skin: Option<Same<SkinRenderer>>,
}

impl Order {
    /// The same picture of a frame of `document`: everything that depends on the frame.
    pub(crate) fn of_frame(self, document: &Document, frame: usize) -> Self {
        Self {
            frame: if document.is_mesh() { frame } else { 0 },
            handles: document.handles_at(frame, true),
            undragged: (self.settings.before == Before::Take).then(|| document.handles_at(frame, false)),
            edits: document.frame_edits_at(frame),
            problems: if self.settings.markers { document.problems_at(frame) } else { Vec::new() },
            ..self
        }
    }
}
