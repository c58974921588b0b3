//! Long work on a device in pieces, so that others can use the device in between.

use rhytid_core::{DeviceErrorKind, Error, Progress, Result};
use std::time::Duration;
use web_time::Instant;

/// Submissions are to take about this long. A window can then draw in between.
const SHORT: Duration = Duration::from_millis(20);
/// The most pieces of a submission.
const MOST: u32 = 64;

/// The work of one submission or of many.
pub(super) enum Pieces<'a> {
    /// All of it goes into the caller's encoder.
    Together(&'a mut wgpu::CommandEncoder),
    /// The pieces are submitted a few at a time.
    Apart(Box<Apart<'a>>),
}

/// Work that is submitted a few pieces at a time. The progress is asked in between whether to go on.
pub(super) struct Apart<'a> {
    device: &'a wgpu::Device,
    queue: &'a wgpu::Queue,
    encoder: wgpu::CommandEncoder,
    progress: &'a dyn Progress,
    step: &'static str,
    done: u64,
    total: u64,
    /// How many pieces the next submission has, and how many of them are there.
    batch: u32,
    ready: u32,
}

impl<'a> Pieces<'a> {
    /// Work of `total` pieces, which is `step` of the progress.
    pub(super) fn apart(
        device: &'a wgpu::Device,
        queue: &'a wgpu::Queue,
        progress: &'a dyn Progress,
        step: &'static str,
        total: u64,
    ) -> Result<Self> {
        progress.step(step, 0, total)?;
        let encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        Ok(Self::Apart(Box::new(Apart {
            device,
            queue,
            encoder,
            progress,
            step,
            done: 0,
            total,
            batch: 1,
            ready: 0,
        })))
    }

    /// The encoder of the piece that is being made.
    pub(super) fn encoder(&mut self) -> &mut wgpu::CommandEncoder {
        match self {
            Self::Together(encoder) => encoder,
            Self::Apart(apart) => &mut apart.encoder,
        }
    }

    /// Ends a piece.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::Device`].
    pub(super) fn next(&mut self) -> Result<()> {
        let Self::Apart(apart) = self else { return Ok(()) };
        apart.done += 1;
        apart.ready += 1;
        if apart.ready < apart.batch && apart.done < apart.total {
            return Ok(());
        }
        let began = Instant::now();
        apart.submit()?;
        // A fast device gets more pieces at a time, since each submission costs time, too.
        apart.batch = match began.elapsed() {
            short if short < SHORT / 2 => (2 * apart.batch).min(MOST),
            long if long > 2 * SHORT => (apart.batch / 2).max(1),
            _ => apart.batch,
        };
        apart.progress.step(apart.step, apart.done, apart.total)
    }

    /// Submits what is left.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub(super) fn finish(self) -> Result<()> {
        match self {
            Self::Together(_) => Ok(()),
            Self::Apart(mut apart) => apart.submit(),
        }
    }
}

impl Apart<'_> {
    /// Submits the pieces, and waits for them.
    fn submit(&mut self) -> Result<()> {
        let next = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let encoder = std::mem::replace(&mut self.encoder, next);
        self.ready = 0;
        wait(self.device, self.queue.submit([encoder.finish()]))
    }
}

/// Waits until a submission is finished.
///
/// # Errors
/// [`Error::Device`].
pub(super) fn wait(device: &wgpu::Device, submission: wgpu::SubmissionIndex) -> Result<()> {
    let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
    device.poll(wait).map_err(|reason| Error::Device {
        kind: DeviceErrorKind::Driver,
        device: crate::name(device),
        message: format!("lighting skin failed: {reason}"),
    })?;
    Ok(())
}
