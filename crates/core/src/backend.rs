//! The traits by which any device evaluates a rig, and the description of a device.
use crate::listed::listed;
use crate::{Animator, ClusteredBasis, Error, Result, Rig};
use half::f16;
use rayon::prelude::*;
use rhytid_kernels::Real;
use std::time::Duration;

/// The largest fp16 number.
const LARGEST_FP16: f32 = 65504.0;

listed! {
    /// One result of the runtime. With stages, a difference between devices can be traced to one kernel.
    /// Stages are computed in this order.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Stage {
        /// f: frames × F ratios.
        Strain,
        /// x̃: frames × V × 3, mesh units.
        LargeScale,
        /// Normals of x̃: frames × V × 3, of length 1, or 0 at a vertex without area. If no other stage reads
        /// them, they are computed when they are read: see
        /// [`Plan::is_on_demand`](crate::plan::Plan::is_on_demand).
        LargeScaleNormals,
        /// d in the tangent frames, or along the mesh's axes ([`Rig::vector_wrinkles`]): frames × V × 3, mesh
        /// units.
        Detail,
        /// x: frames × V × 3, mesh units.
        Positions,
        /// Normals of x, as [`Stage::LargeScaleNormals`].
        Normals,
    }
}

impl Stage {
    /// Its name in reports and in programs of other languages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Strain => "strain",
            Self::LargeScale => "large_scale",
            Self::LargeScaleNormals => "large_scale_normals",
            Self::Detail => "detail",
            Self::Positions => "positions",
            Self::Normals => "normals",
        }
    }

    /// Numbers this stage has per frame for `rig`.
    pub fn values_per_frame<T: Real>(self, rig: &Rig<T>) -> usize {
        match self {
            Stage::Strain => rig.handles().strain_edges.len(),
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

impl<'a> HandleFrames<'a> {
    /// These positions as frames of a rig with H handles, at least 1. This is the one place where handle
    /// positions are checked.
    ///
    /// # Errors
    /// [`Error::Input`] if the length is not a multiple of 3 H, or the batch is empty or larger than
    /// `max_frames`. [`Error::Input`] if a number is not finite.
    pub fn checked(positions: &'a [f32], handles: usize, max_frames: usize) -> Result<Self> {
        let per_frame = handles * 3;
        let frames = positions.len() / per_frame;
        if frames * per_frame != positions.len() || frames == 0 {
            return Err(Error::mismatch(format!(
                "a batch of handle positions has {} numbers, expected a multiple of {handles} handles × 3 above 0",
                positions.len()
            )));
        }
        if frames > max_frames {
            return Err(Error::too_large(format!(
                "a batch has {frames} frames, expected at most {max_frames}: split it or make more room"
            )));
        }
        if let Some(i) = positions.iter().position(|x| !x.is_finite()) {
            return Err(Error::out_of_range(format!(
                "frame {} of a batch: handle {} is at {}, expected a finite position",
                i / per_frame,
                i % per_frame / 3,
                positions[i]
            )));
        }
        Ok(Self { positions, frames })
    }
}

/// How a rig is made resident.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UploadOptions {
    /// The largest batch, at least 1.
    pub max_frames: usize,
    /// How the basis is kept.
    pub basis: BasisStorage,
}

impl UploadOptions {
    /// For batches of up to `max_frames` frames, everything in `f32`.
    pub const fn frames(max_frames: usize) -> Self {
        Self { max_frames, basis: BasisStorage::F32 }
    }

    /// Checks that `rig` can be made resident in this way.
    ///
    /// # Errors
    /// [`Error::Input`] if `max_frames` is 0, or the basis does not fit into its storage.
    pub fn check(&self, rig: &Rig) -> Result<()> {
        if self.max_frames == 0 {
            return Err(Error::out_of_range("a batch has at least 1 frame, found max_frames = 0"));
        }
        if self.basis == BasisStorage::F16
            && let Some(i) = rig.basis().as_slice().iter().position(|b| b.abs() > LARGEST_FP16)
        {
            return Err(Error::out_of_range(format!(
                "the basis of vertex {} has the number {}, expected at most {LARGEST_FP16} in size to be stored as \
                 fp16; store it as f32",
                i / rig.handles().len(),
                rig.basis().as_slice()[i]
            )));
        }
        Ok(())
    }
}

/// How a device keeps the basis, by far the largest part of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BasisStorage {
    /// As the rig has it, fp32.
    #[default]
    F32,
    /// Rounded to the nearest fp16 number: half the memory and half the traffic. The rows of handles stay
    /// exact, so markers are still met. The weights of the bands have 16 bits, too.
    /// [`BasisStorage::largest_error`] bounds the error of the other vertices.
    F16,
    /// As the factors of a [`ClusteredBasis`]: a third of the memory for a face of 27,000 vertices, and an
    /// eighth for one of 500,000. Markers are still met. If no handle moves by more than 30 mm, the basis
    /// moves no vertex by more than 0.005 mm too far along an axis. The weights of the bands have 16 bits,
    /// too.
    Clustered,
}

