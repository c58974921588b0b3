//! What is open: a rig, a take, and how markers were pulled.

use crate::edits::{EditedFrame, OpenEdits};
use crate::history::History;
use crate::pull::{Drag, Pull};
use crate::transport::Transport;
use glam::Vec3;
use rhytid_core::{Error, Mesh, Result, Rig, Take};
use rhytid_formats::mesh::Numbers;
use std::sync::Arc;

/// How markers were pulled, over whatever the take does: what is undone and done again.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// H vectors that are added to where the take has the handles, in mesh units.
    pub offsets: Vec<[f32; 3]>,
    /// H: which stay where they are while others are dragged.
    pub pinned: Vec<bool>,
}

/// What of a take the time line shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Incident {
    /// The first of its frames, and how many there are.
    pub first: usize,
    /// At least 1.
    pub frames: usize,
    /// What it is, and of which marker.
    pub words: String,
    /// How far its samples are to be trusted, from 0 to 1.
    pub confidence: f32,
}

/// A take that was opened.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenTake {
    /// What it is called.
    pub name: String,
    /// The take itself.
    pub take: Take,
    /// What the clean-up found, where it was a raw take.
    pub incidents: Vec<Incident>,
}

/// A rig, a take on it, and the pose.
#[derive(Debug)]
pub struct Document {
    /// The rig.
    pub rig: Arc<Rig>,
    /// What it is called.
    pub name: String,
    /// H positions in mesh units.
    rest: Vec<[f32; 3]>,
    take: Option<OpenTake>,
    /// frames × H × 3 of the take.
    positions: Vec<f32>,
    /// The take's edits, and whether they are shown.
    edits: Option<OpenEdits>,
    edited: bool,
    /// The least confidence of the handles in each frame; empty where all is measured.
    confidence: Vec<f32>,
    /// Numbers of a file, each with one for every vertex.
    numbers: Vec<Numbers>,
    /// Where live positions are: H × 3, and the confidence of each handle; they take the take's place.
    live: Option<(Vec<f32>, Vec<f32>)>,
    /// The play head.
    pub transport: Transport,
    pull: Pull,
    pose: Pose,
    history: History<Pose>,
    /// Before the drag that is going on.
    before_drag: Option<Pose>,
}

impl Document {
    /// A rig at rest.
    pub fn new(rig: Arc<Rig>, name: &str) -> Self {
        let rest = rig.handles().rest.clone();
        let pose = Pose { offsets: vec![[0.0; 3]; rest.len()], pinned: vec![false; rest.len()] };
        Self {
            pull: Pull::new(&rig),
            name: name.to_owned(),
            take: None,
            positions: Vec::new(),
            edits: None,
            edited: true,
            confidence: Vec::new(),
            numbers: Vec::new(),
            live: None,
            transport: Transport::new(&[0.0], 30.0),
            pose,
            history: History::default(),
            before_drag: None,
            rest,
            rig,
        }
    }

    /// Plays a take from now on; the pose stays.
    ///
    /// # Errors
    /// [`Error::Input`] if it lacks a handle, or has no frame.
    pub fn set_take(&mut self, open: OpenTake) -> Result<()> {
        let in_file = |error: Error| error.in_file(&open.name);
        let positions = open.take.handle_positions(&self.rig.handles().labels).map_err(in_file)?;
        if positions.is_empty() {
            return Err(in_file(Error::empty("has no frame, expected at least one")));
        }
        let columns: Vec<usize> = (self.rig.handles().labels.iter())
            .filter_map(|label| open.take.labels.iter().position(|other| other == label))
            .collect();
        let confidence = open.take.confidence.iter().flat_map(|confidence| {
            let least = |frame: &[f32]| columns.iter().map(|&c| frame[c]).fold(1.0, f32::min);
            confidence.chunks_exact(open.take.labels.len().max(1)).map(least)
        });
        self.confidence = confidence.collect();
        self.transport = Transport::new(&open.take.times, open.take.rate());
        self.positions = positions;
        self.edits = None;
        self.take = Some(open);
        Ok(())
    }

    /// The take.
    pub fn take(&self) -> Option<&OpenTake> {
        self.take.as_ref()
    }

