use crate::{Backend, Error, HandleFrames, Result, Rig, Session, Stage};

/// Drives a [`Session`] with validated input: the one place where handle positions are checked.
#[derive(Debug)]
pub struct Animator<S> {
    session: S,
    handles: usize,
    max_frames: usize,
    evaluated: bool,
}

impl<S: Session> Animator<S> {
    /// Checks `rig` and uploads it to `backend`, with room for batches of up to `max_frames` frames.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig is not consistent or `max_frames` is 0; [`Error::Device`].
    pub fn new<B: Backend<Session = S>>(backend: &B, rig: &Rig, max_frames: usize) -> Result<Self> {
        if max_frames == 0 {
            return Err(Error::input("a batch has at least 1 frame, found max_frames = 0"));
        }
        rig.check()?;
        let session = backend.upload(rig, max_frames)?;
        Ok(Self { session, handles: rig.handles.len(), max_frames, evaluated: false })
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
    /// [`Rig::labels`]. The results replace those of the last batch.
    ///
    /// # Errors
    /// [`Error::Input`] if the length is not a multiple of 3 H, the batch is empty or above the room made for
    /// it, or a number is not finite (the results of the last batch are kept then); [`Error::Device`].
    pub fn evaluate(&mut self, positions: &[f32]) -> Result<()> {
        let per_frame = self.handles * 3;
        let frames = positions.len() / per_frame;
        if frames * per_frame != positions.len() || frames == 0 {
            return Err(Error::input(format!(
                "a batch of handle positions has {} numbers, expected a multiple of {} handles × 3 above 0",
                positions.len(),
                self.handles
            )));
        }
        if frames > self.max_frames {
            return Err(Error::input(format!(
                "a batch has {frames} frames, expected at most {}: split it or make more room",
                self.max_frames
            )));
        }
        if let Some(i) = positions.iter().position(|x| !x.is_finite()) {
            return Err(Error::input(format!(
                "frame {} of a batch: handle {} is at {}, expected a finite position",
                i / per_frame,
                i % per_frame / 3,
                positions[i]
            )));
        }
        self.evaluated = false;
        self.session.evaluate(HandleFrames { positions, frames })?;
        self.evaluated = true;
        Ok(())
    }

    /// Copies one stage of the last batch to the host: frames × [`Stage::values_per_frame`].
    ///
    /// # Errors
    /// [`Error::Input`] if nothing was evaluated yet, or the last batch failed on the device; [`Error::Device`].
    pub fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        if !self.evaluated {
            return Err(Error::input(
                "there is nothing to read: no batch was evaluated yet, or the last one failed on the device",
            ));
        }
        self.session.read(stage, out)
    }

    /// The session, for a renderer that takes its device buffers.
    pub fn session(&self) -> &S {
        &self.session
    }

    /// The largest batch.
    pub fn max_frames(&self) -> usize {
        self.max_frames
    }
}
