//! A take played on a rig, frame by frame: what `animate` writes, and what `verify` compares with.

use crate::args::{HeadChoice, StageChoice};
use crate::bake::Bake;
use crate::evaluator::Evaluator;
use crate::fade::Fade;
use crate::frames::Selection;
use crate::progress::Ui;
use crate::velocities::Velocities;
use crate::{device_choice, memory, pipeline};
use rhytid_core::{DeviceInfo, Error, Progress, Result, Rig, Stage, UploadOptions};
use rhytid_formats::export::Frame;
use std::ops::Range;

/// A rig on a device.
pub struct Player<'a> {
    rig: &'a Rig,
    evaluator: Evaluator<'a>,
    /// Frames in a batch.
    batch: usize,
}

/// What the device gave of some frames.
#[derive(Default)]
struct Batch {
    /// The number of the first.
    first: usize,
    /// Whether any of them may fade.
    fades: bool,
    /// Positions; normals, if they are wanted; the large scale, if any frame may fade.
    results: Vec<Vec<f32>>,
}

/// What is wanted of each frame, beside its positions.
#[derive(Debug, Clone, Copy)]
pub struct Wanted {
    /// How far to go.
    pub stage: StageChoice,
    /// Normals too.
    pub normals: bool,
    /// Velocities too.
    pub velocities: bool,
    /// Detail fades where the take's confidence is below 1.
    pub fade_detail: bool,
    /// What becomes of the head's motion: [`HeadChoice::Bake`] puts it into the frames.
    pub head: HeadChoice,
}

impl<'a> Player<'a> {
    /// Makes `rig` resident on `device`, or on the first that conforms and has room for it.
    ///
    /// # Errors
    /// [`Error::Device`]; [`Error::Cancelled`].
    pub fn new(rig: &'a Rig, device: Option<DeviceInfo>, frames: usize, ui: &Ui) -> Result<Self> {
        let devices = match device {
            Some(device) => vec![device],
            None => device_choice::auto(ui)?,
        };
        let batch = memory::batch_frames(rig).min(frames.max(1));
        let evaluator = Evaluator::new(rig, UploadOptions::frames(batch), &devices, &rhytid_backends::open)?;
        Ok(Self { rig, evaluator, batch })
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
        let mut results = [Vec::new()];
        self.evaluator.evaluate(&handles, &[Stage::LargeScaleNormals], &mut results)?;
        let [normals] = results;
        Ok(normals.as_chunks().0.to_vec())
    }

    /// Evaluates frames × H handle positions, a batch ahead, and hands each frame's positions and normals (empty where
    /// they are not wanted) to `each`, faded where that is given, which is only of use to the full stage.
    ///
    /// # Errors
    /// [`Error::Device`], [`Error::Cancelled`], and as `each`.
    pub fn evaluate(
        &mut self,
        handles: &[f32],
        stage: StageChoice,
        normals: bool,
        mut fade: Option<&mut Fade<'_>>,
        ui: &Ui,
        mut each: impl FnMut(&[f32], &[f32]) -> Result<()>,
    ) -> Result<()> {
        let (per_frame, frame) = (self.rig.handles.len() * 3, self.rig.vertices() * 3);
        let frames = handles.len() / per_frame;
        let batches = (0..frames).step_by(self.batch).map(|first| first..frames.min(first + self.batch));
        // Without confidence below 1, a batch costs what it costs without fading.
        let touched = |frames: &Range<usize>| fade.as_ref().is_some_and(|fade| fade.touches(frames.clone()));
        let batches: Vec<_> = batches.map(|frames| (touched(&frames), frames)).collect();
        let evaluate = |(fades, frames): (bool, Range<usize>), batch: &mut Batch| {
            let [positions, vertex_normals] = stage.stages();
            let mut stages = vec![positions];
            stages.extend(normals.then_some(vertex_normals));
            stages.extend(fades.then_some(Stage::LargeScale));
            batch.results.resize(stages.len(), Vec::new());
            batch.first = frames.start;
            batch.fades = fades;
            let handles = &handles[frames.start * per_frame..frames.end * per_frame];
            self.evaluator.evaluate(handles, &stages, &mut batch.results)
        };
        pipeline::run(
            pipeline::BUFFERS,
            batches.into_iter(),
            evaluate,
            |Batch { first, fades, results }| {
                for (i, positions) in results[0].chunks_exact(frame).enumerate() {
                    if ui.cancelled() {
                        return Err(Error::Cancelled);
                    }
                    let of_frame = |stage: usize| &results[stage][i * frame..][..frame];
                    let shown = [positions, if normals { of_frame(1) } else { &[] }];
                    let [positions, normals] = match fade.as_deref_mut().filter(|_| *fades) {
                        Some(fade) => fade.frame(*first + i, of_frame(results.len() - 1), shown),
                        None => shown,
                    };
                    each(positions, normals)?;
                }
                Ok(())
            },
        )?;
        if ui.cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }

    /// Plays the selection's inner frames in order.
    ///
    /// # Errors
    /// [`Error::Input`] if the take lacks handles; as [`Player::evaluate`].
    pub fn play(
        &mut self,
        selection: &Selection,
        wanted: Wanted,
        ui: &Ui,
        mut each: impl FnMut(Frame<'_>) -> Result<()>,
    ) -> Result<()> {
        let handles = selection.take.handle_positions(&self.rig.labels)?;
        let fades = wanted.fade_detail && wanted.stage == StageChoice::Full;
        let mut fade = if fades { Fade::new(self.rig, &selection.take) } else { None };
        let head = selection.take.head.as_ref().filter(|_| wanted.head == HeadChoice::Bake);
        let mut bake = Bake::default();
        let mut velocities = wanted.velocities.then(|| Velocities::new(selection.rate));
        let (mut evaluated, mut passed) = (0, 0);
        // Frames around the inner ones only serve the velocities.
        let mut inner = |positions: &[f32], normals: &[f32], velocities: Option<&[f32]>| {
            let is_inner = selection.inner.contains(&passed);
            passed += 1;
            let normals = wanted.normals.then_some(normals);
            if is_inner { each(Frame { positions, normals, velocities }) } else { Ok(()) }
        };
        let (stage, normals) = (wanted.stage, wanted.normals);
        self.evaluate(&handles, stage, normals, fade.as_mut(), ui, |positions, normals| {
            let shown = [positions, normals];
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
    use crate::frames;
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
        let mut player = Player { rig: &rig, evaluator, batch };
        let selection = frames::select(rhytid_demo::performance(&face), 0..FRAMES, None, false)?;
        let wanted = Wanted {
            stage: StageChoice::Full,
            normals: true,
            velocities: true,
            fade_detail: false,
            head: HeadChoice::Keep,
        };
        let (provenance, corners) =
            (Provenance::default(), rig.faces.triangle_corners(&rig.triangles).unwrap());
        let rest_normals = player.rest_normals()?;
        let scene = Scene {
            rest_normals: Some(&rest_normals),
            velocities: true,
            frames: FRAMES,
            ..Scene::of(&rig, &corners, &provenance)
        };
        let mut exporter = animation::create(path, &scene, &export::Options::default())?;
        let mut frame = 0;
        player.play(&selection, wanted, &Ui::new(true), |shown| {
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
