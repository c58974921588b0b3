//! The list of devices, obtained through a [`Guard`].

use crate::backends::{BACKENDS, Entry, Found};
use crate::guard::{Guard, Heartbeat, PATIENCE};
use crate::{manifests, trial};
use rhytid_core::{DeviceErrorKind, DeviceInfo, DeviceKind, Error, NoProgress, Result};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Every device of this machine except those of the backends `left_out`. Each backend is asked separately,
/// all at the same time.
pub(crate) fn devices_but(guard: Guard, left_out: &[String]) -> Found {
    let wanted = || BACKENDS.iter().filter(|entry| !left_out.iter().any(|name| name == entry.name));
    let listed: Vec<_> = if guard.is_on() {
        std::thread::scope(|scope| {
            let threads: Vec<_> =
                wanted().map(|entry| (entry.name, scope.spawn(move || list_one(entry, guard)))).collect();
            let ended = |name| Err(failure(name, "listing its devices panicked".into()));
            threads
                .into_iter()
                .map(|(name, thread)| (name, thread.join().unwrap_or_else(|_| ended(name))))
                .collect()
        })
    } else {
        wanted().map(|entry| (entry.name, list_one(entry, guard))).collect()
    };
    let mut found = Found { devices: Vec::new(), failed: Vec::new() };
    for (name, listed) in listed {
        match listed {
            Ok(devices) => found.devices.extend(devices),
            Err(error) => found.failed.push((name, error)),
        }
    }
    found
}

/// The devices of one backend. `None` if this program has no such backend.
pub(crate) fn list(backend: &str, guard: Guard) -> Option<Result<Vec<DeviceInfo>>> {
    BACKENDS.iter().find(|entry| entry.name == backend).map(|entry| list_one(entry, guard))
}

fn list_one(entry: &Entry, guard: Guard) -> Result<Vec<DeviceInfo>> {
    if !guard.is_on() || entry.name == "cpu" {
        return (entry.devices)();
    }
    let answer = ask(entry.name, &[], guard).map_err(|error| culprits(entry.name, error, guard))?;
    let listed: Listed = serde_json::from_str(&answer)
        .map_err(|error| failure(entry.name, format!("its list of devices cannot be read: {error}")))?;
    match listed {
        Listed::Devices(devices) => Ok(devices.into_iter().map(|device| device.info(entry.name)).collect()),
        Listed::Failed(why) => Err(failure(entry.name, why)),
    }
}

fn ask(backend: &str, variables: &[(&str, &Path)], guard: Guard) -> Result<String> {
    guard.ask(&["list", backend], backend, variables, &NoProgress, |_| PATIENCE)
}

/// `error`, with the drivers that make the backend fail even when they are alone, and how to avoid them.
fn culprits(backend: &str, error: Error, guard: Guard) -> Error {
    let drivers = manifests::drivers(backend);
    let fails: Vec<&PathBuf> = std::thread::scope(|scope| {
        let looked: Vec<_> = drivers
            .iter()
            .map(|driver| {
                let alone = move || ask(backend, &manifests::alone(backend, driver), guard).is_err();
                (driver, scope.spawn(alone))
            })
            .collect();
        looked.into_iter().filter_map(|(driver, failed)| failed.join().ok()?.then_some(driver)).collect()
    });
    if fails.is_empty() {
        return error;
    }
    let names: Vec<String> = fails.iter().map(|driver| driver.display().to_string()).collect();
    let remedy = manifests::remedy(backend, &fails);
    failure(backend, format!("{}; the driver is {}: {remedy}", message_of(&error), names.join(" and ")))
}

/// The answer of a child.
#[derive(Serialize, Deserialize)]
enum Listed {
    Devices(Vec<ListedDevice>),
    Failed(String),
}

/// A [`DeviceInfo`] without its backend, which is known.
#[derive(Serialize, Deserialize)]
struct ListedDevice {
    index: usize,
    name: String,
    driver: String,
    kind: DeviceKind,
    memory_bytes: Option<u64>,
    max_binding_bytes: Option<u64>,
}

impl ListedDevice {
    fn new(info: DeviceInfo) -> Self {
        let DeviceInfo { index, name, driver, kind, memory_bytes, max_binding_bytes, .. } = info;
        Self { index, name, driver, kind, memory_bytes, max_binding_bytes }
    }

    fn info(self, backend: &'static str) -> DeviceInfo {
        let Self { index, name, driver, kind, memory_bytes, max_binding_bytes } = self;
        DeviceInfo { backend, index, name, driver, kind, memory_bytes, max_binding_bytes }
    }
}

/// The child's side of a [`Guard`]. `request` has the arguments that were added to its command: `list
/// BACKEND` or `try DEVICE`.
///
/// # Errors
/// [`Error::Input`] if it is neither, [`Error::Device`] if there is no such device, [`Error::Io`] if the
/// parent no longer listens.
pub fn answer(request: &[String]) -> Result<()> {
    let unknown = || Error::input(format!("{}: no request of a guard", request.join(" ")));
    let [what, of] = request else { return Err(unknown()) };
    if what == "try" {
        let gone = || Error::Device {
            kind: DeviceErrorKind::NotFound,
            device: of.clone(),
            message: "there is no such device any more".into(),
        };
        return trial::answer(&crate::backends::find(of).ok_or_else(gone)?);
    }
    let entry = BACKENDS.iter().find(|entry| what == "list" && entry.name == of).ok_or_else(unknown)?;
    let listed = match (entry.devices)() {
        Ok(devices) => Listed::Devices(devices.into_iter().map(ListedDevice::new).collect()),
        Err(error) => Listed::Failed(message_of(&error)),
    };
    Heartbeat.answer(&serde_json::to_string(&listed).map_err(|error| Error::Internal(error.to_string()))?)
}

/// The error of a backend whose drivers failed.
pub(crate) fn failure(backend: &str, message: String) -> Error {
    Error::Device { kind: DeviceErrorKind::Driver, device: backend.to_owned(), message }
}

/// An error's sentence without the device that it names.
pub(crate) fn message_of(error: &Error) -> String {
    match error {
        Error::Device { message, .. } => message.clone(),
        other => other.to_string(),
    }
}
