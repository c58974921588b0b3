//! The region of a face that edits affect. It is evaluated by itself, so the cost of edits grows with the
//! region.

use crate::context::Context;
use crate::edit_falloff::EditFalloff;
use crate::fade::VertexGain;
use rhytid_core::{Result, Rig, Stage, VertexId};
use rhytid_devices::Evaluator;
use std::ops::Range;

/// The vertices that edits affect.
pub(crate) struct AffectedRegion {
    /// The falloff of edits of markers.
    falloff: Option<EditFalloff>,
    /// The vertices that these edits or gains of the wrinkles change, ascending.
    vertices: Vec<VertexId>,
    /// A rig of these vertices, which come first. `None` where they are so much of the face that the whole
    /// face is evaluated.
    part: Option<Rig>,
}

/// The evaluations of some frames, beside the whole face without the edits of markers.
#[derive(Default)]
pub(crate) struct PartialEvaluation {
    /// The frames that edits of markers move: positions of the stage that is shown and, where anything fades,
    /// of the large scale.
    edited: Evaluated,
    /// The frames in which wrinkles are multiplied: positions of the large scale, without the edits of
    /// markers.
    large_scale: Evaluated,
}

/// Some frames of the region, at one or more stages.
#[derive(Default)]
struct Evaluated {
    numbers: Vec<usize>,
    results: Vec<Vec<f32>>,
}

/// A frame of the region: positions of each of its vertices, where they were evaluated.
#[derive(Clone, Copy)]
pub(crate) struct PartialFrame<'b> {
    /// Positions that are shown and, where anything fades, those of the large scale, with the edits of
    /// markers.
    pub edited: Option<[&'b [[f32; 3]]; 2]>,
    /// Positions of the large scale, without the edits of markers.
    pub large_scale: Option<&'b [[f32; 3]]>,
}

impl AffectedRegion {
    /// The region of edits of markers with this `falloff`, and of the wrinkles' `gains`. `None` where neither
    /// changes anything.
    pub(crate) fn new<'g>(
        rig: &Rig,
        falloff: Option<EditFalloff>,
        gains: impl Iterator<Item = &'g VertexGain>,
    ) -> Option<Self> {
        let gained = gains.flat_map(VertexGain::vertices);
        let mut vertices: Vec<VertexId> =
            gained.chain(falloff.iter().flat_map(EditFalloff::followers)).map(VertexId).collect();
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.is_empty() {
            return None;
        }
        let part = (2 * vertices.len() < rig.vertices()).then(|| rig.part(&vertices));
        if part.is_none() {
            vertices = (0..rig.vertices() as u32).map(VertexId).collect();
        }
        Some(Self { falloff, vertices, part })
    }

    /// The vertices, ascending.
    pub(crate) fn vertices(&self) -> &[VertexId] {
        &self.vertices
    }

    /// A rig of the vertices, which come first in it. `None` where the region is the whole rig.
    pub(crate) fn part(&self) -> Option<&Rig> {
        self.part.as_ref()
    }

    /// The falloff of edits of markers.
    pub(crate) fn falloff(&self) -> Option<&EditFalloff> {
        self.falloff.as_ref()
    }

    /// Evaluates those of these frames that edits of markers move, and the large scale of those that are
    /// gained.
    ///
    /// Where anything `fades`, the large scale of the edited frames is evaluated too. `evaluator` has the
    /// part.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub(crate) fn evaluate(
        &self,
        evaluator: &mut Evaluator<'_>,
        context: &Context<'_>,
        frames: Range<usize>,
        fades: bool,
        is_gained: impl Fn(usize) -> bool,
        partial: &mut PartialEvaluation,
    ) -> Result<()> {
        let (unedited, edited) = (context.unedited, context.edited);
        let moved = |frame: &usize| context.pose(unedited, *frame) != context.pose(edited, *frame);
        let moved = frames.clone().filter(moved).collect();
        let gained = frames.filter(|frame| is_gained(*frame)).collect();
        let stages = [context.shown(), Stage::LargeScale];
        let mut evaluate =
            |numbers: Vec<usize>, poses: &[[f32; 3]], stages: &[Stage], into: &mut Evaluated| {
                let handles: Vec<[f32; 3]> =
                    numbers.iter().flat_map(|frame| context.pose(poses, *frame)).copied().collect();
                into.numbers = numbers;
                into.results.resize(stages.len(), Vec::new());
                match handles.is_empty() {
                    true => Ok(()),
                    false => evaluator.evaluate(handles.as_flattened(), stages, &mut into.results),
                }
            };
        evaluate(moved, edited, if fades { &stages } else { &stages[..1] }, &mut partial.edited)?;
        evaluate(gained, unedited, &stages[1..], &mut partial.large_scale)
    }

    /// One of the evaluated frames.
    pub(crate) fn frame<'b>(&self, partial: &'b PartialEvaluation, number: usize) -> PartialFrame<'b> {
        let of_frame = |Evaluated { numbers, results }: &'b Evaluated, stage: usize| {
            let at = numbers.iter().position(|other| *other == number)?;
            let (results, _) = results.get(stage).map_or(&[][..], Vec::as_slice).as_chunks();
            let of_frame = results.len() / numbers.len();
            Some(results.get(at * of_frame..at * of_frame + self.vertices.len()).unwrap_or_default())
        };
        let stage = |stage| of_frame(&partial.edited, stage);
        PartialFrame {
            edited: stage(0).zip(stage(1)).map(|(shown, large_scale)| [shown, large_scale]),
            large_scale: of_frame(&partial.large_scale, 0),
        }
    }
}
