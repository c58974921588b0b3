//! The stages of a frame, one after the other over one context.
//!
//! [`Evaluate`] evaluates frames on the device, a batch at a time. Then [`Stages`] finishes each frame on the
//! host, in place.
//!
//! evaluate · edits begin · fade · untangle · contact · edits end · correct · refine · bake

use crate::affected_region::{AffectedRegion, PartialEvaluation, PartialFrame};
use crate::bake::bake;
use crate::contact::Contact;
use crate::context::{Context, stages};
use crate::correction::Correction;
use crate::edit_falloff::EditFalloff;
use crate::fade::Fade;
use crate::local_normals;
use crate::refined::Refined;
use crate::untangle::Untangle;
use rhytid_core::{Result, Rig, RigidMotion, Stage};
use rhytid_devices::Evaluator;
use std::ops::Range;

/// Whether frames of a rig are finished on the host, whatever is asked for: the buffers of a device do not
/// have whole frames then.
pub fn finishes_frames_on_host(rig: &Rig) -> bool {
    Untangle::is_for(rig) || Contact::is_for(rig)
}

/// The changes to frames after their evaluation.
#[derive(Default)]
pub(crate) struct FrameEffects<'c> {
    pub fade: Option<Fade<'c>>,
    pub region: Option<AffectedRegion>,
    pub corrections: &'c [Correction],
    pub untangle: Option<&'c Untangle<'c>>,
    pub contact: Option<&'c Contact<'c>>,
    pub refine: bool,
    /// The head pose that is baked into each frame.
    pub head: Option<&'c [RigidMotion]>,
}

impl FrameEffects<'_> {
    fn falloff(&self) -> Option<&EditFalloff> {
        self.region.as_ref().and_then(AffectedRegion::falloff)
    }
}

/// The device's results for some frames.
#[derive(Default)]
pub(crate) struct Batch {
    frames: Range<usize>,
    /// Positions, then normals if they are wanted, then the large scale if any frame may fade all over the
    /// face.
    results: Vec<Vec<f32>>,
    partial: PartialEvaluation,
}

/// The first stage: it evaluates positions, normals and the other stages' input for a batch of frames.
pub(crate) struct Evaluate<'e, 'a> {
    pub context: &'e Context<'e>,
    pub effects: &'e FrameEffects<'e>,
    pub evaluator: &'e mut Evaluator<'a>,
    /// The evaluator of the affected region; `None` where the whole face is evaluated instead.
    pub of_region: Option<Evaluator<'e>>,
}

impl Evaluate<'_, '_> {
    /// Whether a batch needs the large scale of the whole face. A batch in which nothing fades does not pay
    /// for it.
    fn fades_everywhere(&self, frames: &Range<usize>) -> bool {
        let Some(fade) = &self.effects.fade else { return false };
        let is_gained = || frames.clone().any(|frame| fade.is_gained(frame));
        fade.is_everywhere(frames.clone()) || self.of_region.is_none() && is_gained()
    }

    /// Evaluates a batch.
    ///
    /// # Errors
    /// As [`Evaluator::evaluate`].
    pub(crate) fn batch(&mut self, frames: Range<usize>, batch: &mut Batch) -> Result<()> {
        let (context, effects) = (self.context, self.effects);
        let [shown, vertex_normals] = stages(context.stage);
        let mut wanted = vec![shown];
        wanted.extend(context.normals.then_some(vertex_normals));
        wanted.extend(self.fades_everywhere(&frames).then_some(Stage::LargeScale));
        batch.results.resize(wanted.len(), Vec::new());
        batch.frames = frames.clone();
        let handles = context.rig.handles().len();
        let poses = &context.unedited[frames.start * handles..frames.end * handles];
        self.evaluator.evaluate(poses.as_flattened(), &wanted, &mut batch.results)?;
        let Some(region) = &effects.region else { return Ok(()) };
        let has_part = self.of_region.is_some();
        let is_gained = |frame| has_part && effects.fade.as_ref().is_some_and(|fade| fade.is_gained(frame));
        let fades = effects.fade.is_some();
        match &mut self.of_region {
            Some(part) => region.evaluate(part, context, frames, fades, is_gained, &mut batch.partial),
            None => region.evaluate(self.evaluator, context, frames, fades, is_gained, &mut batch.partial),
        }
    }
}

