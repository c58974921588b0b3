//! The effects of a file of edits on frames. Browsers have no edits.

use crate::document::TimelineEvent;
use crate::same::Same;
#[cfg(not(target_arch = "wasm32"))]
use rhytid_formats::edits::{Curve, Ease, Edits};

#[cfg(not(target_arch = "wasm32"))]
pub(crate) use rhytid_playback::{FrameEdits, Layers};

/// Browsers have no edits: these change nothing.
#[cfg(target_arch = "wasm32")]
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct FrameEdits {}

/// Browsers have no edits.
#[cfg(target_arch = "wasm32")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Layers {}

#[cfg(target_arch = "wasm32")]
impl Layers {
    pub(crate) fn let_through(&self, _: usize, _: &dyn Fn(usize) -> Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        match *self {}
    }
}

#[cfg(target_arch = "wasm32")]
impl FrameEdits {
    pub(crate) fn with_edited(&self, _: &rhytid_core::Rig, _: &[bool]) -> Self {
        Self {}
    }

    pub(crate) fn touches(&self, _: f64) -> bool {
        false
    }

    pub(crate) fn scale_wrinkles(&self, _: f64, _: &[f32], _: &mut [f32]) -> bool {
        false
    }

    pub(crate) fn blend(
        &self,
        _: &rhytid_core::Rig,
        _: &rhytid_kernels::normals::VertexTriangles,
        _: [&[[f32; 3]]; 2],
        _: &mut [[f32; 3]],
        _: &mut [[f32; 3]],
    ) {
    }

    pub(crate) fn correct(
        &self,
        _: &rhytid_core::Rig,
        _: &rhytid_kernels::normals::VertexTriangles,
        _: f64,
        _: &[[f32; 3]],
        _: &mut [[f32; 3]],
        _: &mut [[f32; 3]],
    ) {
    }
}

/// The effects of edits and pulls on the frame that is shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EditedFrame {
    /// Those of the file of edits.
    pub edits: Option<Same<FrameEdits>>,
    /// The time of the frame, in seconds.
    pub time: f64,
    /// H: the handles that edits or pulls move in any frame.
    pub moved: Vec<bool>,
    /// H positions without edits and pulls. `None` unless these have a falloff and move handles.
    pub without: Option<Vec<[f32; 3]>>,
}

/// A take with its edits.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OpenEdits {
    /// The name of the file.
    pub name: String,
    /// frames × H × 3 of the edited take.
    pub positions: Vec<f32>,
    /// The frames that each edit changes.
    pub spans: Vec<TimelineEvent>,
    /// H: the handles that the edits move in any frame.
    pub moved: Vec<bool>,
    /// The edits themselves.
    pub layers: Same<Layers>,
    /// All other edits.
    pub on_frames: Same<FrameEdits>,
}

/// The frames that each edit of a file changes, in the order of its kinds. Corrections follow the face and
/// not the time, so they have none.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn spans(edits: &Edits, frames: usize) -> Vec<TimelineEvent> {
    let mut spans = Vec::new();
    let mut add = |name: &str, place: &Option<String>, curve: &Curve, nothing: f64| {
        let changed = |frame: &usize| curve.at(*frame as f64) != nothing;
        let (Some(first), Some(last)) = ((0..frames).find(changed), (0..frames).rfind(changed)) else {
            return;
        };
        let place = place.as_deref().map_or(String::new(), |place| format!(" of {place}"));
        let words = format!("[[{name}]]{place}");
        spans.push(TimelineEvent::new(first, last + 1 - first, words));
    };
    for gain in &edits.gains {
        add("gain", &gain.region, &gain.by, 1.0);
    }
    for offset in &edits.offsets {
        let labels: Vec<&str> = offset.markers.keys().map(String::as_str).collect();
        let place = offset.region.clone().or((!labels.is_empty()).then(|| some_of(&labels)));
        add("offset", &place, &offset.amount, 0.0);
    }
    for added in &edits.added {
        add("add", &added.region, &added.amount, 0.0);
    }
    for hold in &edits.holds {
        let (first, end) = (hold.frames.start as f64, hold.frames.end as f64);
        let keys = vec![(first - 1.0, 0.0), (first, 1.0), (end - 1.0, 1.0), (end, 0.0)];
        let keys = if end - first > 1.0 { keys } else { vec![(first - 1.0, 0.0), (first, 1.0), (end, 0.0)] };
        add("hold", &hold.region, &Curve { keys, ease: Ease::Linear }, 0.0);
    }
    for detail in &edits.details {
        add("detail", &detail.region, &detail.by, 1.0);
    }
    spans
}

/// The first of some names, and how many more there are.
pub(crate) fn some_of(names: &[&str]) -> String {
    const NAMED: usize = 3;
    match names.len() {
        0..=NAMED => names.join(", "),
        all => format!("{} and {} more", names[..NAMED].join(", "), all - NAMED),
    }
}
