//! Playback: a take on a rig, frame by frame. It is what is exported, and what an exported file is compared with.

use crate::bake::Bake;
use crate::bounds::Bounds;
use crate::correction::{Correction, Sculpted};
use crate::evaluator::Evaluator;
use crate::fade::{Fade, VertexGain};
use crate::finish::{Finish, Given, OnTop};
use crate::reached::{OnceMore, Poses, Reached};
use crate::refined::Refined;
use crate::selection::Selection;
use crate::uncertainty::Uncertainty;
use crate::untangle::Untangle;
use crate::velocities::Velocities;
use crate::{Layers, batch, layers, pipeline};
use rhytid_core::{
    DeviceInfo, Error, PrincipalStrains, Progress, Result, Rig, Stage, StrainGauge, Take, UploadOptions,
    human,
};
use rhytid_formats::export::{Frame, HeadMotion, OutputStage};
use rhytid_kernels::normals::VertexTriangles;
use std::ops::Range;
use std::sync::Arc;

/// A rig on a device, and the devices to go on with if that one fails.
pub struct Playback<'a> {
    rig: &'a Rig,
    evaluator: Evaluator<'a>,
    /// Frames in a batch.
    batch: usize,
    /// By how much folds are multiplied, one on the other.
    gains: Arc<[VertexGain]>,
    /// What was sculpted, in order.
    corrections: Arc<[Correction]>,
    /// The farthest that each correction moved a vertex, in mesh units, in each frame that was played last, inner ones or not.
    corrected: Vec<Vec<f64>>,
    triangles: Arc<VertexTriangles>,
    /// Where something was learned.
    untangle: Option<Untangle<'a>>,
}

/// What the device gave of some frames.
#[derive(Default)]
struct Batch {
    frames: Range<usize>,
    /// Positions; normals, if they are wanted; the large scale, if any frame may fade all over the face.
    results: Vec<Vec<f32>>,
    /// What edits reach.
    once_more: OnceMore,
}

/// What is wanted of each frame, beside its positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaybackOptions {
    /// How far to go.
    pub stage: OutputStage,
    /// Normals too.
    pub normals: bool,
    /// Velocities too, which need [`Selection::new`] to be asked for neighbours.
    pub velocities: bool,
    /// How far each vertex is to be trusted too ([`rhytid_solve::Confidence`]), which a rig of the learned method knows.
    pub sigma: bool,
    /// The principal strains of each vertex too ([`StrainGauge`]), of the positions as they are handed on.
    pub strain: bool,
    /// Detail fades where the take's confidence is below 1, and where the rig's says that a frame is far outside what its examples
    /// show; of use to [`OutputStage::Full`] alone.
    pub fade_detail: bool,
    /// What becomes of the head's motion: [`HeadMotion::Bake`] puts it into the frames.
    pub head: HeadMotion,
    /// Each frame is refined on the host ([`rhytid_solve::Refine`]), which a rig without examples can be.
    pub refine: bool,
}

impl Default for PlaybackOptions {
    /// Positions and normals of the whole face, in head space.
    fn default() -> Self {
        Self {
            stage: OutputStage::Full,
            normals: true,
            velocities: false,
            sigma: false,
            strain: false,
            fade_detail: false,
            head: HeadMotion::Keep,
            refine: false,
        }
    }
}

/// The stages that have an output stage's positions and normals.
fn stages(stage: OutputStage) -> [Stage; 2] {
    match stage {
        OutputStage::LargeScale | OutputStage::Shell => [Stage::LargeScale, Stage::LargeScaleNormals],
        OutputStage::Full => [Stage::Positions, Stage::Normals],
    }
}

impl<'a> Playback<'a> {
    /// Makes `rig` resident on the first of `devices` that has room for it, for takes of `frames` frames; the other devices, as
    /// [`crate::choose_devices`] gives them, are for when that one fails.
    ///
    /// # Errors
    /// [`Error::Device`], the last device's, if none has room; [`Error::Input`] if the rig is not consistent.
    pub fn new(rig: &'a Rig, devices: &[DeviceInfo], frames: usize) -> Result<Self> {
        let batch = batch::batch_frames(rig).min(frames.max(1));
        let evaluator = Evaluator::new(rig, UploadOptions::frames(batch), devices, &rhytid_backends::open)?;
        Ok(Self::with(rig, evaluator, batch))
    }

    fn with(rig: &'a Rig, evaluator: Evaluator<'a>, batch: usize) -> Self {
        let triangles = Arc::new(VertexTriangles::new(rig.vertices(), &rig.triangles));
        Self {
            rig,
            evaluator,
            batch,
            gains: Arc::default(),
            corrections: Arc::default(),
            corrected: Vec::new(),
            untangle: Untangle::new(rig, triangles.clone()),
            triangles,
        }
    }

