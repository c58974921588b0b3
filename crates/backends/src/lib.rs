//! The only list of backends: what the program, conformance and the benchmarks choose from. A new backend is one line
//! in [`BACKENDS`].
#![forbid(unsafe_code)]

use rhytid_core::{Backend, Device, DeviceErrorKind, DeviceInfo, Error, Result};

/// A backend, whatever its type.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// [`Backend::NAME`].
    pub name: &'static str,
    /// [`Backend::devices`].
    pub devices: fn() -> Result<Vec<DeviceInfo>>,
    /// [`Device::open`].
    pub open: fn(&DeviceInfo) -> Result<Device>,
}

const fn entry<B: Backend>() -> Entry {
    Entry { name: B::NAME, devices: B::devices, open: Device::open::<B> }
}

/// The backends that this program was built with.
pub const BACKENDS: &[Entry] = &[
    #[cfg(feature = "vulkan")]
    entry::<rhytid_backend_vulkan::Vulkan>(),
    #[cfg(feature = "opencl")]
    entry::<rhytid_backend_opencl::OpenCl>(),
    #[cfg(feature = "wgpu")]
    entry::<rhytid_backend_wgpu::Wgpu>(),
    entry::<rhytid_backend_cpu::Cpu>(),
];

/// The backends that this program was built without, and how to get them.
pub const LEFT_OUT: &[(&str, &str)] = &[
    #[cfg(not(feature = "vulkan"))]
    ("vulkan", "build with --features vulkan"),
    #[cfg(not(feature = "opencl"))]
    ("opencl", "build with --features opencl; it needs the OpenCL ICD loader (Debian: ocl-icd-opencl-dev)"),
    #[cfg(not(feature = "wgpu"))]
    ("wgpu", "build with --features wgpu"),
];

/// What is there on this machine.
#[derive(Debug)]
pub struct Found {
    /// Every device, in the order of [`BACKENDS`].
    pub devices: Vec<DeviceInfo>,
    /// Backends whose driver is there and fails, and how: the others still work.
    pub failed: Vec<(&'static str, Error)>,
}

/// Looks for the devices of every backend.
pub fn devices() -> Found {
    let mut found = Found { devices: Vec::new(), failed: Vec::new() };
    for backend in BACKENDS {
        match (backend.devices)() {
            Ok(devices) => found.devices.extend(devices),
            Err(error) => found.failed.push((backend.name, error)),
        }
    }
    found
}

/// Opens one of [`devices`].
///
/// # Errors
/// As [`Backend::open`].
pub fn open(device: &DeviceInfo) -> Result<Device> {
    let backend = BACKENDS.iter().find(|backend| backend.name == device.backend);
    let backend = backend.ok_or_else(|| Error::Device {
        kind: DeviceErrorKind::NotFound,
        device: device.id(),
        message: format!("this program was built without the backend {}", device.backend),
    })?;
    (backend.open)(device)
}
