//! The open document: a rig, a take, and the drags of markers.

mod pulled;

pub use pulled::NewPulls;

use crate::edits::{EditedFrame, OpenEdits};
use crate::events::doubts;
use crate::history::History;
use crate::open_mesh::MeshFrames;
use crate::problems::{Problem, ProblemKind, strains};
use crate::pulls::{Pull, When};
use crate::same::Same;
use crate::soft_selection::SoftSelection;
use crate::transport::Transport;
use glam::Vec3;
use pulled::DragStart;
use rhytid_capture::{Edit, StrainLimit, TakeSpace, Target};
use rhytid_core::{Error, Mesh, Result, Rig, Take};
use rhytid_formats::mesh::Numbers;
use std::sync::Arc;

/// The pulls of markers, on top of the take. Undo and redo change them.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// They are added to the take's handle positions.
    pub pulls: Vec<Pull>,
    /// H: the handles that stay where they are while others are dragged.
    pub pinned: Vec<bool>,
}

/// An event of a take that the time line shows.
#[derive(Debug, Clone, PartialEq)]
pub struct TimelineEvent {
    /// Its first frame. `frames` is the number of its frames.
    pub first: usize,
    /// At least 1.
    pub frames: usize,
    /// A description with the name of the marker.
    pub words: String,
    /// The confidence of its samples, from 0 to 1.
    pub confidence: f32,
    /// Whether it is one of the many gaps that a raw take has, and was filled.
    pub is_filled_gap: bool,
    /// What is wrong in these frames. `None` where nothing is wrong any more.
    pub problem: Option<ProblemKind>,
    /// The markers that it is about, as handles of the rig. Empty for the head.
    pub handles: Vec<usize>,
}

impl TimelineEvent {
    /// An event that is no problem and concerns no marker.
    pub fn new(first: usize, frames: usize, words: String) -> Self {
        Self {
            first,
            frames,
            words,
            confidence: 1.0,
            is_filled_gap: false,
            problem: None,
            handles: Vec::new(),
        }
    }
}

/// A take that was opened.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenTake {
    /// Its name.
    pub name: String,
    /// The take itself.
    pub take: Take,
    /// What was found in it: by the clean-up, or strains of a clean take.
    pub incidents: Vec<TimelineEvent>,
    /// How it was read.
    pub reading: Reading,
}

/// What the user said of a take before it was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reading {
    /// The repairs by hand.
    pub repairs: Vec<Edit>,
    /// The unit and axes of a clean take that is not in the rig's space.
    pub space: Option<TakeSpace>,
}

/// A rig, a take on it, and the pose.
#[derive(Debug)]
pub struct Document {
    /// The rig.
    pub rig: Arc<Rig>,
    /// Its name.
    pub name: String,
    /// H positions in mesh units.
    rest: Vec<[f32; 3]>,
    take: Option<OpenTake>,
    /// frames × H × 3 of the take.
    positions: Vec<f32>,
    /// The take's edits, if any.
    edits: Option<OpenEdits>,
    edited: bool,
    /// The stretches in which markers are in doubt, of a take that was not cleaned here.
    doubts: Vec<TimelineEvent>,
    /// Numbers of a file. Each set has one for every vertex.
    numbers: Same<Vec<Numbers>>,
    /// The frames of a mesh without a rig.
    mesh: Option<Same<MeshFrames>>,
    /// Live positions, H × 3, and the confidence of each handle. They replace the take's.
    live: Option<(Vec<f32>, Vec<f32>)>,
    /// The play head.
    pub transport: Transport,
    soft_selection: SoftSelection,
    /// How far the skin between handles can be believed to stretch.
    strain_limits: Vec<StrainLimit>,
    pose: Pose,
    history: History<Pose>,
    dragging: Option<DragStart>,
    /// When new pulls act.
    pub new_pulls: NewPulls,
    selected_pull: Option<usize>,
    /// The pulls that were saved last.
    saved_pulls: Vec<Pull>,
}

impl Document {
    /// A rig at rest.
    pub fn new(rig: Arc<Rig>, name: &str) -> Self {
        let rest = rig.handles().rest.clone();
        let pose = Pose { pulls: Vec::new(), pinned: vec![false; rest.len()] };
        Self {
            soft_selection: SoftSelection::new(&rig),
            strain_limits: Target::from_rig(&rig).strains,
            name: name.to_owned(),
            take: None,
            positions: Vec::new(),
            edits: None,
            edited: true,
            doubts: Vec::new(),
            numbers: Same::new(Vec::new()),
            mesh: None,
            live: None,
            transport: Transport::new(&[0.0], 30.0),
            pose,
            history: History::default(),
            dragging: None,
            new_pulls: NewPulls { when: When::Whole, ease: [0.2; 2] },
            selected_pull: None,
            saved_pulls: Vec::new(),
            rest,
            rig,
        }
    }