    /// With all that `layers` do beside editing the take: folds by vertex, and what was sculpted, for which frames of the `edited` take are evaluated.
    ///
    /// # Errors
    /// As [`Playback::play`]; [`Error::Input`] if the take has no frame that was sculpted.
    pub fn with_layers(mut self, layers: &Layers, edited: &Take, progress: &dyn Progress) -> Result<Self> {
        self.gains = self.gains.iter().cloned().chain(layers.vertex_gains(edited)).collect();
        for sculpt in layers.sculpted() {
            let frame = sculpt.correction.frame;
            if frame >= edited.frames() {
                return Err(Error::input(format!(
                    "{}: [[correction]] of frame {frame}: the take has {}, counted from 0",
                    layers.path().display(),
                    human::counted(edited.frames(), "frame")
                )));
            }
            let selection = Selection::all(edited.slice(frame..frame + 1))?;
            let handles = selection.take.handle_positions(&self.rig.labels)?;
            let options = PlaybackOptions { normals: false, ..PlaybackOptions::default() };
            let mut before = Vec::new();
            self.play(&selection, options, progress, |frame| {
                before = frame.positions.to_vec();
                Ok(())
            })?;
            let sculpted = Sculpted {
                frame,
                positions: &sculpt.positions,
                before: before.as_chunks().0,
                handles: handles.as_chunks().0,
                weights: &sculpt.weights,
                reach: sculpt.correction.reach,
                amount: layers::timed(edited, &sculpt.correction.amount),
            };
            let correction = Correction::new(self.rig, &self.triangles, sculpted);
            if 2 * correction.vertices() > self.rig.vertices() {
                log::warn!(
                    "{}: the [[correction]] of frame {frame} moves {} of {} vertices: its mesh may be of another frame, take or edit; `rhytid correct` writes this one",
                    layers.path().display(),
                    human::count(correction.vertices()),
                    human::count(self.rig.vertices())
                );
            }
            self.corrections = self.corrections.iter().cloned().chain([correction]).collect();
        }
        Ok(self)
    }

    /// What was sculpted, without the rest.
    pub(crate) fn into_corrections(self) -> Vec<Correction> {
        self.corrections.to_vec()
    }

    /// What was sculpted, each with the farthest that it moved a vertex in each of the frames that were played last, in mesh units.
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

