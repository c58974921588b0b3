//! OpenCL's status codes as errors.
use opencl_sys::*;
use rhytid_core::{DeviceErrorKind, Error};

/// OpenCL's name of a status.
macro_rules! name {
    ($status:expr, $($name:ident)*) => {
        match $status {
            $($name => stringify!($name).to_owned(),)*
            other => format!("status {other}"),
        }
    };
}

/// The value that an OpenCL function returned instead of `CL_SUCCESS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Status(pub(crate) cl_int);

impl Status {
    /// For `map_err`: the error of `device` while it was `doing` something, such as "reading a result".
    pub(crate) fn error(device: &str, doing: &str) -> impl FnOnce(Self) -> Error {
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

    fn name(self) -> String {
        name! {
            self.0,
            CL_SUCCESS CL_DEVICE_NOT_FOUND CL_DEVICE_NOT_AVAILABLE CL_COMPILER_NOT_AVAILABLE
            CL_MEM_OBJECT_ALLOCATION_FAILURE CL_OUT_OF_RESOURCES CL_OUT_OF_HOST_MEMORY
            CL_PROFILING_INFO_NOT_AVAILABLE CL_MEM_COPY_OVERLAP CL_IMAGE_FORMAT_MISMATCH
            CL_IMAGE_FORMAT_NOT_SUPPORTED CL_BUILD_PROGRAM_FAILURE CL_MAP_FAILURE
            CL_MISALIGNED_SUB_BUFFER_OFFSET CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST
            CL_COMPILE_PROGRAM_FAILURE CL_LINKER_NOT_AVAILABLE CL_LINK_PROGRAM_FAILURE
            CL_DEVICE_PARTITION_FAILED CL_KERNEL_ARG_INFO_NOT_AVAILABLE CL_INVALID_VALUE
            CL_INVALID_DEVICE_TYPE CL_INVALID_PLATFORM CL_INVALID_DEVICE CL_INVALID_CONTEXT
            CL_INVALID_QUEUE_PROPERTIES CL_INVALID_COMMAND_QUEUE CL_INVALID_HOST_PTR CL_INVALID_MEM_OBJECT
            CL_INVALID_IMAGE_FORMAT_DESCRIPTOR CL_INVALID_IMAGE_SIZE CL_INVALID_SAMPLER CL_INVALID_BINARY
            CL_INVALID_BUILD_OPTIONS CL_INVALID_PROGRAM CL_INVALID_PROGRAM_EXECUTABLE CL_INVALID_KERNEL_NAME
            CL_INVALID_KERNEL_DEFINITION CL_INVALID_KERNEL CL_INVALID_ARG_INDEX CL_INVALID_ARG_VALUE
            CL_INVALID_ARG_SIZE CL_INVALID_KERNEL_ARGS CL_INVALID_WORK_DIMENSION CL_INVALID_WORK_GROUP_SIZE
            CL_INVALID_WORK_ITEM_SIZE CL_INVALID_GLOBAL_OFFSET CL_INVALID_EVENT_WAIT_LIST CL_INVALID_EVENT
            CL_INVALID_OPERATION CL_INVALID_GL_OBJECT CL_INVALID_BUFFER_SIZE CL_INVALID_MIP_LEVEL
            CL_INVALID_GLOBAL_WORK_SIZE CL_INVALID_PROPERTY CL_INVALID_IMAGE_DESCRIPTOR
            CL_INVALID_COMPILER_OPTIONS CL_INVALID_LINKER_OPTIONS CL_INVALID_DEVICE_PARTITION_COUNT
            CL_INVALID_PIPE_SIZE CL_INVALID_DEVICE_QUEUE CL_INVALID_SPEC_ID CL_MAX_SIZE_RESTRICTION_EXCEEDED
            CL_PLATFORM_NOT_FOUND_KHR
        }
    }

    fn kind(self) -> DeviceErrorKind {
        match self.0 {
            CL_MEM_OBJECT_ALLOCATION_FAILURE | CL_OUT_OF_RESOURCES | CL_OUT_OF_HOST_MEMORY => {
                DeviceErrorKind::OutOfMemory
            }
            // Contexts and queues passed to a driver are valid, unless the driver has lost their device.
            CL_DEVICE_NOT_AVAILABLE | CL_INVALID_CONTEXT | CL_INVALID_COMMAND_QUEUE => DeviceErrorKind::Lost,
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
            (-1001, DeviceErrorKind::Driver, "CL_PLATFORM_NOT_FOUND_KHR"),
            (-12345, DeviceErrorKind::Driver, "status -12345"),
        ];
        for (status, expected, name) in kinds {
            match Status::error("opencl:3", "reading a result")(Status(status)) {
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