    /// A mesh without a rig, which plays its own frames. `rig` has its surface.
    pub(crate) fn of_mesh(rig: Arc<Rig>, name: &str, frames: Same<MeshFrames>) -> Self {
        let mut transport = Transport::new(&frames.times, frames.rate);
        transport.playing = frames.times.len() > 1;
        Self { transport, mesh: Some(frames), ..Self::new(rig, name) }
    }

    /// Whether it is a mesh without a rig. It has no markers.
    pub fn is_mesh(&self) -> bool {
        self.mesh.is_some()
    }

    /// Plays a take from now on. The pose stays. A take of the same name and times goes on where it was.
    ///
    /// # Errors
    /// [`Error::Input`] if the take lacks a handle, or has no frame.
    pub fn set_take(&mut self, open: OpenTake) -> Result<()> {
        let in_file = |error: Error| error.in_file(&open.name);
        let positions = open.take.handle_positions(&self.rig.handles().labels).map_err(in_file)?;
        if positions.is_empty() {
            return Err(in_file(Error::empty("has no frame, expected at least one")));
        }
        let columns: Vec<usize> = (self.rig.handles().labels.iter())
            .filter_map(|label| open.take.labels.iter().position(|other| other == label))
            .collect();
        // The clean-up has found them already. A take that was not cleaned has strains alone.
        let is_cleaned = open.incidents.iter().any(|event| event.problem != Some(ProblemKind::Strain));
        self.doubts = if is_cleaned { Vec::new() } else { doubts(&open.take, &columns) };
        // A take that was repaired goes on where it was.
        if self
            .take
            .as_ref()
            .is_none_or(|before| before.name != open.name || before.take.times != open.take.times)
        {
            self.transport = Transport::new(&open.take.times, open.take.rate());
        }
        self.positions = positions;
        self.edits = None;
        self.take = Some(open);
        Ok(())
    }

    /// The take.
    pub fn take(&self) -> Option<&OpenTake> {
        self.take.as_ref()
    }

    /// The names of the open files, for the window's title.
    pub fn title(&self) -> String {
        let short = |name: &str| {
            let last = std::path::Path::new(name).file_name();
            last.map_or_else(|| name.to_owned(), |last| last.to_string_lossy().into_owned())
        };
        let take = self.take.as_ref().map(|take| short(&take.name));
        let edits = self.edits.as_ref().map(|edits| short(&edits.name));
        let names: Vec<String> = std::iter::once(short(&self.name)).chain(take).chain(edits).collect();
        format!("{} – Rhytid", names.join(", "))
    }

