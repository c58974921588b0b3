//! The driver's errors as errors of Rhytid.
use ash::vk;
use gpu_allocator::AllocationError;
use rhytid_core::{DeviceErrorKind, Error};

/// The remedy where memory does not suffice.
const LESS_MEMORY: &str = "evaluate fewer frames in a batch, or store the basis as fp16";

/// For `map_err`. `doing` is a noun phrase for the work that failed.
pub(crate) fn failed(device: &str, doing: &str) -> impl FnOnce(vk::Result) -> Error {
    move |result| {
        let kind = match result {
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
                DeviceErrorKind::OutOfMemory
            }
            vk::Result::ERROR_DEVICE_LOST => DeviceErrorKind::Lost,
            vk::Result::ERROR_FEATURE_NOT_PRESENT
            | vk::Result::ERROR_FORMAT_NOT_SUPPORTED
            | vk::Result::ERROR_EXTENSION_NOT_PRESENT
            | vk::Result::ERROR_LAYER_NOT_PRESENT
            | vk::Result::ERROR_INCOMPATIBLE_DRIVER => DeviceErrorKind::Unsupported,
            _ => DeviceErrorKind::Driver,
        };
        let advice = match kind {
            DeviceErrorKind::OutOfMemory => format!("; {LESS_MEMORY}"),
            DeviceErrorKind::Lost => "; open the device again, or use another".into(),
            _ => String::new(),
        };
        error(kind, device, format!("{doing} failed: {result} ({result:?}){advice}"))
    }
}

/// For `map_err`, after a request for memory for `what`.
pub(crate) fn not_allocated(device: &str, what: &str, bytes: u64) -> impl FnOnce(AllocationError) -> Error {
    move |cause| {
        // The allocator passes on the driver's errors as text, except `OutOfMemory`.
        let out_of_memory = matches!(cause, AllocationError::OutOfMemory)
            || cause.to_string().contains("ERROR_OUT_OF_HOST_MEMORY");
        if out_of_memory {
            return too_large(device, &format!("no room is left for {what} ({bytes} bytes)"));
        }
        let message = format!("the driver gives no memory for {what} ({bytes} bytes): {cause}");
        error(DeviceErrorKind::Driver, device, message)
    }
}

/// The error where `what` needs more memory than there is.
pub(crate) fn too_large(device: &str, what: &str) -> Error {
    let message = format!("the device's memory does not suffice: {what}; {LESS_MEMORY}");
    error(DeviceErrorKind::OutOfMemory, device, message)
}

pub(crate) fn error(kind: DeviceErrorKind, device: &str, message: String) -> Error {
    Error::Device { kind, device: device.to_owned(), message }
}