impl BasisStorage {
    /// Each of them.
    pub const ALL: [Self; 3] = [Self::F32, Self::F16, Self::Clustered];

    /// Whether devices keep the weights of the bands in 16 bits ([`Rig::as_stored`]). `vector_wrinkles` is
    /// [`Rig::vector_wrinkles`].
    pub fn has_narrow_weights(self, vector_wrinkles: bool) -> bool {
        self != Self::F32 && vector_wrinkles
    }

    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16 => "f16",
            Self::Clustered => "clustered",
        }
    }

    /// The motion of handles for which errors are stated, in millimetres.
    pub const MOTION_MM: f64 = 30.0;

    /// The same motion in the rig's mesh units.
    pub fn motion<T: Real>(rig: &Rig<T>) -> f64 {
        Self::MOTION_MM / 1e3 / rig.surface().metres_per_unit
    }

    /// A bound of how far what a device keeps moves any vertex of `rig` along an axis, in mesh units, if no
    /// handle moves farther than [`BasisStorage::motion`]. Counted are the basis and, where the wrinkles are
    /// functions of vector strains, the weights of the bands ([`Rig::as_stored`]). Where handles turn,
    /// vertices move more, and so do the errors: the bound leaves this out. 0 for [`BasisStorage::F32`].
    pub fn largest_error(self, rig: &Rig) -> f64 {
        let of_rows: Vec<f64> = match self {
            Self::F32 => return 0.0,
            Self::F16 => {
                let error = |x: &f32| f64::from((x - f16::from_f32(*x).to_f32()).abs());
                rig.basis().par_rows().map(|row| row.iter().map(error).sum()).collect()
            }
            Self::Clustered => {
                let basis = ClusteredBasis::new(rig);
                let cluster = |v: usize| &basis.clusters()[v / ClusteredBasis::VERTICES];
                (0..rig.vertices()).map(|v| cluster(v).largest_error).collect()
            }
        };
        let errors = of_rows.iter().zip(rig.errors_of_bands(self));
        errors.map(|(of_row, of_bands)| of_row * Self::motion(rig) + of_bands).fold(0.0, f64::max)
    }
}

listed! {
    /// What kind of processor is behind a device.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    #[non_exhaustive]
    pub enum DeviceKind {
        /// A processor. Behind a GPU's API it is a software driver.
        Cpu,
        /// A GPU that shares the processor's memory.
        IntegratedGpu,
        /// A GPU with memory of its own.
        DiscreteGpu,
        /// A part of a GPU, given to a virtual machine.
        VirtualGpu,
        /// Anything else, or a device whose driver does not tell.
        Other,
    }
}

