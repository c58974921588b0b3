//! A device as the suite drives it. Results are awaited, since a program in a browser may not block.
//! Elsewhere they are there at once.
use rhytid_core::{Animator, Device, DeviceInfo, HandleFrames, Result, Rig, Session, Stage, UploadOptions};

/// A device whose results are awaited. A [`Device`] waits by itself. A program in a browser implements this
/// trait for its own device.
pub trait AsyncDevice {
    /// A rig resident on it.
    type Session: AsyncSession;

    /// The device's description.
    fn info(&self) -> &DeviceInfo;

    /// As [`Device::upload`].
    ///
    /// # Errors
    /// As there.
    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<Self::Session>;
}

/// A rig resident on a device whose results are awaited.
pub trait AsyncSession {
    /// As [`Session::evaluate`].
    ///
    /// # Errors
    /// As there.
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()>;

    /// As [`Session::read`].
    ///
    /// # Errors
    /// As there.
    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> impl Future<Output = Result<()>>;
}

/// A session of any [`Device`], which waits within the first poll.
pub struct WaitingSession(Animator<Box<dyn Session>>);

impl AsyncDevice for Device {
    type Session = WaitingSession;

    fn info(&self) -> &DeviceInfo {
        self.info()
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<WaitingSession> {
        self.upload(rig, options).map(WaitingSession)
    }
}

impl AsyncSession for WaitingSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.0.session_mut().evaluate(frames)
    }

    async fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.0.session_mut().read(stage, out)
    }
}
