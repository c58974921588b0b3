//! The only list of backends. A new one is one line in [`BACKENDS`].

use rhytid_core::{Animator, Backend, DeviceErrorKind, DeviceInfo, Error, Result, Rig, Session};

/// An animator, whatever its backend.
pub type AnyAnimator = Animator<Box<dyn Session>>;

/// Fastest first: `auto` takes the first device of the first backend that has one.
const BACKENDS: &[Entry] = &[entry::<rhytid_backend_cpu::Cpu>()];

struct Entry {
    name: &'static str,
    devices: fn() -> Result<Vec<DeviceInfo>>,
    animator: fn(&DeviceInfo, &Rig, usize) -> Result<AnyAnimator>,
}

const fn entry<B: Backend>() -> Entry {
    Entry {
        name: B::NAME,
        devices: B::devices,
        animator: |device, rig, max_frames| Ok(Animator::new(&B::open(device)?, rig, max_frames)?.boxed()),
    }
}

/// Every device present, fastest first. A backend whose driver fails is a warning: the others still work.
pub fn devices() -> Vec<DeviceInfo> {
    let mut found = Vec::new();
    for backend in BACKENDS {
        match (backend.devices)() {
            Ok(devices) => found.extend(devices),
            Err(error) => log::warn!("the backend {} is left out: {error}", backend.name),
        }
    }
    found
}

/// The device that the user asked for: its id, or `auto`.
///
/// # Errors
/// [`Error::Device`] lists those present: a device asked for and absent is never replaced by another.
pub fn find(wanted: &str) -> Result<DeviceInfo> {
    let present = devices();
    let found = match wanted {
        "auto" => present.first(),
        id => present.iter().find(|device| device.id() == id),
    };
    found.cloned().ok_or_else(|| {
        let list: Vec<String> = present.iter().map(|d| format!("{} ({})", d.id(), d.name)).collect();
        let message = match list.as_slice() {
            [] => "no device was found here".to_owned(),
            list => format!("no such device here; expected auto or one of: {}", list.join(", ")),
        };
        Error::Device { kind: DeviceErrorKind::NotFound, device: wanted.to_owned(), message }
    })
}

/// Makes `rig` resident on `device`, with room for batches of `max_frames` frames.
///
/// # Errors
/// As [`Animator::new`].
pub fn animator(device: &DeviceInfo, rig: &Rig, max_frames: usize) -> Result<AnyAnimator> {
    let backend = BACKENDS.iter().find(|backend| backend.name == device.backend);
    let backend =
        backend.ok_or_else(|| Error::Internal(format!("no backend is called {}", device.backend)))?;
    (backend.animator)(device, rig, max_frames)
}
