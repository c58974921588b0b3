//! The document's pulls: made by drags, changed, deleted and saved.

use super::{Document, Pose, TimelineEvent};
use crate::pulls::{Pull, Span, When, sum};
use crate::soft_selection::Drag;
use rhytid_formats::edits::Offset;

/// When new pulls act.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewPulls {
    /// In which frames, from the frame that is shown.
    pub when: When,
    /// Seconds in which they come and go.
    pub ease: [f64; 2],
}

/// A drag that goes on.
#[derive(Debug)]
pub(super) struct DragStart {
    /// The pose before it.
    pub(super) pose: Pose,
    /// When a new pull of this drag acts.
    pub(super) span: Span,
}

impl Document {
    /// H vectors in mesh units: the moves by all pulls in a frame. Live frames and a face without a take have
    /// those pulls that act in all frames.
    pub(super) fn pulled(&self, frame: usize) -> Vec<[f64; 3]> {
        let (handles, rate) = (self.rest.len(), self.transport.rate());
        let is_timed = self.take.is_some() && self.live.is_none();
        let acting: Vec<&Pull> =
            self.pose.pulls.iter().filter(|pull| is_timed || pull.span.when == When::Whole).collect();
        let mut moved = match self.shown_edits() {
            Some(edits) => edits.layers.let_through(frame, &|frame| sum(&acting, handles, rate, frame)),
            None => sum(&acting, handles, rate, frame),
        };
        let units = 1.0 / self.millimetres();
        moved.iter_mut().for_each(|by| *by = by.map(|x| x * units));
        moved
    }

    /// How far the pulls move a handle in the frame that is shown, in millimetres.
    pub(crate) fn pulled_here(&self, handle: usize) -> [f64; 3] {
        self.pulled(self.transport.frame())[handle].map(|x| x * self.millimetres())
    }

    /// Millimetres in one mesh unit.
    fn millimetres(&self) -> f64 {
        1e3 * self.rig.surface().metres_per_unit
    }

    /// Begins a drag. All changes up to its end are one step to undo.
    pub fn begin_drag(&mut self) {
        self.dragging = Some(DragStart { pose: self.pose.clone(), span: self.span_here() });
    }

    /// The span of a new pull. Where no take is shown, it acts in all frames.
    fn span_here(&self) -> Span {
        let is_timed = self.transport.frames() > 1 && self.live.is_none();
        let when = if is_timed { self.new_pulls.when } else { When::Whole };
        Span::new(when, self.transport.frame(), self.new_pulls.ease)
    }

    /// Drags handles by an amount that is counted from the beginning of the drag. Without one, it is counted
    /// from the present pose. The pull of the same span is changed. So is the selected pull at frames, if the
    /// drag is in these frames. Otherwise, the drag makes a new pull.
    pub fn drag(&mut self, drag: Drag<'_>) {
        let moved = self.soft_selection.drag(drag);
        let (mut pulls, span) = match &self.dragging {
            Some(start) => (start.pose.pulls.clone(), start.span),
            None => (self.pose.pulls.clone(), self.span_here()),
        };
        let fits = |pull: &Pull| {
            span.when == When::At && pull.span.when == When::At && pull.span.is_full_at(span.frames[0])
        };
        let selected = self.selected_pull.filter(|i| pulls.get(*i).is_some_and(fits));
        let same = || pulls.iter().position(|pull| pull.span == span);
        let index = selected.or_else(same).unwrap_or(pulls.len());
        if index == pulls.len() {
            pulls.push(Pull::still(span, self.rest.len()));
        }
        pulls[index].add(&moved, self.millimetres());
        self.pose.pulls = pulls;
        self.selected_pull = Some(index);
    }

    /// Ends the drag. If `keep` is false, the drag is undone.
    pub fn end_drag(&mut self, keep: bool) {
        if let Some(DragStart { pose: before, .. }) = self.dragging.take() {
            self.pose.pulls.retain(Pull::moves);
            match keep {
                true if before != self.pose => self.history.record(before),
                true => {}
                false => self.pose = before,
            }
        }
    }

    /// The selected pull.
    pub fn selected_pull(&self) -> Option<usize> {
        self.selected_pull.filter(|i| *i < self.pose.pulls.len())
    }

    /// Selects a pull.
    pub fn select_pull(&mut self, pull: Option<usize>) {
        self.selected_pull = pull;
    }

    /// Gives the selected pull another span. During a drag of a field, this is a part of it.
    pub fn change_pull(&mut self, span: Span) {
        let Some(i) = self.selected_pull() else { return };
        match self.is_dragging() {
            true => self.pose.pulls[i].span = span.rounded(),
            false => self.change(|pose| pose.pulls[i].span = span.rounded()),
        }
    }

    /// Deletes the selected pull.
    pub fn delete_pull(&mut self) {
        if let Some(i) = self.selected_pull() {
            self.change(|pose| {
                pose.pulls.remove(i);
            });
            self.selected_pull = None;
        }
    }

    /// The pulls as edits of the take. None where nothing was pulled.
    pub fn pull_edits(&self) -> Vec<Offset> {
        let rate = self.transport.rate();
        self.pose.pulls.iter().map(|pull| pull.offset(&self.rig, rate)).collect()
    }

    /// Whether there are pulls that were not saved as they are.
    pub fn has_unsaved_pulls(&self) -> bool {
        !self.pose.pulls.is_empty() && self.pose.pulls != self.saved_pulls
    }

    /// Takes note that the pulls have been saved, or that they may be lost.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn pulls_are_saved(&mut self) {
        self.saved_pulls = self.pose.pulls.clone();
    }

    /// Resets these handles to the take's positions. Without a handle, resets all.
    pub fn reset(&mut self, handles: &[usize]) {
        self.change(|pose| {
            for pull in &mut pose.pulls {
                match handles {
                    [] => pull.millimetres.fill([0.0; 3]),
                    some => some.iter().for_each(|&handle| pull.millimetres[handle] = [0.0; 3]),
                }
            }
            pose.pulls.retain(Pull::moves);
        });
    }

    /// The pulls, with their places on the time line.
    pub(crate) fn pull_events(&self) -> impl Iterator<Item = TimelineEvent> {
        let (rate, frames) = (self.transport.rate(), self.transport.frames());
        self.pose.pulls.iter().map(move |pull| pull.event(&self.rig, rate, frames))
    }
}