/// What a backend says of a device.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct DeviceInfo {
    /// [`Backend::NAME`].
    pub backend: &'static str,
    /// Counts from 0 within the backend. In wgpu, devices of OpenGL always count from 8.
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// Name and version of its driver.
    pub driver: String,
    /// What is behind it.
    pub kind: DeviceKind,
    /// Memory in bytes that rigs and results can occupy; `None` where the driver does not tell.
    pub memory_bytes: Option<u64>,
    /// The largest array that a kernel can address, in bytes. Larger arrays are split. `None` where there is
    /// no limit.
    pub max_binding_bytes: Option<u64>,
}

impl DeviceInfo {
    /// `backend:index`, the name by which users ask for it.
    pub fn id(&self) -> String {
        format!("{}:{}", self.backend, self.index)
    }

    /// Whether this is an API for GPUs that runs on the processor: right for tests, not for speed.
    pub fn is_software_driver(&self) -> bool {
        self.kind == DeviceKind::Cpu && self.backend != "cpu"
    }
}

/// A way to reach devices: a compute API, or the CPU.
pub trait Backend: Sized + Send + Sync + 'static {
    /// Lower case; the part of a device's id before the colon.
    const NAME: &'static str;
    /// A rig resident on one of its devices.
    type Session: Session;

    /// The devices present. `Ok(vec![])` means that there are none. Never panics.
    ///
    /// # Errors
    /// [`crate::Error::Device`] if a driver is present and fails.
    fn devices() -> Result<Vec<DeviceInfo>>;

    /// Opens one of [`Backend::devices`].
    ///
    /// # Errors
    /// [`crate::Error::Device`].
    fn open(device: &DeviceInfo) -> Result<Self>;

    /// Makes `rig` resident. [`crate::Animator`] has [checked](UploadOptions::check) `options`.
    ///
    /// # Errors
    /// [`crate::Error::Device`]: out of memory, unsupported, driver.
    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<Self::Session>;
}

/// A rig resident on a device. Its inputs were validated by [`crate::Animator`].
pub trait Session: Send + 'static {
    /// Enqueues a batch of frames. The results stay on the device and replace those of the last batch.
    ///
    /// # Errors
    /// [`crate::Error::Device`]. The results are then undefined until the next success.
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()>;

    /// Waits, then copies one stage of the last batch into `out`, which is resized to frames ×
    /// [`Stage::values_per_frame`]. This is the only way from device to host.
    ///
    /// # Errors
    /// [`crate::Error::Device`].
    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()>;

    /// Waits, then says how long the device computed on each stage of the last batch, in the order of
    /// [`Stage::ALL`]. A stage that was computed together with another one has 0. `None` where the device
    /// cannot measure.
    ///
    /// # Errors
    /// [`crate::Error::Device`].
    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>>;
}

impl<S: Session + ?Sized> Session for Box<S> {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        (**self).evaluate(frames)
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        (**self).read(stage, out)
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        (**self).stage_times()
    }
}

/// An opened device of any backend.
pub struct Device {
    info: DeviceInfo,
    #[expect(clippy::type_complexity, reason = "it is written once")]
    upload: Box<dyn Fn(&Rig, UploadOptions) -> Result<Animator<Box<dyn Session>>> + Send + Sync>,
}

impl Device {
    /// Opens one of `B`'s devices.
    ///
    /// # Errors
    /// As [`Backend::open`].
    pub fn open<B: Backend>(info: &DeviceInfo) -> Result<Self> {
        Ok(Self::new(info.clone(), B::open(info)?))
    }

    /// A device that is open already.
    pub fn new<B: Backend>(info: DeviceInfo, backend: B) -> Self {
        let upload =
            move |rig: &Rig, options: UploadOptions| Ok(Animator::new(&backend, rig, options)?.boxed());
        Self { info, upload: Box::new(upload) }
    }

    /// What it is.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Makes `rig` resident.
    ///
    /// # Errors
    /// As [`Animator::new`].
    pub fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<Animator<Box<dyn Session>>> {
        (self.upload)(rig, options)
    }
}