    /// Shows the take edited from now on.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn set_edits(&mut self, edits: OpenEdits) {
        self.edits = Some(edits);
        self.edited = true;
    }

    /// What the edits of the take are called, and whether they are shown.
    pub fn edits(&self) -> Option<(&str, bool)> {
        self.edits.as_ref().map(|edits| (&*edits.name, self.edited))
    }

    /// Shows the take edited, or as it was.
    pub fn show_edited(&mut self, edited: bool) {
        self.edited = edited;
    }

    /// The edits that are shown, of a take that is.
    fn shown_edits(&self) -> Option<&OpenEdits> {
        self.edits.as_ref().filter(|_| self.edited && self.live.is_none())
    }

    /// What edits do to the frame that is shown, beside moving its handles.
    pub(crate) fn frame_edits(&self) -> Option<EditedFrame<'_>> {
        let edits = &self.shown_edits()?.on_frames;
        let time = self.take.as_ref()?.take.times.get(self.transport.frame()).copied()?;
        let without = sums(&self.handles(false), &self.pose.offsets);
        let without = Some(without).filter(|without| edits.has_falloff() && *without != self.handles(true));
        (without.is_some() || edits.touches(time)).then_some(EditedFrame { edits, time, without })
    }

    /// The least confidence of the handles in each frame, from 0 to 1; empty where all is measured.
    pub fn confidence(&self) -> &[f32] {
        &self.confidence
    }

    /// Has these numbers to show, a name and V of them each; what is no number has no counterpart.
    pub fn set_numbers(&mut self, numbers: Vec<Numbers>) {
        self.numbers = numbers;
    }

    /// The numbers that there are to show.
    pub fn numbers(&self) -> &[Numbers] {
        &self.numbers
    }

    /// Shows H × 3 positions that come live, each of the H handles with its confidence from 0 to 1, in place of the take's; `None` for the
    /// take again.
    pub fn set_live(&mut self, frame: Option<(Vec<f32>, Vec<f32>)>) {
        self.live = frame;
    }

    /// H: how far each handle of a live frame is to be trusted, from 0 to 1; empty where none is shown.
    pub fn live_confidence(&self) -> &[f32] {
        self.live.as_ref().map_or(&[], |(_, confidence)| confidence)
    }

    /// Whether live positions are shown.
    pub fn is_live(&self) -> bool {
        self.live.is_some()
    }

    /// H positions of the frame that is shown, in mesh units and head space: with edits and how they were pulled, or without both.
    pub fn handles(&self, pulled: bool) -> Vec<[f32; 3]> {
        let per_frame = 3 * self.rest.len();
        let frame = self.transport.frame();
        let edited = self.shown_edits().filter(|_| pulled).map(|edits| &edits.positions);
        let positions = edited.unwrap_or(&self.positions);
        let base = match (&self.live, positions.get(frame * per_frame..(frame + 1) * per_frame)) {
            (Some((live, _)), _) => live.as_chunks::<3>().0,
            (None, Some(frame)) => frame.as_chunks::<3>().0,
            (None, None) => &self.rest,
        };
        if !pulled {
            return base.to_vec();
        }
        sums(base, &self.pose.offsets)
    }

    /// How markers were pulled.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Who follows whom.
    pub fn pull(&self) -> &Pull {
        &self.pull
    }

    /// A drag begins: what follows is one step to undo.
    pub fn begin_drag(&mut self) {
        self.before_drag = Some(self.pose.clone());
    }

    /// Drags handles by so much since the drag began, or in all where none has.
    pub fn drag(&mut self, drag: Drag<'_>) {
        let moved = self.pull.drag(drag);
        let from = self.before_drag.as_ref().unwrap_or(&self.pose);
        self.pose.offsets = sums(&from.offsets, &moved);
    }

    /// The drag is over. `keep` is false where it is taken back.
    pub fn end_drag(&mut self, keep: bool) {
        if let Some(before) = self.before_drag.take() {
            match keep {
                true if before != self.pose => self.history.record(before),
                true => {}
                false => self.pose = before,
            }
        }
    }

    /// Whether handles are being dragged.
    pub fn is_dragging(&self) -> bool {
        self.before_drag.is_some()
    }

    /// Pins handles, or lets them go if all of them are pinned.
    pub fn toggle_pins(&mut self, handles: &[usize]) {
        self.change(|pose| {
            let all = handles.iter().all(|&handle| pose.pinned[handle]);
            handles.iter().for_each(|&handle| pose.pinned[handle] = !all);
        });
    }

    /// Puts these handles back to where the take has them; all where none is named.
    pub fn reset(&mut self, handles: &[usize]) {
        self.change(|pose| match handles {
            [] => pose.offsets.fill([0.0; 3]),
            some => some.iter().for_each(|&handle| pose.offsets[handle] = [0.0; 3]),
        });
    }

    fn change(&mut self, change: impl FnOnce(&mut Pose)) {
        let before = self.pose.clone();
        change(&mut self.pose);
        if before != self.pose {
            self.history.record(before);
        }
    }

    /// Takes the last change back; whether there was one.
    pub fn undo(&mut self) -> bool {
        self.end_drag(true);
        self.history.undo(&mut self.pose)
    }

    /// Does again what was undone last; whether there was something.
    pub fn redo(&mut self) -> bool {
        self.history.redo(&mut self.pose)
    }

    /// Whether there is something to undo, and to redo.
    pub fn can_undo_and_redo(&self) -> [bool; 2] {
        self.history.can()
    }

    /// The frame that is shown, as a take of one frame at its time.
    pub fn frame_as_take(&self) -> Take {
        let widen = |p: [f32; 3]| p.map(f64::from);
        Take {
            labels: self.rig.handles().labels.clone(),
            times: vec![self.transport.time()],
            positions: self.handles(true).into_iter().map(widen).collect(),
            ..Take::default()
        }
    }

    /// How markers were pulled, as a file of edits has it: millimetres of each that was.
    pub fn pulls(&self) -> std::collections::BTreeMap<String, [f64; 3]> {
        let millimetres = |x: &f32| f64::from(*x) * self.rig.surface().metres_per_unit * 1e3;
        let labelled = self.rig.handles().labels.iter().zip(&self.pose.offsets);
        let moved = labelled.filter(|(_, offset)| **offset != [0.0; 3]);
        moved.map(|(label, offset)| (label.clone(), offset.each_ref().map(millimetres))).collect()
    }

    /// A frame as a mesh that can be an example of the rig: its V × 3 `positions` with the rig's polygons and texture coordinates.
    pub fn frame_as_mesh(&self, positions: &[f32]) -> Mesh {
        Mesh {
            positions: positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect(),
            faces: self.rig.surface().faces.clone(),
            uvs: self.rig.surface().uvs.clone(),
            materials: self.rig.surface().materials.clone(),
        }
    }
}

