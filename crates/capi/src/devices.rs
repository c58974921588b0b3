//! The devices of this machine.
use crate::arguments::{free, give, out};
use crate::enums::RhytidDeviceKind;
use crate::status::{RhytidStatus, c_text, guarded, told};
use rhytid::core::DeviceInfo;
use rhytid::devices::backends::{self, Missing};
use std::ffi::{CString, c_char};
use std::ptr::{null, null_mut};

/// The devices that were there when the list was made. It never changes, so any number of threads may use it.
pub struct RhytidDevices {
    devices: Vec<Device>,
    missing: Vec<CString>,
}

struct Device {
    id: CString,
    name: CString,
    driver: CString,
    kind: RhytidDeviceKind,
    memory_bytes: u64,
}

impl Device {
    fn new(info: &DeviceInfo) -> Self {
        Self {
            id: c_text(&info.id()),
            name: c_text(&info.name),
            driver: c_text(&info.driver),
            kind: RhytidDeviceKind::of(info.kind).unwrap_or(RhytidDeviceKind::Other),
            memory_bytes: info.memory_bytes.unwrap_or(0),
        }
    }
}

/// Looks for the devices of every backend that this library has. This asks the drivers, which can take a
/// second. *devices becomes the list, to be freed by rhytid_devices_free().
///
/// # Safety
/// `devices` leads to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_find(devices: *mut *mut RhytidDevices) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees this.
        let devices = unsafe { out(devices, "devices", null_mut()) }?;
        let found = backends::devices();
        let sentence = |missing: &Missing| c_text(&format!("{}: {}", missing.backend, missing.why));
        *devices = give(RhytidDevices {
            devices: found.devices.iter().map(Device::new).collect(),
            missing: found.missing().iter().map(sentence).collect(),
        });
        Ok(())
    })
}

/// Frees a list of devices. NULL is ignored.
///
/// # Safety
/// `devices` is null or a list that nobody uses any more, nor texts that it lent.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_free(devices: *mut RhytidDevices) {
    // SAFETY: the caller guarantees this.
    unsafe { free(devices) };
}

/// A fact of a device; `otherwise` if there is no such device.
///
/// # Safety
/// `devices` is null or a live list.
unsafe fn fact<T>(
    devices: *const RhytidDevices,
    index: usize,
    otherwise: T,
    tell: impl FnOnce(&Device) -> T,
) -> T {
    // SAFETY: the caller guarantees this.
    told(otherwise, || unsafe { devices.as_ref() }?.devices.get(index).map(tell))
}

/// How many devices there are. 0 for NULL.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_count(devices: *const RhytidDevices) -> usize {
    // SAFETY: the caller guarantees this.
    told(0, || Some(unsafe { devices.as_ref() }?.devices.len()))
}

/// The id of a device, such as "vulkan:0": what RhytidAnimatorOptions takes. NULL if there is no such device.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_id(devices: *const RhytidDevices, index: usize) -> *const c_char {
    // SAFETY: the caller guarantees this.
    unsafe { fact(devices, index, null(), |device| device.id.as_ptr()) }
}

/// The name of a device, as its driver gives it. NULL if there is no such device.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_name(devices: *const RhytidDevices, index: usize) -> *const c_char {
    // SAFETY: the caller guarantees this.
    unsafe { fact(devices, index, null(), |device| device.name.as_ptr()) }
}

/// The name and version of a device's driver. NULL if there is no such device.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_driver(devices: *const RhytidDevices, index: usize) -> *const c_char {
    // SAFETY: the caller guarantees this.
    unsafe { fact(devices, index, null(), |device| device.driver.as_ptr()) }
}

/// What is behind a device. RHYTID_DEVICE_KIND_OTHER if there is no such device.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_kind(
    devices: *const RhytidDevices,
    index: usize,
) -> RhytidDeviceKind {
    // SAFETY: the caller guarantees this.
    unsafe { fact(devices, index, RhytidDeviceKind::Other, |device| device.kind) }
}

/// The bytes that rigs and results can occupy on a device. 0 if the driver does not tell, or if there is no
/// such device.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_memory(devices: *const RhytidDevices, index: usize) -> u64 {
    // SAFETY: the caller guarantees this.
    unsafe { fact(devices, index, 0, |device| device.memory_bytes) }
}

/// How many backends have no device. 0 for NULL.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_missing_count(devices: *const RhytidDevices) -> usize {
    // SAFETY: the caller guarantees this.
    told(0, || Some(unsafe { devices.as_ref() }?.missing.len()))
}

/// A sentence that names a backend without a device, and says how to get one. NULL if there is no such
/// backend.
///
/// # Safety
/// `devices` is null or a live list.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_devices_missing(
    devices: *const RhytidDevices,
    index: usize,
) -> *const c_char {
    // SAFETY: the caller guarantees this.
    told(null(), || Some(unsafe { devices.as_ref() }?.missing.get(index)?.as_ptr()))
}
