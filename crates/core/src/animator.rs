//! The animator: a [`Session`] whose input is checked.
use crate::{Backend, Error, HandleFrames, Result, Rig, Session, Stage, UploadOptions};
use std::time::Duration;

/// Drives a [`Session`] with validated input.
#[derive(Debug)]
pub struct Animator<S> {
    session: S,
    handles: usize,
    max_frames: usize,
    evaluated: bool,
}

impl<S: Session> Animator<S> {
    /// Uploads `rig` to `backend`.
    ///
    /// # Errors
    /// [`Error::Input`] if `max_frames` is 0, or the basis does not fit into its storage;
    /// [`Error::Device`].
    pub fn new<B: Backend<Session = S>>(backend: &B, rig: &Rig, options: UploadOptions) -> Result<Self> {
        options.check(rig)?;
        let session = backend.upload(rig, options)?;
        Ok(Self { session, handles: rig.handles().len(), max_frames: options.max_frames, evaluated: false })
    }

    /// The same, behind one type for every backend.
    pub fn boxed(self) -> Animator<Box<dyn Session>> {
        Animator {
            session: Box::new(self.session),
            handles: self.handles,
            max_frames: self.max_frames,
            evaluated: self.evaluated,
        }
    }

    /// Evaluates a batch: `positions` is frames × H × 3 in mesh units and head space, in the order of
    /// [`HandleSet::labels`](crate::HandleSet::labels). The results replace those of the last batch.
    ///
    /// # Errors
    /// [`Error::Input`] if the length is not a multiple of 3 H, or the batch is empty or larger than
    /// [`Animator::max_frames`]. [`Error::Input`] if a number is not finite. After these errors the results
    /// of the last batch are kept. [`Error::Device`] if the device fails.
    pub fn evaluate(&mut self, positions: &[f32]) -> Result<()> {
        self.evaluate_by(positions, S::evaluate)
    }

    /// As [`Animator::evaluate`], with another function of the session than [`Session::evaluate`], such as
    /// one that takes semaphores. It gets the checked batch.
    ///
    /// # Errors
    /// As [`Animator::evaluate`].
    pub fn evaluate_by(
        &mut self,
        positions: &[f32],
        evaluate: impl FnOnce(&mut S, HandleFrames<'_>) -> Result<()>,
    ) -> Result<()> {
        let frames = HandleFrames::checked(positions, self.handles, self.max_frames)?;
        self.evaluated = false;
        evaluate(&mut self.session, frames)?;
        self.evaluated = true;
        Ok(())
    }

    /// Copies one stage of the last batch to the host: frames × [`Stage::values_per_frame`].
    ///
    /// # Errors
    /// [`Error::Input`] if nothing was evaluated yet, or the last batch failed on the device;
    /// [`Error::Device`].
    pub fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.read_by(|session| session.read(stage, out))
    }

    /// As [`Animator::read`], with another function of the session than [`Session::read`], such as one that
    /// lends its memory.
    ///
    /// # Errors
    /// As [`Animator::read`].
    pub fn read_by<'a, T>(&'a mut self, read: impl FnOnce(&'a mut S) -> Result<T>) -> Result<T> {
        self.evaluated_before()?;
        read(&mut self.session)
    }

    /// How long the device computed on each stage of the last batch, in the order of [`Stage::ALL`]. `None`
    /// where the device cannot measure.
    ///
    /// # Errors
    /// As [`Animator::read`].
    pub fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        self.read_by(S::stage_times)
    }

    fn evaluated_before(&self) -> Result<()> {
        if self.evaluated {
            return Ok(());
        }
        Err(Error::empty(
            "there is nothing to read: no batch was evaluated yet, or the last one failed on the device",
        ))
    }

    /// The session, for a renderer that takes its device buffers.
    pub fn session(&self) -> &S {
        &self.session
    }

    /// The session, for what a backend offers beyond [`Session`]. The animator does not check input that is
    /// given to the session directly.
    pub fn session_mut(&mut self) -> &mut S {
        &mut self.session
    }

    /// The largest batch.
    pub fn max_frames(&self) -> usize {
        self.max_frames
    }
}