    /// V normals of the rest mesh: those of the large scale where no handle moves.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub fn rest_normals(&mut self) -> Result<Vec<[f32; 3]>> {
        let handles: Vec<f32> = self.rig.handles.iter().flat_map(|&v| self.rig.rest[v as usize]).collect();
        let mut results = [Vec::new(), Vec::new()];
        self.evaluator.evaluate(&handles, &stages(OutputStage::LargeScale), &mut results)?;
        let [_, normals] = results;
        Ok(normals.as_chunks().0.to_vec())
    }

    /// Evaluates frames × H handle positions, a batch ahead, and hands each frame's positions and normals (empty where
    /// they are not wanted) to `each`. Triangles that what was learned turns over are turned back.
    ///
    /// # Errors
    /// [`Error::Device`], [`Error::Cancelled`], and as `each`; [`Error::Input`] if the shell is wanted of a rig that has more in its
    /// large scale: [`Rig::shell`] takes that out.
    pub fn evaluate(
        &mut self,
        handles: &[f32],
        stage: OutputStage,
        normals: bool,
        progress: &dyn Progress,
        each: impl FnMut(&[f32], &[f32]) -> Result<()>,
    ) -> Result<()> {
        self.evaluate_edited([handles; 2], (stage, normals), OnTop::default(), progress, each)
    }

    /// As [`Playback::evaluate`], with what is done to the full stage.
    fn evaluate_edited(
        &mut self,
        poses: Poses<'_>,
        (stage, normals): (OutputStage, bool),
        on_top: OnTop<'_, '_>,
        progress: &dyn Progress,
        mut each: impl FnMut(&[f32], &[f32]) -> Result<()>,
    ) -> Result<()> {
        if stage == OutputStage::Shell && self.rig.learned.is_some() {
            return Err(Error::input(
                "the rig has a linear band in its large scale; play what Rig::shell gives",
            ));
        }
        let (handles, vertices) = (self.rig.handles.len(), self.rig.vertices());
        let [unedited, edited] = poses.map(|pose| pose.as_chunks::<3>().0);
        let frames = unedited.len() / handles;
        let batches = (0..frames).step_by(self.batch).map(|first| first..frames.min(first + self.batch));
        let part = on_top.reached.and_then(Reached::part);
        let mut part = part.map(|part| self.evaluator.of_part(part)).transpose()?;
        let has_part = part.is_some();
        let is_gained = |frame: usize| on_top.fade.is_some_and(|fade| fade.is_gained(frame));
        // Where nothing fades, and no edit is about any frame, a batch costs what it costs without.
        let fades = |frames: &Range<usize>| {
            let everywhere = on_top.fade.is_some_and(|fade| fade.is_everywhere(frames.clone()));
            everywhere || !has_part && frames.clone().any(is_gained)
        };
        let evaluate = |frames: Range<usize>, batch: &mut Batch| {
            let [shown, vertex_normals] = stages(stage);
            let mut stages = vec![shown];
            stages.extend(normals.then_some(vertex_normals));
            stages.extend(fades(&frames).then_some(Stage::LargeScale));
            batch.results.resize(stages.len(), Vec::new());
            batch.frames = frames.clone();
            let of_frames = &unedited[frames.start * handles..frames.end * handles];
            self.evaluator.evaluate(of_frames.as_flattened(), &stages, &mut batch.results)?;
            let (Some(reached), of_frames) = (on_top.reached, (frames, poses)) else { return Ok(()) };
            let once_more = &mut batch.once_more;
            let fades = (on_top.fade.is_some(), |frame| has_part && is_gained(frame));
            match &mut part {
                Some(part) => reached.evaluate(part, of_frames, fades, shown, once_more),
                None => reached.evaluate(&mut self.evaluator, of_frames, fades, shown, once_more),
            }
        };
        let mut finish = Finish::new((self.rig, &self.triangles), on_top, self.untangle.as_ref());
        let has_normals = normals;
        pipeline::run(pipeline::BUFFERS, batches, evaluate, |Batch { frames, results, once_more }| {
            for (at, number) in frames.clone().enumerate() {
                if progress.cancelled() {
                    return Err(Error::Cancelled);
                }
                let mut results = results
                    .iter_mut()
                    .map(|results| &mut results.as_chunks_mut().0[at * vertices..][..vertices]);
                let positions = results.next().unwrap_or_default();
                let normals = if has_normals { results.next().unwrap_or_default() } else { &mut [] };
                let given = Given {
                    positions: &mut *positions,
                    normals: &mut *normals,
                    large_scale: results.next().map(|large_scale| &*large_scale),
                    poses: [unedited, edited].map(|pose| &pose[number * handles..][..handles]),
                };
                let local = on_top.reached.map(|reached| reached.frame(once_more, number));
                finish.frame(number, given, local);
                each(positions.as_flattened(), normals.as_flattened())?;
            }
            Ok(())
        })?;
        self.corrected = finish.corrected;
        if progress.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Plays the selection's inner frames in order.
    ///
    /// # Errors
    /// [`Error::Input`] if the take lacks handles; as [`Playback::evaluate`].
    pub fn play(
        &mut self,
        selection: &Selection,
        options: PlaybackOptions,
        progress: &dyn Progress,
        mut each: impl FnMut(Frame<'_>) -> Result<()>,
    ) -> Result<()> {
        let handles = selection.take.handle_positions(&self.rig.labels)?;
        let of_the_take = (&selection.take, &handles[..]);
        let gains = self.gains.clone();
        let fade = match options.stage {
            OutputStage::Full => {
                Fade::new((self.rig, &self.triangles), &gains, of_the_take, options.fade_detail)?
            }
            _ => None,
        };
        if options.refine && !self.corrections.is_empty() {
            return Err(Error::input(
                "what was sculpted would be refined away: leave --refine or the [[correction]] out",
            ));
        }
        let mut refined =
            options.refine.then(|| Refined::new(self.rig, self.triangles.clone(), progress)).transpose()?;
        let per_frame = 3 * self.rig.handles.len();
        let head = selection.take.head.as_ref().filter(|_| options.head == HeadMotion::Bake);
        let mut bake = Bake::default();
        let mut velocities = options.velocities.then(|| Velocities::new(selection.rate));
        let (mut evaluated, mut passed) = (0, 0);
        let uncertainty = match options.sigma {
            true => Some(Uncertainty::new(self.rig, &handles)?.ok_or_else(|| {
                Error::input(
                    "the rig does not know how far it is to be trusted: that takes the learned method and an example",
                )
            })?),
            false => None,
        };
        let mut sigma = Vec::new();
        let gauge = options.strain.then(|| StrainGauge::new(&self.rig.rest, &self.rig.triangles));
        let mut strain = PrincipalStrains::default();
        // Frames around the inner ones only serve the velocities.
        let mut inner = |positions: &[f32], normals: &[f32], velocities: Option<&[f32]>| {
            let frame = passed;
            passed += 1;
            if !selection.inner.contains(&frame) {
                return Ok(());
            }
            let normals = options.normals.then_some(normals);
            if let Some(uncertainty) = &uncertainty {
                uncertainty.sigma(frame, &mut sigma);
            }
            let sigma = uncertainty.is_some().then_some(sigma.as_slice());
            if let Some(gauge) = &gauge {
                gauge.measure(positions.as_chunks().0, &mut strain);
            }
            let strain = gauge.is_some().then_some(&strain);
            each(Frame { positions, normals, velocities, sigma, strain })
        };
        let (stage, normals) = (options.stage, options.normals);
        let corrections = self.corrections.clone();
        let gains = gains.iter().filter(|_| fade.is_some());
        let is_gained = |gain: &&VertexGain| selection.take.times.iter().any(|time| gain.at(*time) != 1.0);
        let bounds = Bounds::new(self.rig, &selection.take);
        let unedited = bounds.as_ref().map(|_| Bounds::unedited(self.rig, &selection.take, &handles));
        let bounds = bounds.filter(|_| unedited.as_ref() != Some(&handles));
        let reached = Reached::new(self.rig, bounds, gains.filter(is_gained));
        let on_top = OnTop {
            fade: fade.as_ref(),
            reached: reached.as_ref(),
            corrections: if stage == OutputStage::Full { &corrections } else { &[] },
            times: &selection.take.times,
        };
        let poses = [unedited.as_ref().unwrap_or(&handles), &handles[..]];
        self.evaluate_edited(poses, (stage, normals), on_top, progress, |positions, normals| {
            let shown = match &mut refined {
                Some(refined) => {
                    refined.frame(&handles[evaluated * per_frame..][..per_frame], [positions, normals])
                }
                None => [positions, normals],
            };
            let [positions, normals] = match head {
                Some(head) => bake.frame(&head[evaluated], shown),
                None => shown,
            };
            evaluated += 1;
            match &mut velocities {
                Some(velocities) => velocities.frame(positions, normals, &mut |p, n, v| inner(p, n, Some(v))),
                None => inner(positions, normals, None),
            }
        })?;
        match velocities {
            Some(velocities) => velocities.finish(&mut |p, n, v| inner(p, n, Some(v))),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluator::tests::{Flaky, info};
    use rhytid_core::{Device, NoProgress};
    use rhytid_formats::animation;
    use rhytid_formats::export::{self, Provenance, Scene};
    use rhytid_solve::solve;
    use std::path::Path;

    const FRAMES: usize = 23;

    /// Exports the demo's performance from a device, which fails where its name says so, in batches of `batch`
    /// frames; the file's frame `refused` is left without normals.
    fn export(path: &Path, device: &str, batch: usize, refused: Option<usize>) -> Result<Vec<u8>> {
        let face = rhytid_demo::face(1_000);
        let rig = solve(&face, &NoProgress)?.cast::<f32>();
        let options = UploadOptions::frames(batch);
        let evaluator = Evaluator::new(&rig, options, &[info(device)], &Device::open::<Flaky>)?;
        let mut playback = Playback::with(&rig, evaluator, batch);
        let selection = Selection::new(rhytid_demo::performance(&face), 0..FRAMES, None, false)?;
        let options = PlaybackOptions {
            stage: OutputStage::Full,
            normals: true,
            velocities: true,
            sigma: true,
            strain: true,
            fade_detail: false,
            head: HeadMotion::Keep,
            refine: false,
        };
        let (provenance, corners) =
            (Provenance::default(), rig.faces.triangle_corners(&rig.triangles).unwrap());
        let rest_normals = playback.rest_normals()?;
        let scene = Scene {
            rest_normals: Some(&rest_normals),
            velocities: true,
            sigma: true,
            strain: true,
            frames: FRAMES,
            ..Scene::of(&rig, &corners, &provenance)
        };
        let mut exporter = animation::create(path, &scene, &export::Options::default())?;
        let mut frame = 0;
        playback.play(&selection, options, &NoProgress, |shown| {
            let normals = shown.normals.filter(|_| refused != Some(frame));
            frame += 1;
            exporter.frame(Frame { normals, ..shown })
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

    /// A device that fails in its first, a middle and its last batch (the first of all is that of the rest pose), frames
    /// that the exporter refuses, and both: what would have been told without overlap is told, and nothing is left.
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
                // Velocities need the frame after, so that frame 10 is the last one written before batch 5, of frame 12.
                ("evaluate:5", Some(10), "frame 10 (from 0) has no normals"),
                ("evaluate:5", Some(11), "unplugged"),
            ] {
                let error = export(&path, device, 3, refused).unwrap_err().to_string();
                assert!(error.contains(expected), "{name}, {device}, {refused:?}: {error}");
                assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "{name}, {device}");
            }
        }
    }
}
