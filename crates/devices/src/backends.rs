//! The only list of backends. The program, conformance and the benchmarks choose from it. A new backend is
//! one line in [`BACKENDS`].
//!
//! ```
//! use rhytid_devices::backends;
//!
//! let found = backends::devices();
//! for device in &found.devices {
//!     println!("{}: {}", device.id(), device.name);
//! }
//! // Every backend is accounted for: it has a device, or what it lacks is said.
//! for name in backends::names() {
//!     let has_device = found.devices.iter().any(|device| device.backend == name);
//!     assert!(has_device || found.missing().iter().any(|missing| missing.backend == name));
//! }
//! ```
use rhytid_core::{Backend, Device, DeviceErrorKind, DeviceInfo, DeviceKind, Error, Result};

/// A backend, without its type.
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
    #[cfg(feature = "cpu")]
    entry::<rhytid_backend_cpu::Cpu>(),
];

/// The backends that this program was built without, and how to get them.
pub const LEFT_OUT: &[(&str, &str)] = &[
    #[cfg(not(feature = "cpu"))]
    ("cpu", "build with --features cpu"),
    #[cfg(not(feature = "vulkan"))]
    ("vulkan", "build with --features vulkan"),
    #[cfg(not(feature = "opencl"))]
    ("opencl", "build with --features opencl"),
    #[cfg(not(feature = "wgpu"))]
    ("wgpu", "build with --features wgpu"),
];

/// The devices of this machine.
#[derive(Debug)]
pub struct Found {
    /// Every device, in the order of [`BACKENDS`].
    pub devices: Vec<DeviceInfo>,
    /// Backends whose driver is present and fails, with the error. The others still work.
    pub failed: Vec<(&'static str, Error)>,
}

/// A backend without a device.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Missing {
    /// Its name.
    pub backend: &'static str,
    /// What is missing, and how to get it.
    pub why: String,
}

impl Found {
    /// The backends that have no device: those without a driver, those whose driver fails, and those that
    /// this program was built without.
    pub fn missing(&self) -> Vec<Missing> {
        let mut missing = Vec::new();
        for &Entry { name, .. } in BACKENDS {
            if let Some((_, error)) = self.failed.iter().find(|(failed, _)| *failed == name) {
                missing.push(Missing { backend: name, why: error.to_string() });
            } else if !self.devices.iter().any(|device| device.backend == name) {
                missing.push(Missing { backend: name, why: how_to_get(name).to_owned() });
            }
        }
        missing.extend(LEFT_OUT.iter().map(|&(backend, how)| Missing {
            backend,
            why: format!("this program was built without it; {how}"),
        }));
        missing
    }
}

/// What a backend without devices lacks, and how to get it.
fn how_to_get(backend: &str) -> &'static str {
    match backend {
        "vulkan" => {
            "no Vulkan driver was found; install your GPU's, or Mesa's (Debian: mesa-vulkan-drivers libvulkan1)"
        }
        #[cfg(feature = "opencl")]
        "opencl" if !rhytid_backend_opencl::has_loader() => {
            "no OpenCL loader was found (libOpenCL); install your GPU's driver, or PoCL, which runs on any CPU (Debian: \
             ocl-icd-libopencl1 pocl-opencl-icd)"
        }
        "opencl" => {
            "no OpenCL platform was found; install your GPU's, or PoCL, which runs on any CPU (Debian: pocl-opencl-icd)"
        }
        "wgpu" => "neither Vulkan, Metal, Direct3D 12 nor OpenGL was found; install your GPU's driver",
        _ => "no device was found",
    }
}

/// The names of all backends, including those that this program was built without.
pub fn names() -> Vec<&'static str> {
    BACKENDS.iter().map(|backend| backend.name).chain(LEFT_OUT.iter().map(|(name, _)| *name)).collect()
}

/// The device with this id, if it is present. If only a backend is named, its first device. Only its own
/// backend is asked: drivers of others are not touched.
pub fn find(id: &str) -> Option<DeviceInfo> {
    let backend = BACKENDS.iter().find(|backend| id.split(':').next() == Some(backend.name))?;
    (backend.devices)().ok()?.into_iter().find(|device| device.id() == id || device.backend == id)
}

/// The device with this id. If only a backend is named, its first device. Drivers of other backends are not
/// touched, unless the device is absent.
///
/// # Errors
/// [`Error::Device`] lists the devices that are present. An absent device is never replaced by another.
pub fn named(id: &str) -> Result<DeviceInfo> {
    find(id).ok_or_else(|| absent(id, &devices().devices))
}

/// The device for a program that asks for none: the first GPU with memory of its own, else any other GPU,
/// else the processor. The device is not tried; `choose_devices` does that.
///
/// # Errors
/// [`Error::Device`] says what each backend lacks, if there is no device.
pub fn first() -> Result<DeviceInfo> {
    let found = devices();
    let rank = |device: &DeviceInfo| match device.kind {
        DeviceKind::DiscreteGpu => 0,
        DeviceKind::IntegratedGpu => 1,
        DeviceKind::VirtualGpu => 2,
        // A driver for processors is slower than the backend `cpu`.
        DeviceKind::Cpu if device.backend == "cpu" => 3,
        _ => 4,
    };
    // Of equal ones, the first in the order of the list.
    let best = found.devices.iter().min_by_key(|device| rank(device)).cloned();
    best.ok_or_else(|| {
        let lacks = |missing: Missing| format!("{}: {}", missing.backend, missing.why);
        let lacks: Vec<String> = found.missing().into_iter().map(lacks).collect();
        let message = format!("no device is here: {}", lacks.join("; "));
        Error::Device { kind: DeviceErrorKind::NotFound, device: "auto".into(), message }
    })
}

/// The error if the requested device is not present.
pub(crate) fn absent(id: &str, present: &[DeviceInfo]) -> Error {
    let backend = id.split(':').next().unwrap_or_default();
    let list: Vec<String> = present.iter().map(|d| format!("{} ({})", d.id(), d.name)).collect();
    let left_out = LEFT_OUT.iter().find(|(name, _)| *name == backend);
    let hint = left_out.map(|(name, how)| format!("; this program was built without {name}: {how}"));
    Error::Device {
        kind: DeviceErrorKind::NotFound,
        device: id.to_owned(),
        message: format!(
            "no such device here; expected auto or one of: {}{}",
            list.join(", "),
            hint.unwrap_or_default()
        ),
    }
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