impl Batch {
    /// The batch's frames one after the other, each with its results for the affected region.
    pub(crate) fn frames<'b>(
        &'b mut self,
        context: &'b Context<'_>,
        effects: &'b FrameEffects<'_>,
    ) -> impl Iterator<Item = (FrameBuffers<'b>, Option<PartialFrame<'b>>)> {
        let vertices = context.rig.vertices();
        let Self { frames, results, partial } = self;
        let partial = &*partial;
        let mut each: Vec<_> =
            results.iter_mut().map(|results| results.as_chunks_mut().0.chunks_exact_mut(vertices)).collect();
        frames.clone().map(move |number| {
            let mut results = each.iter_mut().map(|results| results.next().unwrap_or_default());
            let positions = results.next().unwrap_or_default();
            let normals =
                if context.normals { results.next().unwrap_or_default() } else { Default::default() };
            let large_scale = results.next().map(|large_scale| &*large_scale);
            let partial = effects.region.as_ref().map(|region| region.frame(partial, number));
            (FrameBuffers { number, positions, normals, large_scale }, partial)
        })
    }
}

/// A frame as the device gave it, without the edits of markers that have a falloff. The stages finish it in
/// place.
pub(crate) struct FrameBuffers<'b> {
    pub number: usize,
    /// V.
    pub positions: &'b mut [[f32; 3]],
    /// V; empty where normals are not wanted.
    pub normals: &'b mut [[f32; 3]],
    /// V positions of the large scale, if the frame may fade all over the face.
    large_scale: Option<&'b [[f32; 3]]>,
}

/// The stages on the host.
pub(crate) struct Stages<'c> {
    context: &'c Context<'c>,
    effects: &'c FrameEffects<'c>,
    refined: Option<Refined<'c>>,
    /// The largest distance that each correction moved a vertex in each frame so far, in mesh units.
    pub corrected: Vec<Vec<f64>>,
    /// V: whether the vertex follows edits of markers.
    is_edited: Vec<bool>,
    /// V: whether edits of markers change the vertex's normal.
    is_beside: Vec<bool>,
    /// V positions of the large scale. Only those that edits affect are set.
    large_scale: Vec<[f32; 3]>,
    /// The frame with the edits of markers, if it has any.
    with_edits: WithEdits,
}

/// A frame with the edits of markers, between the stages “edits begin” and “edits end”.
#[derive(Default)]
struct WithEdits {
    is_there: bool,
    /// V positions. `large_scale` has those of their large scale.
    positions: Vec<[f32; 3]>,
    large_scale: Vec<[f32; 3]>,
}

impl<'c> Stages<'c> {
    /// The stages, with the refinement if frames are refined.
    pub(crate) fn new(
        context: &'c Context<'c>,
        effects: &'c FrameEffects<'c>,
        refined: Option<Refined<'c>>,
    ) -> Self {
        let falloff = effects.falloff();
        let beside = |falloff: &EditFalloff| {
            local_normals::beside(context.rig, context.triangles, falloff.followers())
        };
        let mut is_edited = vec![false; context.rig.vertices()];
        falloff.iter().flat_map(|falloff| falloff.followers()).for_each(|v| is_edited[v as usize] = true);
        Self {
            context,
            effects,
            refined,
            corrected: vec![Vec::new(); effects.corrections.len()],
            is_edited,
            is_beside: falloff.map(beside).unwrap_or_default(),
            large_scale: Vec::new(),
            with_edits: WithEdits::default(),
        }
    }

    /// Finishes a frame. Vertices that no stage changes keep every bit.
    pub(crate) fn frame(&mut self, frame: &mut FrameBuffers<'_>, partial: Option<PartialFrame<'_>>) {
        let large_scale = self.large_scale_of(frame, partial);
        self.edits_begin(frame, large_scale, partial);
        self.fade(frame, large_scale);
        self.untangle(frame);
        self.contact(frame);
        self.edits_end(frame);
        self.correct(frame);
        self.refine(frame);
        self.bake(frame);
    }

