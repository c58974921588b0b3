use super::ToySession;
use rhytid_core::plan::PlanLimits;
use rhytid_core::{Backend, DeviceErrorKind, DeviceInfo, DeviceKind, Error, Result, Rig, UploadOptions};

/// An opened device, which is only its limits here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Toy {
    /// Any limits, however small: the plan splits larger work.
    pub limits: PlanLimits,
}

impl Backend for Toy {
    const NAME: &'static str = "toy";
    type Session = ToySession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(vec![DeviceInfo {
            backend: Self::NAME,
            index: 0,
            name: "references".into(),
            driver: "rhytid".into(),
            kind: DeviceKind::Cpu,
            memory_bytes: None,
            max_binding_bytes: None,
        }])
    }

    fn open(device: &DeviceInfo) -> Result<Self> {
        if device.backend == Self::NAME && device.index == 0 {
            return Ok(Self { limits: PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: u32::MAX } });
        }
        Err(Error::Device {
            kind: DeviceErrorKind::NotFound,
            device: device.id(),
            message: "the toy backend has one device, toy:0".into(),
        })
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<ToySession> {
        ToySession::new(rig, options, self.limits)
    }
}
