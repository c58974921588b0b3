use crate::{Result, Rig};

/// One result of the runtime, so that a difference between devices is pinned to one kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// f: frames × F ratios.
    Strain,
    /// x̃: frames × V × 3, mesh units.
    LargeScale,
    /// Normals of x̃: frames × V × 3, of length 1, or 0 at a vertex without area.
    LargeScaleNormals,
    /// d in the local frames: frames × V × 3, mesh units.
    Detail,
    /// x: frames × V × 3, mesh units.
    Positions,
    /// Normals of x, as [`Stage::LargeScaleNormals`].
    Normals,
}

impl Stage {
    /// Every stage, in the order in which they are computed.
    pub const ALL: [Stage; 6] = [
        Stage::Strain,
        Stage::LargeScale,
        Stage::LargeScaleNormals,
        Stage::Detail,
        Stage::Positions,
        Stage::Normals,
    ];

    /// Numbers this stage has per frame for `rig`.
    pub fn values_per_frame<T: rhytid_kernels::Real>(self, rig: &Rig<T>) -> usize {
        match self {
            Stage::Strain => rig.strain_edges.len(),
            _ => rig.vertices() * 3,
        }
    }
}

/// Handle positions of a batch of frames, borrowed from the caller.
#[derive(Debug, Clone, Copy)]
pub struct HandleFrames<'a> {
    /// frames × H × 3, mesh units, head space, finite.
    pub positions: &'a [f32],
    /// Number of frames, at least 1.
    pub frames: usize,
}

/// What a backend says of a device.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct DeviceInfo {
    /// [`Backend::NAME`].
    pub backend: &'static str,
    /// Counts from 0 within the backend.
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// Name and version of its driver.
    pub driver: String,
    /// Memory in bytes that rigs and results can occupy; `None` where the driver does not tell.
    pub memory_bytes: Option<u64>,
}

impl DeviceInfo {
    /// `backend:index`, the name by which users ask for it.
    pub fn id(&self) -> String {
        format!("{}:{}", self.backend, self.index)
    }
}

/// A way to reach devices: a compute API, or the CPU.
pub trait Backend: Sized + Send + Sync + 'static {
    /// Lower case; the part of a device's id before the colon.
    const NAME: &'static str;
    /// A rig resident on one of its devices.
    type Session: Session;

    /// The devices present. `Ok(vec![])` means none here; never panics.
    ///
    /// # Errors
    /// [`crate::Error::Device`] if there is a driver and it fails.
    fn devices() -> Result<Vec<DeviceInfo>>;

    /// Opens one of [`Backend::devices`].
    ///
    /// # Errors
    /// [`crate::Error::Device`].
    fn open(device: &DeviceInfo) -> Result<Self>;

    /// Makes `rig` resident, with room for batches of up to `max_frames` frames (at least 1).
    /// `rig` has passed [`Rig::check`]; [`crate::Animator`] sees to it.
    ///
    /// # Errors
    /// [`crate::Error::Device`]: out of memory, unsupported, driver.
    fn upload(&self, rig: &Rig, max_frames: usize) -> Result<Self::Session>;
}

/// A rig resident on a device. Its inputs were validated by [`crate::Animator`].
pub trait Session: Send + 'static {
    /// Enqueues a batch of frames; the results stay on the device and replace the last ones.
    ///
    /// # Errors
    /// [`crate::Error::Device`]; the results are then undefined until the next success.
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()>;

    /// Waits, then copies one stage of the last batch into `out`, which is resized to
    /// frames × [`Stage::values_per_frame`]: the only way from device to host.
    ///
    /// # Errors
    /// [`crate::Error::Device`].
    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()>;
}

impl<S: Session + ?Sized> Session for Box<S> {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        (**self).evaluate(frames)
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        (**self).read(stage, out)
    }
}
