//! An animator of any backend, and what some backends offer beyond the others.
#[cfg(any(feature = "cpu", feature = "vulkan"))]
use rhytid::core::Backend;
use rhytid::core::Session;
use rhytid::devices::backends;
#[cfg(feature = "cpu")]
use rhytid::devices::cpu::{Cpu, CpuSession};
#[cfg(feature = "vulkan")]
use rhytid::devices::vulkan::{Vulkan, VulkanSession};
use rhytid::{Animator, Result, Rig, Stage, UploadOptions};
use std::time::Duration;

/// An animator of any backend.
#[allow(clippy::large_enum_variant, reason = "there are few, and each is in a box")]
pub(crate) enum Held {
    /// Its results are in memory of this process.
    #[cfg(feature = "cpu")]
    Cpu(Animator<CpuSession>),
    /// Its results are in buffers that a renderer can use, or are copied to memory that the device writes.
    #[cfg(feature = "vulkan")]
    Vulkan(Animator<VulkanSession>),
    Any(Animator<Box<dyn Session>>),
}

/// Calls the same method whatever the backend is.
macro_rules! each {
    ($held:expr, $animator:ident => $call:expr) => {
        match $held {
            #[cfg(feature = "cpu")]
            Held::Cpu($animator) => $call,
            #[cfg(feature = "vulkan")]
            Held::Vulkan($animator) => $call,
            Held::Any($animator) => $call,
        }
    };
}

impl Held {
    /// Uploads a rig to a device, and gives the device's id. `None` is the device that [`backends::first`]
    /// chooses.
    pub(crate) fn new(rig: &Rig, device: Option<&str>, options: UploadOptions) -> Result<(Self, String)> {
        let info = match device {
            Some(id) => backends::named(id)?,
            None => backends::first()?,
        };
        let held = match info.backend {
            #[cfg(feature = "cpu")]
            Cpu::NAME => Self::Cpu(Animator::new(&Cpu::open(&info)?, rig, options)?),
            #[cfg(feature = "vulkan")]
            Vulkan::NAME => Self::Vulkan(Animator::new(&Vulkan::open(&info)?, rig, options)?),
            _ => Self::Any(backends::open(&info)?.upload(rig, options)?),
        };
        Ok((held, info.id()))
    }

    pub(crate) fn evaluate(&mut self, positions: &[f32]) -> Result<()> {
        each!(self, animator => animator.evaluate(positions))
    }

    pub(crate) fn stage_times(&mut self) -> Result<Option<[Duration; Stage::ALL.len()]>> {
        each!(self, animator => animator.stage_times())
    }

    /// Hands a stage of the last batch to `take`: in memory that the backend has anyway, or else in `copy`.
    pub(crate) fn stage<T>(
        &mut self,
        stage: Stage,
        copy: &mut Vec<f32>,
        take: impl FnOnce(&[f32]) -> T,
    ) -> Result<T> {
        match self {
            #[cfg(feature = "cpu")]
            Self::Cpu(animator) => {
                if let Some(lent) = animator.read_by(|session| Ok(session.result(stage)))? {
                    return Ok(take(lent));
                }
            }
            #[cfg(feature = "vulkan")]
            Self::Vulkan(animator) => {
                if let Some(lent) = animator.read_by(|session| session.map(stage))? {
                    return Ok(take(lent));
                }
            }
            Self::Any(_) => {}
        }
        each!(self, animator => animator.read(stage, copy))?;
        Ok(take(copy))
    }
}
