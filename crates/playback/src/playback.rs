//! Playback: a take on a rig, frame by frame. Exports write these frames, and verification compares a file
//! with them.

use crate::affected_region::AffectedRegion;
use crate::channels::{ChannelSources, EvaluatedFrame};
use crate::contact::Contact;
use crate::context::{Context, stages};
use crate::correction::{Correction, Sculpted};
use crate::edit_falloff::EditFalloff;
use crate::fade::{Fade, VertexGain};
use crate::refined::Refined;
use crate::selection::Selection;
use crate::stages::{Batch, Evaluate, FrameBuffers, FrameEffects, Stages};
use crate::untangle::Untangle;
use crate::velocities::Velocities;
use crate::{EditedTake, Layers, batch, layers, pipeline};
use rhytid_core::{
    ChannelKind, DeviceInfo, Error, Progress, Remedy, Result, Rig, UploadOptions, Warning, human,
};
use rhytid_devices::Evaluator;
use rhytid_formats::export::{ChannelChoice, Frame, HeadMotion, OutputStage, Recipe};
use rhytid_kernels::normals::VertexTriangles;
use std::sync::Arc;

/// A rig on a device, and the devices that take over if that one fails.
pub struct Playback<'a> {
    rig: &'a Rig,
    evaluator: Evaluator<'a>,
    /// Frames in a batch.
    batch: usize,
    /// The gains of the wrinkles, which multiply each other.
    gains: Arc<[VertexGain]>,
    /// The sculpted corrections, in order.
    corrections: Arc<[Correction]>,
    /// The largest distance that each correction moved a vertex, in mesh units, in each frame of the last
    /// play. The frames around the inner ones are included.
    corrected: Vec<Vec<f64>>,
    triangles: Arc<VertexTriangles>,
    /// `None` for a rig without learned detail.
    untangle: Option<Arc<Untangle<'a>>>,
    /// `None` for a rig in which nothing touches.
    contact: Option<Arc<Contact<'a>>>,
}

impl<'a> Playback<'a> {
    /// Makes `rig` resident on the first of `devices` that has room for it, for takes of `frames` frames.
    ///
    /// If that device fails later, the other devices take over. Get `devices` from
    /// [`rhytid_devices::choose_devices`].
    ///
    /// # Errors
    /// [`Error::Device`] of the last device if none has room. [`Error::Input`] if the rig is not consistent.
    pub fn new(rig: &'a Rig, devices: &[DeviceInfo], frames: usize) -> Result<Self> {
        let batch = batch::batch_frames(rig).min(frames.max(1));
        let evaluator =
            Evaluator::new(rig, UploadOptions::frames(batch), devices, &rhytid_devices::backends::open)?;
        Ok(Self::with(rig, evaluator, batch))
    }

    fn with(rig: &'a Rig, evaluator: Evaluator<'a>, batch: usize) -> Self {
        let triangles = Arc::new(rig.surface().vertex_triangles());
        Self {
            rig,
            evaluator,
            batch,
            gains: Arc::default(),
            corrections: Arc::default(),
            corrected: Vec::new(),
            untangle: Untangle::new(rig, triangles.clone()).map(Arc::new),
            contact: Contact::new(rig, triangles.clone()).map(Arc::new),
            triangles,
        }
    }

    /// Adds all effects of `layers` except the edits of the take: gains of wrinkles by vertex, and sculpted
    /// corrections.
    ///
    /// For each correction a frame of the `edited` take is evaluated.
    ///
    /// # Errors
    /// As [`Playback::play`]. [`Error::Input`] if the take lacks a frame that was sculpted.
    pub fn with_layers(
        mut self,
        layers: &Layers,
        edited: &EditedTake,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let take = &edited.take;
        self.gains = self.gains.iter().cloned().chain(layers.vertex_gains(take)).collect();
        for sculpt in layers.sculpted() {
            let frame = sculpt.correction.frame;
            if frame >= take.frames() {
                return Err(Error::out_of_range(format!(
                    "{}: [[correction]] of frame {frame}: the take has {}, counted from 0",
                    layers.path().display(),
                    human::counted(take.frames(), "frame")
                )));
            }
            let selection = Selection::all(edited.slice(frame..frame + 1))?;
            let handles = selection.take.take.handle_positions(&self.rig.handles().labels)?;
            let recipe = Recipe { channels: ChannelChoice::NONE, ..Recipe::default() };
            let mut before = Vec::new();
            self.play(&selection, &recipe, progress, |frame| {
                before = frame.positions().to_vec();
                Ok(())
            })?;
            let sculpted = Sculpted {
                frame,
                positions: &sculpt.positions,
                before: before.as_chunks().0,
                handles: handles.as_chunks().0,
                weights: &sculpt.weights,
                reach: sculpt.correction.reach,
                amount: layers::timed(take, &sculpt.correction.amount),
            };
            let correction = Correction::new(self.rig, &self.triangles, sculpted);
            if 2 * correction.vertices() > self.rig.vertices() {
                let warning = Warning::from(format!(
                    "{}: the [[correction]] of frame {frame} moves {} of {} vertices: its mesh may be of another frame, take or edit",
                    layers.path().display(),
                    human::count(correction.vertices()),
                    human::count(self.rig.vertices())
                ));
                progress.warn(&warning.with_remedies(&[Remedy::WriteFrame]));
            }
            self.corrections = self.corrections.iter().cloned().chain([correction]).collect();
        }
        Ok(self)
    }

