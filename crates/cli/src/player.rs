//! A take played on a rig, frame by frame: what `animate` writes, and what `verify` compares with.

use crate::args::StageChoice;
use crate::evaluator::Evaluator;
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
    /// wanted) to `each`.
    ///
    /// # Errors
    /// [`Error::Device`], [`Error::Cancelled`], and as `each`.
    pub fn evaluate(
        &mut self,
        handles: &[f32],
        stage: StageChoice,
        normals: bool,
        ui: &Ui,
        mut each: impl FnMut(&[f32], &[f32]) -> Result<()>,
    ) -> Result<()> {
        let stages = stage.stages();
        let stages = if normals { &stages[..] } else { &stages[..1] };
        let mut results = vec![Vec::new(); stages.len()];
        for batch in handles.chunks(self.batch * self.rig.handles.len() * 3) {
            self.evaluator.evaluate(batch, stages, &mut results)?;
            let frame = self.rig.vertices() * 3;
            for (i, positions) in results[0].chunks_exact(frame).enumerate() {
                if ui.cancelled() {
                    return Err(Error::Cancelled);
                }
                each(positions, results.get(1).map_or(&[][..], |normals| &normals[i * frame..][..frame]))?;
            }
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
        let mut passed = 0;
        // Frames around the inner ones only serve the velocities.
        let mut inner = |positions: &[f32], normals: &[f32], velocities: Option<&[f32]>| {
            let is_inner = selection.inner.contains(&passed);
            passed += 1;
            let normals = wanted.normals.then_some(normals);
            if is_inner { each(Frame { positions, normals, velocities }) } else { Ok(()) }
        };
        if !wanted.velocities {
            return self.evaluate(&handles, wanted.stage, wanted.normals, ui, |positions, normals| {
                inner(positions, normals, None)
            });
        }
        let mut each = |p: &[f32], n: &[f32], v: &[f32]| inner(p, n, Some(v));
        let mut velocities = Velocities::new(selection.rate);
        self.evaluate(&handles, wanted.stage, wanted.normals, ui, |positions, normals| {
            velocities.frame(positions, normals, &mut each)
        })?;
        velocities.finish(&mut each)
    }
}
