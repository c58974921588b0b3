//! The processor as a device.
use crate::CpuSession;
use rhytid_core::{Backend, DeviceErrorKind, DeviceInfo, DeviceKind, Error, Result, Rig, UploadOptions};
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

/// The processor on which this program runs. Work is spread over rayon's global thread pool.
#[derive(Debug, Clone, Copy)]
pub struct Cpu;

impl Backend for Cpu {
    const NAME: &'static str = "cpu";
    type Session = CpuSession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        let what = RefreshKind::nothing()
            .with_cpu(CpuRefreshKind::nothing())
            .with_memory(MemoryRefreshKind::nothing().with_ram());
        // Facts that the system does not tell are left out. The processor is available without them.
        let system = System::new_with_specifics(what).ok();
        let name = system.as_ref().and_then(|s| s.cpus().first()).map_or("", |cpu| cpu.brand().trim());
        Ok(vec![DeviceInfo {
            backend: Self::NAME,
            index: 0,
            name: if name.is_empty() { "processor".into() } else { name.into() },
            driver: format!("rhytid {}, {} threads", env!("CARGO_PKG_VERSION"), rayon::current_num_threads()),
            kind: DeviceKind::Cpu,
            memory_bytes: system.as_ref().map(System::total_memory).filter(|&bytes| bytes > 0),
            max_binding_bytes: None,
        }])
    }

    fn open(device: &DeviceInfo) -> Result<Self> {
        if device.backend == Self::NAME && device.index == 0 {
            return Ok(Self);
        }
        Err(Error::Device {
            kind: DeviceErrorKind::NotFound,
            device: device.id(),
            message: "the CPU backend has one device, cpu:0".into(),
        })
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<CpuSession> {
        Ok(CpuSession::new(rig, options))
    }
}