    /// The sculpted corrections alone.
    pub(crate) fn into_corrections(self) -> Vec<Correction> {
        self.corrections.to_vec()
    }

    /// The sculpted corrections. Each has the largest distance that it moved a vertex in each frame of the
    /// last play, in mesh units.
    pub fn corrections(&self) -> impl Iterator<Item = (&Correction, &[f64])> {
        self.corrections.iter().zip(self.corrected.iter().map(Vec::as_slice))
    }

    /// The rig.
    pub fn rig(&self) -> &'a Rig {
        self.rig
    }

    /// The device that evaluates now.
    pub fn device(&self) -> &DeviceInfo {
        self.evaluator.device()
    }

    /// V normals of the rest mesh: those of the large scale with all handles at rest.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn rest_normals(&mut self) -> Result<Vec<[f32; 3]>> {
        let handles: Vec<f32> = self.rig.handles().rest.iter().flatten().copied().collect();
        let mut results = [Vec::new(), Vec::new()];
        self.evaluator.evaluate(&handles, &stages(OutputStage::LargeScale), &mut results)?;
        let [_, normals] = results;
        Ok(normals.as_chunks().0.to_vec())
    }

    /// Evaluates frames × H handle positions and hands each frame's positions and normals to `each`.
    ///
    /// Evaluation runs one batch ahead. The normals are empty where they are not wanted. Triangles that the
    /// fine detail turns over are turned back.
    ///
    /// # Errors
    /// [`Error::Device`], [`Error::Cancelled`], and the errors of `each`. [`Error::Input`] if the shell is
    /// wanted and the rig has a linear band in its large scale: [`Rig::shell`] takes it out.
    pub fn evaluate(
        &mut self,
        handles: &[f32],
        stage: OutputStage,
        normals: bool,
        progress: &dyn Progress,
        mut each: impl FnMut(&[f32], &[f32]) -> Result<()>,
    ) -> Result<()> {
        let (triangles, untangle) = (self.triangles.clone(), self.untangle.clone());
        let contact = self.contact.clone();
        let poses = handles.as_chunks().0;
        let (rig, triangles) = (self.rig, &*triangles);
        let context = Context { rig, triangles, unedited: poses, edited: poses, times: &[], stage, normals };
        let effects = FrameEffects {
            untangle: untangle.as_deref(),
            contact: contact.as_deref(),
            ..FrameEffects::default()
        };
        self.run(&context, &effects, progress, |frame| {
            each(frame.positions.as_flattened(), frame.normals.as_flattened())
        })
    }

    /// Evaluates frames × H handle positions and hands each frame's positions and normals to `each`, as the
    /// device gives them. No stage of the host finishes them.
    ///
    /// # Errors
    /// [`Error::Device`], [`Error::Cancelled`].
    pub(crate) fn evaluate_unfinished(
        &mut self,
        poses: &[[f32; 3]],
        progress: &dyn Progress,
        mut each: impl FnMut(&[[f32; 3]], &[[f32; 3]]),
    ) -> Result<()> {
        let (rig, triangles) = (self.rig, self.triangles.clone());
        let context = Context {
            rig,
            triangles: &triangles,
            unedited: poses,
            edited: poses,
            times: &[],
            stage: OutputStage::Full,
            normals: true,
        };
        self.run(&context, &FrameEffects::default(), progress, |frame| {
            each(frame.positions, frame.normals);
            Ok(())
        })
    }

    /// Runs all frames of a context through their stages, and hands each frame to `each`.
    fn run(
        &mut self,
        context: &Context<'_>,
        effects: &FrameEffects<'_>,
        progress: &dyn Progress,
        mut each: impl FnMut(FrameBuffers<'_>) -> Result<()>,
    ) -> Result<()> {
        if context.stage == OutputStage::Shell && self.rig.learned().is_some() {
            return Err(Error::conflict(
                "the rig has a linear band in its large scale; play what Rig::shell gives",
            ));
        }
        let refined = effects.refine.then(|| Refined::new(context.rig, context.triangles, progress));
        let mut stages = Stages::new(context, effects, refined.transpose()?);
        let part = effects.region.as_ref().and_then(AffectedRegion::part);
        let of_region = part.map(|part| self.evaluator.of_part(part)).transpose()?;
        let frames = context.frames();
        let batches = (0..frames).step_by(self.batch).map(|first| first..frames.min(first + self.batch));
        let mut evaluate = Evaluate { context, effects, evaluator: &mut self.evaluator, of_region };
        let fill = |frames, batch: &mut Batch| evaluate.batch(frames, batch);
        pipeline::run(pipeline::BUFFERS, batches, fill, |batch| {
            for (mut frame, partial) in batch.frames(context, effects) {
                if progress.cancelled() {
                    return Err(Error::Cancelled);
                }
                stages.frame(&mut frame, partial);
                each(frame)?;
            }
            Ok(())
        })?;
        self.corrected = stages.corrected;
        if progress.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Plays the selection's inner frames in order.
    ///
    /// This method applies the parts of the recipe that change frames: stage, channels, fading, head,
    /// refinement and wrinkle groups. The parts that change the rig and the take before are applied by
    /// [`crate::Performance`].
    ///
    /// # Errors
    /// [`Error::Input`] if the take lacks handles, or if the rig has no data for a channel. Otherwise as
    /// [`Playback::evaluate`].
    pub fn play(
        &mut self,
        selection: &Selection,
        recipe: &Recipe,
        progress: &dyn Progress,
        mut each: impl FnMut(&Frame<'_>) -> Result<()>,
    ) -> Result<()> {
        let rig = self.rig;
        if recipe.refine && !self.corrections.is_empty() {
            return Err(Error::conflict(
                "refinement would undo the sculpted [[correction]]: leave one of them out",
            )
            .with_remedies(&[Remedy::NoRefinement]));
        }
        let take = &selection.take.take;
        let handles = take.handle_positions(&rig.handles().labels)?;
        let before = selection.take.before().handle_positions(&rig.handles().labels)?;
        let (gains, corrections) = (self.gains.clone(), self.corrections.clone());
        let (triangles, untangle) = (self.triangles.clone(), self.untangle.clone());
        let contact = self.contact.clone();
        let is_full = recipe.stage == OutputStage::Full;
        let fade = match is_full {
            true => Fade::new(rig, &triangles, &gains, take, &handles, recipe.fade_detail)?,
            false => None,
        };
        let is_gained = |gain: &&VertexGain| take.times.iter().any(|time| gain.at(*time) != 1.0);
        let gained = gains.iter().filter(|_| fade.is_some()).filter(is_gained);
        let falloff = EditFalloff::new(rig, &selection.take).filter(|_| before != handles);
        let unedited = if falloff.is_some() { &before } else { &handles };
        let context = Context {
            rig,
            triangles: &triangles,
            unedited: unedited.as_chunks().0,
            edited: handles.as_chunks().0,
            times: &take.times,
            stage: recipe.stage,
            normals: recipe.has(ChannelKind::Normals),
        };
        let effects = FrameEffects {
            region: AffectedRegion::new(rig, falloff, gained),
            fade,
            corrections: if is_full { &corrections } else { &[] },
            untangle: untangle.as_deref(),
            contact: contact.as_deref(),
            refine: recipe.refine,
            head: take.head.as_deref().filter(|_| recipe.head == HeadMotion::Bake),
        };
        let mut sources = ChannelSources::new(rig, recipe, &handles)?;
        let mut velocities = recipe.has(ChannelKind::Velocities).then(|| Velocities::new(selection.rate));
        let mut passed = 0;
        // Frames around the inner ones are only needed for velocities.
        let mut pass_on = |positions: &[[f32; 3]], normals: &[[f32; 3]], velocities: &[[f32; 3]]| {
            let number = passed;
            passed += 1;
            if !selection.inner.contains(&number) {
                return Ok(());
            }
            let pose = context.pose(context.edited, number);
            each(&sources.frame(&EvaluatedFrame { number, pose, positions, normals, velocities }))
        };
        self.run(&context, &effects, progress, |frame| match &mut velocities {
            None => pass_on(frame.positions, frame.normals, &[]),
            Some(velocities) => match velocities.frame(frame.positions, frame.normals) {
                Some(moved) => pass_on(&moved.positions, &moved.normals, &moved.velocities),
                None => Ok(()),
            },
        })?;
        match velocities.and_then(|mut velocities| velocities.last()) {
            Some(moved) => pass_on(&moved.positions, &moved.normals, &moved.velocities),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::{Device, NoProgress, channel};
    use rhytid_formats::animation::{self, Format};
    use rhytid_formats::export::{self, Scene, StatedRecipe};
    use rhytid_solve::solve;
    use rhytid_test_support::flaky::{Flaky, info};
    use std::path::Path;

    const FRAMES: usize = 23;

    /// Exports the demo's performance from a device, in batches of `batch` frames. The device fails where its
    /// name says so. The file's frame `refused` is left without normals.
    fn export(path: &Path, device: &str, batch: usize, refused: Option<usize>) -> Result<Vec<u8>> {
        let face = rhytid_demo::face(1_000);
        let rig = solve(&face, &NoProgress)?.rounded()?;
        let options = UploadOptions::frames(batch);
        let evaluator = Evaluator::new(&rig, options, &[info(device)], &Device::open::<Flaky>)?;
        let mut playback = Playback::with(&rig, evaluator, batch);
        let selection = Selection::new(rhytid_demo::performance(&face), 0..FRAMES, None, false)?;
        // All channels that the format can hold.
        let format = Format::from_extension(path)?;
        let kinds = ChannelKind::ALL.into_iter().filter(|kind| format.carries(*kind));
        let recipe =
            Recipe { channels: kinds.fold(ChannelChoice::NONE, ChannelChoice::with), ..Recipe::default() };
        let channels = crate::channels::of_recipe(&rig, &recipe)?;
        let (stated, corners) = (
            StatedRecipe::default(),
            rig.surface().faces.triangle_corners(&rig.surface().triangles).unwrap(),
        );
        let rest_normals = playback.rest_normals()?;
        let scene = Scene {
            rest_normals: Some(&rest_normals),
            channels: &channels,
            frames: FRAMES,
            ..Scene::new(&rig, &corners, &stated)
        };
        let mut exporter = animation::create(path, &scene, &export::Options::default())?;
        let mut frame = 0;
        playback.play(&selection, &recipe, &NoProgress, |shown| {
            let is_refused = refused == Some(frame);
            frame += 1;
            match is_refused {
                true => exporter.frame(&shown.clone().without(&channel::NORMALS)),
                false => exporter.frame(shown),
            }
        })?;
        exporter.finish(&NoProgress)?;
        Ok(std::fs::read(path).unwrap())
    }

    #[test]
    fn batches_change_no_byte() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["face.usd", "face.usda"] {
            let path = folder.path().join(name);
            let whole = export(&path, "sound", FRAMES, None).unwrap();
            assert!(whole.len() > FRAMES * 1_000 * 12);
            for batch in [1, 2, 5, 16, 22, 40] {
                assert!(export(&path, "sound", batch, None).unwrap() == whole, "{name}, {batch} frames");
            }
        }
    }

    /// A fault of the device, of the exporter or of both ends the export with the right error, and no file
    /// remains.
    ///
    /// The device fails in its first, a middle or its last batch; batch 0 is the rest pose. The exporter
    /// refuses a frame. The error is the same as without overlap.
    #[test]
    fn faults_on_either_side_end_both() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["face.usd", "face.usda", "face.usdz", "face.glb"] {
            let path = folder.path().join(name);
            for (device, refused, expected) in [
                ("evaluate:1", None, "unplugged"),
                ("read:4", None, "unplugged"),
                ("evaluate:8", None, "unplugged"),
                ("sound", Some(0), "frame 0 (from 0) has no normals"),
                ("sound", Some(11), "frame 11 (from 0) has no normals"),
                ("sound", Some(FRAMES - 1), "frame 22 (from 0) has no normals"),
                // Velocities need the frame after. So frame 10 is the last one that is written before batch
                // 5, which begins with frame 12.
                ("evaluate:5", Some(10), "frame 10 (from 0) has no normals"),
                // glTF has no velocities.
                (
                    "evaluate:5",
                    Some(11),
                    if name == "face.glb" { "frame 11 (from 0) has no normals" } else { "unplugged" },
                ),
            ] {
                let error = export(&path, device, 3, refused).unwrap_err().to_string();
                assert!(error.contains(expected), "{name}, {device}, {refused:?}: {error}");
                assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{name}, {device}");
            }
        }
    }
}
