use super::kernels;
use rhytid_core::plan::{Dispatch, Input, Plan, PlanLimits};
use rhytid_core::{HandleFrames, Result, Rig, Session, Stage, UploadOptions};
use std::time::Duration;

/// A rig in the toy's memory.
#[derive(Debug)]
pub(crate) struct ToySession {
    plan: Plan,
    /// In the order of [`Plan::buffers`], in words.
    buffers: Vec<Vec<u32>>,
    /// Of the last batch.
    frames: usize,
}

impl ToySession {
    /// Makes the planned buffers and fills the constant ones.
    pub(crate) fn new(rig: &Rig, options: UploadOptions, limits: PlanLimits) -> Result<Self> {
        let plan = Plan::new(rig, options, limits, "toy:0")?;
        let buffers = plan.buffers().iter().enumerate().map(|(i, planned)| {
            let mut words = vec![0u32; planned.bytes as usize / 4];
            let contents = plan.contents(rig, i);
            bytemuck::cast_slice_mut(&mut words)[..contents.len()].copy_from_slice(&contents);
            words
        });
        Ok(Self { buffers: buffers.collect(), plan, frames: 0 })
    }

    /// Frames of the last batch.
    pub(crate) fn frames(&self) -> usize {
        self.frames
    }

    /// What has to run for a batch.
    pub(crate) fn dispatches(&self, frames: usize) -> Vec<Dispatch> {
        self.plan.dispatches(frames)
    }

    /// Writes the inputs of a batch where the kernels read them.
    pub(crate) fn write(&mut self, batch: HandleFrames<'_>) {
        self.frames = batch.frames;
        for Input { buffer, numbers } in self.plan.inputs(batch) {
            let words = bytemuck::cast_slice(&numbers);
            self.buffers[buffer][..words.len()].copy_from_slice(words);
        }
    }

    /// Runs kernels one after the other.
    pub(crate) fn run(&mut self, dispatches: &[Dispatch]) {
        for dispatch in dispatches {
            kernels::run(dispatch, &mut self.buffers);
        }
    }
}

impl Session for ToySession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.write(frames);
        self.run(&self.dispatches(frames.frames));
        Ok(())
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        out.clear();
        for slice in self.plan.slices(self.frames()) {
            let words = &self.buffers[slice.results[stage as usize]];
            let used = slice.frames.len() * self.plan.frame_bytes(stage) / 4;
            out.extend_from_slice(bytemuck::cast_slice(&words[..used]));
        }
        Ok(())
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        Ok(None)
    }
}