/// The sum of each pair of vectors.
fn sums(a: &[[f32; 3]], b: &[[f32; 3]]) -> Vec<[f32; 3]> {
    a.iter().zip(b).map(|(a, b)| (Vec3::from(*a) + Vec3::from(*b)).to_array()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    fn document() -> Document {
        let face = rhytid_demo::face(1_000);
        let rig: Rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let mut document = Document::new(Arc::new(rig), "demo");
        let take = rhytid_demo::performance(&face);
        let incidents = Vec::new();
        document.set_take(OpenTake { name: "take".into(), take, incidents }).unwrap();
        document
    }

    fn drag(grabbed: &[usize], x: f32) -> Drag<'_> {
        Drag { grabbed, by: [x, 0.0, 0.0], reach: 0.0, mirrored: false, pinned: &[] }
    }

    #[test]
    fn a_pull_is_over_the_take_and_is_undone_as_one() {
        let mut document = document();
        document.transport.seek(40);
        let before = document.handles(true);
        assert_eq!(before, document.handles(false));
        document.begin_drag();
        for x in [0.1, 0.2, 0.5] {
            document.drag(drag(&[3], x));
        }
        document.end_drag(true);
        assert!((document.handles(true)[3][0] - before[3][0] - 0.5).abs() < 1e-5, "not the sum of all");
        document.transport.seek(41);
        let [pulled, not] = [true, false].map(|pulled| document.handles(pulled)[3][0]);
        assert!((pulled - not - 0.5).abs() < 1e-5, "in other frames too");
        document.transport.seek(40);
        assert!(document.undo());
        assert_eq!(document.handles(true), before);
        assert!(document.redo() && !document.redo());
        document.reset(&[]);
        assert_eq!(document.handles(true), before);
        assert!(document.undo());
        assert_ne!(document.handles(true), before);
    }

    #[test]
    fn a_drag_that_is_taken_back_leaves_nothing() {
        let mut document = document();
        document.begin_drag();
        document.drag(drag(&[0], 3.0));
        document.end_drag(false);
        assert_eq!(document.handles(true), document.handles(false));
        assert_eq!(document.can_undo_and_redo(), [false, false]);
    }

    #[test]
    fn a_take_of_other_markers_is_refused() {
        let mut document = document();
        let mut take = document.take().unwrap().take.clone();
        take.labels[0] = "other".into();
        let error = document.set_take(OpenTake { name: "t.csv".into(), take, incidents: vec![] });
        let error = error.unwrap_err().to_string();
        assert!(error.contains("t.csv: the take lacks 1 of the rig's"), "{error}");
        assert!(document.take().is_some(), "the one before stays");
    }

    #[test]
    fn a_frame_is_a_take_and_a_mesh() {
        let mut document = document();
        document.transport.seek(7);
        document.begin_drag();
        document.drag(drag(&[1], 0.25));
        document.end_drag(true);
        let take = document.frame_as_take();
        assert_eq!(
            take.handle_positions(&document.rig.handles().labels).unwrap(),
            document.handles(true).concat()
        );
        let mesh = document.frame_as_mesh(document.rig.surface().rest.as_flattened());
        assert_eq!(
            (mesh.positions.len(), &mesh.faces),
            (document.rig.vertices(), &document.rig.surface().faces)
        );
    }
}
