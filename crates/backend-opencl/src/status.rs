use num_traits::FromPrimitive;
pub(crate) use ocl::core::Status as Name;
use ocl::ffi::cl_int;
use rhytid_core::{DeviceErrorKind, Error};

/// What an OpenCL function returned instead of `CL_SUCCESS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Status(pub(crate) cl_int);

impl Status {
    /// For `map_err`: the error of `device` while it was `doing` something, such as "reading a result".
    pub(crate) fn of(device: &str, doing: &str) -> impl FnOnce(Self) -> Error {
        move |status| {
            let kind = status.kind();
            let advice = match kind {
                DeviceErrorKind::OutOfMemory => {
                    ": the device's memory does not suffice; make batches smaller, store the basis as fp16, or close \
                     other programs that use the device"
                }
                DeviceErrorKind::Lost => ": the device was reset or taken away; open it again",
                _ => "; another version of the device's driver may help",
            };
            let name = status.name();
            Error::Device {
                kind,
                device: device.to_owned(),
                message: format!("{doing} failed with {name}{advice}"),
            }
        }
    }

    /// Whether it is the one of this name.
    pub(crate) fn is(self, name: Name) -> bool {
        self.0 == name as cl_int
    }

    fn name(self) -> String {
        Name::from_i32(self.0).map_or_else(|| format!("status {}", self.0), |name| name.to_string())
    }

    fn kind(self) -> DeviceErrorKind {
        match Name::from_i32(self.0) {
            Some(
                Name::CL_MEM_OBJECT_ALLOCATION_FAILURE
                | Name::CL_OUT_OF_RESOURCES
                | Name::CL_OUT_OF_HOST_MEMORY,
            ) => DeviceErrorKind::OutOfMemory,
            // Contexts and queues given to a driver are valid ones, until it has lost their device.
            Some(
                Name::CL_DEVICE_NOT_AVAILABLE | Name::CL_INVALID_CONTEXT | Name::CL_INVALID_COMMAND_QUEUE,
            ) => DeviceErrorKind::Lost,
            _ => DeviceErrorKind::Driver,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_what_failed_and_whose_fault_it_is() {
        let kinds = [
            (-4, DeviceErrorKind::OutOfMemory, "CL_MEM_OBJECT_ALLOCATION_FAILURE"),
            (-5, DeviceErrorKind::OutOfMemory, "CL_OUT_OF_RESOURCES"),
            (-6, DeviceErrorKind::OutOfMemory, "CL_OUT_OF_HOST_MEMORY"),
            (-2, DeviceErrorKind::Lost, "CL_DEVICE_NOT_AVAILABLE"),
            (-36, DeviceErrorKind::Lost, "CL_INVALID_COMMAND_QUEUE"),
            (-30, DeviceErrorKind::Driver, "CL_INVALID_VALUE"),
            (-12345, DeviceErrorKind::Driver, "status -12345"),
        ];
        for (status, expected, name) in kinds {
            match Status::of("opencl:3", "reading a result")(Status(status)) {
                Error::Device { kind, device, message } => {
                    assert_eq!((kind, device.as_str()), (expected, "opencl:3"), "{name}");
                    assert!(
                        message.starts_with(&format!("reading a result failed with {name}")),
                        "{message}"
                    );
                }
                other => panic!("{other}"),
            }
        }
    }
}