    /// Shows the take with edits from now on.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn set_edits(&mut self, edits: OpenEdits) {
        self.edits = Some(edits);
        self.edited = true;
    }

    /// The name of the take's edits, and whether they are shown.
    pub fn edits(&self) -> Option<(&str, bool)> {
        self.edits.as_ref().map(|edits| (&*edits.name, self.edited))
    }

    /// Shows the take with or without its edits.
    pub fn show_edited(&mut self, edited: bool) {
        self.edited = edited;
    }

    /// The edits that are shown. `None` where they or the take are not shown.
    fn shown_edits(&self) -> Option<&OpenEdits> {
        self.edits.as_ref().filter(|_| self.edited && self.live.is_none())
    }

    /// The edits that are shown, as their file has them.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn shown_layers(&self) -> Option<&crate::edits::Layers> {
        self.shown_edits().map(|edits| &*edits.layers)
    }

    /// The effects of edits on a frame, apart from moves of handles. Live frames and a face without a take
    /// follow pulls as a whole.
    pub(crate) fn frame_edits_at(&self, frame: usize) -> Option<EditedFrame> {
        let time = self.take.as_ref().filter(|_| !self.is_live())?.take.times.get(frame).copied()?;
        let edits = self.shown_edits();
        let mut moved = edits.map_or_else(|| vec![false; self.rest.len()], |edits| edits.moved.clone());
        for pull in &self.pose.pulls {
            let of_pull = moved.iter_mut().zip(&pull.millimetres);
            of_pull.for_each(|(moved, by)| *moved |= *by != [0.0; 3]);
        }
        let has_falloff = moved.contains(&true) && moved.contains(&false);
        let without = has_falloff.then(|| self.handles_at(frame, false));
        let without = without.filter(|without| *without != self.handles_at(frame, true));
        let edits = edits.map(|edits| edits.on_frames.clone());
        let touches = edits.as_ref().is_some_and(|edits| edits.touches(time));
        (without.is_some() || touches).then_some(EditedFrame { edits, time, moved, without })
    }

    /// What was found in the take: by the clean-up, or else where markers are in doubt.
    pub(crate) fn findings(&self) -> impl Iterator<Item = &TimelineEvent> {
        self.take.iter().flat_map(|open| &open.incidents).chain(&self.doubts)
    }

    /// The frames that the edits change. None where the edits are not shown.
    pub(crate) fn edit_spans(&self) -> &[TimelineEvent] {
        self.shown_edits().map_or(&[], |edits| &edits.spans)
    }

    /// Offers these numbers for display: each set has a name and V numbers. NaN marks a vertex without a
    /// counterpart.
    pub fn set_numbers(&mut self, numbers: Vec<Numbers>) {
        self.numbers = Same::new(numbers);
    }

    /// The numbers that can be shown.
    pub fn numbers(&self) -> &[Numbers] {
        &self.numbers
    }

    /// The name of a set of numbers. Empty where there is none.
    pub(crate) fn numbers_name(&self, which: usize) -> &str {
        self.numbers.get(which).map_or("", |(name, _)| name)
    }

    /// The same, for another thread.
    pub(crate) fn shared_numbers(&self) -> Same<Vec<Numbers>> {
        self.numbers.clone()
    }

    /// Shows H × 3 live positions in place of the take's, and H confidences from 0 to 1. `None` shows the
    /// take again.
    pub fn set_live(&mut self, frame: Option<(Vec<f32>, Vec<f32>)>) {
        self.live = frame;
    }

    /// H: the confidence of each handle of a live frame, from 0 to 1. Empty where no live frame is shown.
    pub fn live_confidence(&self) -> &[f32] {
        self.live.as_ref().map_or(&[], |(_, confidence)| confidence)
    }

    /// Whether live positions are shown.
    pub fn is_live(&self) -> bool {
        self.live.is_some()
    }

    /// H positions of the frame that is shown, in mesh units and head space: with edits and drags, or without
    /// both.
    pub fn handles(&self, dragged: bool) -> Vec<[f32; 3]> {
        self.handles_at(self.transport.frame(), dragged)
    }

    /// The same of another frame.
    pub(crate) fn handles_at(&self, frame: usize, dragged: bool) -> Vec<[f32; 3]> {
        let per_frame = 3 * self.rest.len();
        let edited = self.shown_edits().filter(|_| dragged).map(|edits| &edits.positions);
        let positions = edited.unwrap_or(&self.positions);
        let base = match (&self.live, positions.get(frame * per_frame..(frame + 1) * per_frame)) {
            (Some((live, _)), _) => live.as_chunks::<3>().0,
            (None, Some(frame)) => frame.as_chunks::<3>().0,
            (None, None) => &self.rest,
        };
        if !dragged {
            return base.to_vec();
        }
        sums(base, &self.pulled(frame))
    }

    /// What is wrong with the markers in the frame that is shown: what the clean-up found there, and strains
    /// that no skin has.
    pub fn problems(&self) -> Vec<Problem> {
        self.problems_at(self.transport.frame())
    }

    /// The same in another frame.
    pub(crate) fn problems_at(&self, frame: usize) -> Vec<Problem> {
        let handles = self.handles_at(frame, true);
        let labels = &self.rig.handles().labels;
        let mut problems = strains(&self.strain_limits, &handles, &self.rig.handles().rest, labels);
        for incident in self.findings().filter(|_| !self.is_live()) {
            let is_here = (incident.first..incident.first + incident.frames).contains(&frame);
            // Strains are those of the frame as it is shown, with edits and drags.
            if let Some(kind) = incident.problem.filter(|kind| is_here && *kind != ProblemKind::Strain) {
                let (handles, words) = (incident.handles.clone(), incident.words.clone());
                problems.push(Problem { kind, handles, words });
            }
        }
        problems
    }

    /// How far a handle is from rest in the frame that is shown, in millimetres: x, y, z, and the length.
    pub fn from_rest(&self, handle: usize) -> [f32; 4] {
        let moved = Vec3::from(self.handles(true)[handle]) - Vec3::from(self.rest[handle]);
        let [x, y, z] = (1e3 * self.rig.surface().metres_per_unit as f32 * moved).to_array();
        [x, y, z, Vec3::new(x, y, z).length()]
    }

    /// The pulls of markers, and which handles are pinned.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// The soft selection: which handles follow which.
    pub fn soft_selection(&self) -> &SoftSelection {
        &self.soft_selection
    }

    /// Whether handles are being dragged.
    pub fn is_dragging(&self) -> bool {
        self.dragging.is_some()
    }

    /// Pins handles, or unpins them if all of them are pinned.
    pub fn toggle_pins(&mut self, handles: &[usize]) {
        self.change(|pose| {
            let all = handles.iter().all(|&handle| pose.pinned[handle]);
            handles.iter().for_each(|&handle| pose.pinned[handle] = !all);
        });
    }

    fn change(&mut self, change: impl FnOnce(&mut Pose)) {
        let before = self.pose.clone();
        change(&mut self.pose);
        if before != self.pose {
            self.history.record(before);
        }
    }

    /// Undoes the last change. The result is whether there was one.
    pub fn undo(&mut self) -> bool {
        self.end_drag(true);
        self.history.undo(&mut self.pose)
    }

    /// Redoes the last change that was undone. The result is whether there was one.
    pub fn redo(&mut self) -> bool {
        self.history.redo(&mut self.pose)
    }

    /// Whether there is a change to undo, and one to redo.
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

    /// A frame as a mesh that can be an example of the rig: its V × 3 `positions` with the rig's polygons and
    /// texture coordinates.
    pub fn frame_as_mesh(&self, positions: &[f32]) -> Mesh {
        as_mesh(&self.rig, positions)
    }
}

