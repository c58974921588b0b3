//! A take played on a rig, frame by frame: what `animate` writes, and what `verify` compares with.

use crate::args::{HeadChoice, StageChoice};
use crate::bake::Bake;
use crate::evaluator::Evaluator;
use crate::fade::Fade;
use crate::frames::Selection;
use crate::progress::Ui;
use crate::velocities::Velocities;
use crate::{device_choice, memory};
use rhytid_core::{DeviceInfo, Error, Progress, Result, Rig, Stage, UploadOptions};
use rhytid_formats::export::Frame;

/// A rig on a device.
pub struct Player<'a> {
    rig: &'a Rig,
    evaluator: Evaluator<'a>,
    /// Frames in a batch.
    batch: usize,
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

    /// Evaluates frames × H handle positions and hands each frame's positions and normals (empty where they are not
    /// wanted) to `each`, faded where that is given, which is only of use to the full stage.
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
        let [positions, vertex_normals] = stage.stages();
        let (per_frame, frame) = (self.rig.handles.len() * 3, self.rig.vertices() * 3);
        let (mut first, mut results) = (0, Vec::new());
        for batch in handles.chunks(self.batch * per_frame) {
            let end = first + batch.len() / per_frame;
            // Without confidence below 1, a batch costs what it costs without fading.
            let mut fade = fade.as_deref_mut().filter(|fade| fade.touches(first..end));
            let mut stages = vec![positions];
            stages.extend(normals.then_some(vertex_normals));
            stages.extend(fade.is_some().then_some(Stage::LargeScale));
            results.resize(stages.len(), Vec::new());
            self.evaluator.evaluate(batch, &stages, &mut results)?;
            for (i, positions) in results[0].chunks_exact(frame).enumerate() {
                if ui.cancelled() {
                    return Err(Error::Cancelled);
                }
                let of_frame = |stage: usize| &results[stage][i * frame..][..frame];
                let shown = [positions, if normals { of_frame(1) } else { &[] }];
                let [positions, normals] = match &mut fade {
                    Some(fade) => fade.frame(first + i, of_frame(stages.len() - 1), shown),
                    None => shown,
                };
                each(positions, normals)?;
            }
            first = end;
        }
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