    /// V positions of the large scale; empty where nothing fades.
    fn large_scale_of<'b>(
        &mut self,
        frame: &FrameBuffers<'b>,
        partial: Option<PartialFrame<'_>>,
    ) -> LargeScale<'b> {
        let found = partial.and_then(|partial| partial.large_scale);
        match (frame.large_scale, found) {
            (Some(all), _) => LargeScale::Whole(all),
            (None, None) => LargeScale::Whole(&[]),
            (None, Some(found)) => {
                self.large_scale.resize(self.context.rig.vertices(), [0.0; 3]);
                let vertices = self.effects.region.as_ref().map_or(&[][..], AffectedRegion::vertices);
                vertices.iter().zip(found).for_each(|(&v, x)| self.large_scale[v.index()] = *x);
                LargeScale::OfRegion
            }
        }
    }

    /// Makes the whole frame with the edits of markers. It is whole because turning a triangle back depends
    /// on all triangles around it.
    fn edits_begin(
        &mut self,
        frame: &FrameBuffers<'_>,
        large_scale: LargeScale<'_>,
        partial: Option<PartialFrame<'_>>,
    ) {
        let edited = partial.and_then(|partial| partial.edited);
        self.with_edits.is_there = false;
        let (Some(falloff), Some([positions, smooth])) = (self.effects.falloff(), edited) else { return };
        let vertices = self.effects.region.as_ref().map_or(&[][..], AffectedRegion::vertices);
        let large_scale = large_scale.resolve(&self.large_scale);
        let blend = |into: &mut Vec<[f32; 3]>, without: &[[f32; 3]], with: &[[f32; 3]]| {
            into.clear();
            into.extend_from_slice(without);
            if !without.is_empty() {
                for (&v, x) in vertices.iter().zip(with) {
                    into[v.index()] = falloff.between(v.index(), without[v.index()], *x);
                }
            }
        };
        blend(&mut self.with_edits.positions, frame.positions, positions);
        blend(&mut self.with_edits.large_scale, large_scale, smooth);
        self.with_edits.is_there = true;
    }

    /// Makes wrinkles stronger or weaker.
    fn fade(&mut self, frame: &mut FrameBuffers<'_>, large_scale: LargeScale<'_>) {
        let Some(fade) = &self.effects.fade else { return };
        let WithEdits { is_there, positions, large_scale: smooth } = &mut self.with_edits;
        if *is_there {
            fade.frame(frame.number, smooth, positions, &mut []);
        }
        fade.frame(frame.number, large_scale.resolve(&self.large_scale), frame.positions, frame.normals);
    }

    /// Turns back triangles that the fine detail turns over.
    fn untangle(&mut self, frame: &mut FrameBuffers<'_>) {
        let Some(untangle) = self.effects.untangle else { return };
        let context = self.context;
        let edited = context.pose(context.edited, frame.number);
        if self.with_edits.is_there {
            untangle.frame_at(&self.is_edited, edited, &mut self.with_edits.positions, &mut []);
            let unedited = context.pose(context.unedited, frame.number);
            untangle.frame(unedited, frame.positions, frame.normals);
        } else {
            untangle.frame(edited, frame.positions, frame.normals);
        }
    }

    /// Keeps parts from going into each other, and turns back triangles that this turns over.
    fn contact(&mut self, frame: &mut FrameBuffers<'_>) {
        let Some(contact) = self.effects.contact else { return };
        let (untangle, context) = (self.effects.untangle, self.context);
        let keep = |poses, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]| {
            let handles = context.pose(poses, frame.number);
            let moved = contact.frame(positions, normals);
            if let Some(untangle) = untangle {
                untangle.frame_at(&moved, handles, positions, normals);
            }
        };
        if self.with_edits.is_there {
            keep(context.edited, &mut self.with_edits.positions, &mut []);
            keep(context.unedited, frame.positions, frame.normals);
        } else {
            keep(context.edited, frame.positions, frame.normals);
        }
    }

    /// Copies the vertices that follow the edits of markers into the frame.
    fn edits_end(&mut self, frame: &mut FrameBuffers<'_>) {
        let (Some(falloff), true) = (self.effects.falloff(), self.with_edits.is_there) else { return };
        falloff.followers().for_each(|v| frame.positions[v as usize] = self.with_edits.positions[v as usize]);
        let Context { rig, triangles, .. } = self.context;
        local_normals::update_where(&self.is_beside, rig, triangles, frame.positions, frame.normals);
    }

    /// Adds the sculpted corrections.
    fn correct(&mut self, frame: &mut FrameBuffers<'_>) {
        let Context { rig, triangles, times, edited, .. } = self.context;
        for (correction, moved) in self.effects.corrections.iter().zip(&mut self.corrected) {
            let handles = self.context.pose(edited, frame.number);
            let time = times[frame.number];
            moved.push(correction.apply(rig, triangles, time, handles, frame.positions, frame.normals));
        }
    }

    /// Makes the surface as rigid as possible.
    fn refine(&mut self, frame: &mut FrameBuffers<'_>) {
        if let Some(refined) = &mut self.refined {
            let pose = self.context.pose(self.context.edited, frame.number);
            refined.frame(pose, frame.positions, frame.normals);
        }
    }

    /// Moves the frame as the head moves.
    fn bake(&self, frame: &mut FrameBuffers<'_>) {
        if let Some(head) = self.effects.head {
            bake(&head[frame.number], frame.positions, frame.normals);
        }
    }
}

/// Where the large scale of a frame is.
#[derive(Clone, Copy)]
enum LargeScale<'b> {
    /// As the device gave it; empty where nothing fades.
    Whole(&'b [[f32; 3]]),
    /// In [`Stages::large_scale`], at the vertices of the region.
    OfRegion,
}

impl<'b> LargeScale<'b> {
    fn resolve(self, of_region: &'b [[f32; 3]]) -> &'b [[f32; 3]] {
        match self {
            Self::Whole(all) => all,
            Self::OfRegion => of_region,
        }
    }
}