/// V × 3 `positions` with the polygons and texture coordinates of `rig`.
pub(crate) fn as_mesh(rig: &Rig, positions: &[f32]) -> Mesh {
    Mesh {
        positions: positions.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect(),
        faces: rig.surface().faces.clone(),
        uvs: rig.surface().uvs.clone(),
        materials: rig.surface().materials.clone(),
    }
}

/// The sum of each pair of vectors.
fn sums(positions: &[[f32; 3]], moves: &[[f64; 3]]) -> Vec<[f32; 3]> {
    let pairs = positions.iter().zip(moves);
    pairs.map(|(x, by)| std::array::from_fn(|c| (f64::from(x[c]) + by[c]) as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::soft_selection::Drag;
    use rhytid_core::NoProgress;

    fn document() -> Document {
        let face = rhytid_demo::face(1_000);
        let rig: Rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let mut document = Document::new(Arc::new(rig), "demo");
        let take = rhytid_demo::performance(&face);
        let incidents = Vec::new();
        document
            .set_take(OpenTake { name: "take".into(), take, incidents, reading: Reading::default() })
            .unwrap();
        document
    }

    fn drag(grabbed: &[usize], x: f32) -> Drag<'_> {
        Drag { grabbed, by: [x, 0.0, 0.0], reach: 0.0, mirrored: false, pinned: &[] }
    }

    #[test]
    fn a_drag_is_over_the_take_and_is_undone_as_one() {
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
        let [dragged, not] = [true, false].map(|dragged| document.handles(dragged)[3][0]);
        assert!((dragged - not - 0.5).abs() < 1e-5, "in other frames too");
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
    fn each_frame_has_its_own_problems_wherever_the_play_head_is() {
        let mut document = document();
        document.new_pulls = NewPulls { when: When::At, ease: [0.0; 2] };
        document.transport.seek(40);
        document.begin_drag();
        document.drag(drag(&[3], 30.0));
        document.end_drag(true);
        for head in [40, 80] {
            document.transport.seek(head);
            assert!(document.problems_at(40).iter().any(|problem| problem.handles.contains(&3)));
            assert_eq!(document.problems_at(80), []);
            assert_eq!(document.problems(), document.problems_at(head));
        }
    }

    #[test]
    fn a_take_of_other_markers_is_refused() {
        let mut document = document();
        let mut take = document.take().unwrap().take.clone();
        take.labels[0] = "other".into();
        let error = document.set_take(OpenTake {
            name: "t.csv".into(),
            take,
            incidents: vec![],
            reading: Reading::default(),
        });
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
