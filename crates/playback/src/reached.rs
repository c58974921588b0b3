//! What edits reach of a face: a part that is evaluated by itself, so that edits cost as much as they reach.

use crate::bounds::Bounds;
use crate::evaluator::Evaluator;
use crate::fade::VertexGain;
use rhytid_core::{Result, Rig, Stage};
use std::ops::Range;

/// The vertices that edits reach.
pub(crate) struct Reached {
    /// Where edits of markers are bounded.
    bounds: Option<Bounds>,
    /// Where these or gains of the folds do something, ascending.
    vertices: Vec<u32>,
    /// A rig of them, which come first; `None` where they are so much of the face that it is evaluated as a whole.
    part: Option<Rig>,
}

/// Poses of a take's frames, frames × H × 3 positions: without the edits of markers that are bounded, and with all edits.
pub(crate) type Poses<'t> = [&'t [f32]; 2];

/// What is evaluated of some frames beside the whole face as it is without the edits of markers.
#[derive(Default)]
pub(crate) struct OnceMore {
    /// Those that edits of markers move: positions of the stage that is shown and, where anything fades, of the large scale.
    edited: Evaluated,
    /// Those in which folds are multiplied: positions of the large scale, without the edits of markers.
    large_scale: Evaluated,
}

/// Some frames of what edits reach, of one or more stages.
#[derive(Default)]
struct Evaluated {
    numbers: Vec<usize>,
    results: Vec<Vec<f32>>,
}

/// A frame of what edits reach: positions of each vertex, where there are any to know.
#[derive(Clone, Copy)]
pub(crate) struct Local<'b> {
    /// As they are shown and, where anything fades, of the large scale, with the edits of markers.
    pub edited: Option<[&'b [[f32; 3]]; 2]>,
    /// Of the large scale, without.
    pub large_scale: Option<&'b [[f32; 3]]>,
}

impl Reached {
    /// Where edits of markers have these `bounds`, and folds are multiplied by `gains`; `None` where neither is to do anything.
    pub(crate) fn new<'g>(
        rig: &Rig,
        bounds: Option<Bounds>,
        gains: impl Iterator<Item = &'g VertexGain>,
    ) -> Option<Self> {
        let gained = gains.flat_map(VertexGain::vertices);
        let mut vertices: Vec<u32> = gained.chain(bounds.iter().flat_map(Bounds::held)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        if vertices.is_empty() {
            return None;
        }
        let part = (2 * vertices.len() < rig.vertices()).then(|| rig.part(&vertices));
        if part.is_none() {
            vertices = (0..rig.vertices() as u32).collect();
        }
        Some(Self { bounds, vertices, part })
    }

    /// The vertices, ascending.
    pub(crate) fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// A rig of the vertices, which come first in it; `None` where they are the whole rig's.
    pub(crate) fn part(&self) -> Option<&Rig> {
        self.part.as_ref()
    }

    /// Where edits of markers are bounded.
    pub(crate) fn bounds(&self) -> Option<&Bounds> {
        self.bounds.as_ref()
    }

    /// Evaluates of these frames those that edits of markers move, with their large scale where anything `fades`; and of those that are `gained`
    /// the large scale. `evaluator` has the part.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub(crate) fn evaluate(
        &self,
        evaluator: &mut Evaluator<'_>,
        (frames, [unedited, edited]): (Range<usize>, Poses<'_>),
        (fades, is_gained): (bool, impl Fn(usize) -> bool),
        stage: Stage,
        once_more: &mut OnceMore,
    ) -> Result<()> {
        let per_frame = 3 * evaluator.rig().handles.len();
        let of = |frame: usize| frame * per_frame..(frame + 1) * per_frame;
        let moved = frames.clone().filter(|frame| unedited[of(*frame)] != edited[of(*frame)]).collect();
        let gained = frames.filter(|frame| is_gained(*frame)).collect();
        let stages = [stage, Stage::LargeScale];
        let mut evaluate = |numbers: Vec<usize>, poses: &[f32], stages: &[Stage], into: &mut Evaluated| {
            let handles: Vec<f32> = numbers.iter().flat_map(|frame| &poses[of(*frame)]).copied().collect();
            into.numbers = numbers;
            into.results.resize(stages.len(), Vec::new());
            match handles.is_empty() {
                true => Ok(()),
                false => evaluator.evaluate(&handles, stages, &mut into.results),
            }
        };
        evaluate(moved, edited, if fades { &stages } else { &stages[..1] }, &mut once_more.edited)?;
        evaluate(gained, unedited, &stages[1..], &mut once_more.large_scale)
    }

    /// One of the frames that were evaluated.
    pub(crate) fn frame<'b>(&self, once_more: &'b OnceMore, number: usize) -> Local<'b> {
        let of_frame = |Evaluated { numbers, results }: &'b Evaluated, stage: usize| {
            let at = numbers.iter().position(|other| *other == number)?;
            let (results, _) = results.get(stage).map_or(&[][..], Vec::as_slice).as_chunks();
            let of_frame = results.len() / numbers.len();
            Some(results.get(at * of_frame..at * of_frame + self.vertices.len()).unwrap_or_default())
        };
        let stage = |stage| of_frame(&once_more.edited, stage);
        Local {
            edited: stage(0).zip(stage(1)).map(|(shown, large_scale)| [shown, large_scale]),
            large_scale: of_frame(&once_more.large_scale, 0),
        }
    }
}
