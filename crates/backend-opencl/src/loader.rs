//! The C functions of OpenCL. They come from the *ICD loader*, a library that the process searches for when
//! it first needs them. The loader in turn finds the drivers. Nothing is linked, so a program also starts
//! without the library.
use libloading::{Error, Library};
use opencl_sys::cl_function_types::*;
use std::sync::OnceLock;

/// The ICD loader's usual names, in the order in which they are tried.
const NAMES: &[&str] = if cfg!(all(windows, target_arch = "x86")) {
    // The bindings have C's calling convention. The loader has that of Windows, which is different on this
    // processor.
    &[]
} else if cfg!(windows) {
    &["OpenCL.dll"]
} else if cfg!(target_os = "macos") {
    &["/System/Library/Frameworks/OpenCL.framework/OpenCL"]
} else {
    // The second name is that of Android and of development packages.
    &["libOpenCL.so.1", "libOpenCL.so"]
};

/// The contents of the bindings' types, which are an `Option` of a pointer to a function.
pub(crate) trait Optional {
    type Inner;
}

impl<T> Optional for Option<T> {
    type Inner = T;
}

macro_rules! functions {
    ($($name:ident: $optional:ident,)*) => {
        /// The functions that this backend calls. All belong to OpenCL 1.1 or older, so every loader has all
        /// of them.
        #[derive(Debug)]
        #[allow(non_snake_case, reason = "they are called as in C")]
        pub(crate) struct Functions {
            $(pub(crate) $name: <$optional as Optional>::Inner,)*
            /// The pointers are valid as long as the library is loaded.
            _library: Library,
        }

        impl Functions {
            /// The functions of a library. The error says which one it lacks.
            ///
            /// # Safety
            /// The library's functions with these names are those of OpenCL.
            unsafe fn from_library(library: Library) -> Result<Self, Error> {
                Ok(Self {
                    $(
                        // SAFETY: the type is that of OpenCL's function of this name; the pointer is kept
                        // with the library.
                        $name: unsafe {
                            *library.get::<<$optional as Optional>::Inner>(concat!(stringify!($name), "\0").as_bytes())?
                        },
                    )*
                    _library: library,
                })
            }
        }
    };
}

functions! {
    clBuildProgram: clBuildProgram_t,
    clCreateBuffer: clCreateBuffer_t,
    clCreateCommandQueue: clCreateCommandQueue_t,
    clCreateContext: clCreateContext_t,
    clCreateKernel: clCreateKernel_t,
    clCreateProgramWithSource: clCreateProgramWithSource_t,
    clEnqueueNDRangeKernel: clEnqueueNDRangeKernel_t,
    clEnqueueReadBuffer: clEnqueueReadBuffer_t,
    clEnqueueWriteBuffer: clEnqueueWriteBuffer_t,
    clFinish: clFinish_t,
    clFlush: clFlush_t,
    clGetDeviceIDs: clGetDeviceIDs_t,
    clGetDeviceInfo: clGetDeviceInfo_t,
    clGetEventInfo: clGetEventInfo_t,
    clGetEventProfilingInfo: clGetEventProfilingInfo_t,
    clGetPlatformIDs: clGetPlatformIDs_t,
    clGetPlatformInfo: clGetPlatformInfo_t,
    clGetProgramBuildInfo: clGetProgramBuildInfo_t,
    clReleaseCommandQueue: clReleaseCommandQueue_t,
    clReleaseContext: clReleaseContext_t,
    clReleaseEvent: clReleaseEvent_t,
    clReleaseKernel: clReleaseKernel_t,
    clReleaseMemObject: clReleaseMemObject_t,
    clReleaseProgram: clReleaseProgram_t,
    clSetKernelArg: clSetKernelArg_t,
    clWaitForEvents: clWaitForEvents_t,
}

/// The functions, if there is an OpenCL loader. It is searched for once, and never unloaded, since drivers do
/// not survive that.
pub(crate) fn functions() -> Option<&'static Functions> {
    static FUNCTIONS: OnceLock<Option<Functions>> = OnceLock::new();
    FUNCTIONS.get_or_init(|| already_there().or_else(|| load(NAMES))).as_ref()
}

/// Whether there is an OpenCL loader on this machine. If there is a loader but no device, a driver is
/// missing.
pub fn has_loader() -> bool {
    functions().is_some()
}

/// The functions that the process already has, as a linked program would use them. A tool such as Oclgrind is
/// loaded before the program, and so replaces the loader.
#[cfg(unix)]
fn already_there() -> Option<Functions> {
    let process = libloading::os::unix::Library::this();
    // SAFETY: these names are OpenCL's in every process.
    unsafe { Functions::from_library(process.into()) }.ok()
}

#[cfg(not(unix))]
fn already_there() -> Option<Functions> {
    None
}

/// The functions of the first library that exists and has all of them.
fn load(names: &[&str]) -> Option<Functions> {
    names.iter().find_map(|name| {
        // SAFETY: a library of these names is an OpenCL loader, whose initialisers may run in any process.
        let loaded = unsafe { Library::new(name).and_then(|library| Functions::from_library(library)) };
        loaded.inspect_err(|error| log::debug!("opencl: {name}: {error}")).ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_test_support::skip;

    #[test]
    fn what_is_not_there_or_is_not_opencl_gives_no_functions() {
        assert!(load(&[]).is_none());
        assert!(load(&["libOpenCL-that-nobody-has.so"]).is_none());
        // This library exists, and has none of the functions.
        let other = if cfg!(windows) { "kernel32.dll" } else { "libm.so.6" };
        assert!(load(&[other]).is_none());
    }

    #[test]
    fn a_loader_has_every_function_behind_a_name_that_is_not_there() {
        let names: Vec<&str> = ["libOpenCL-that-nobody-has.so"].iter().chain(NAMES).copied().collect();
        match load(&names) {
            Some(functions) => {
                let mut count = 0;
                // SAFETY: no entries are asked for, and `count` takes one number.
                let status = unsafe { (functions.clGetPlatformIDs)(0, std::ptr::null_mut(), &mut count) };
                assert!(status == 0 || count == 0, "{status}, {count}");
            }
            None => skip("there is no OpenCL loader here"),
        }
    }
}
