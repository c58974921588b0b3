//! The part of OpenCL that this backend needs: owned objects, and a [`Status`] for every refusal of a driver.
use crate::loader::{Functions, functions};
use crate::status::Status;
use opencl_sys::*;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

pub(crate) type Result<T, E = Status> = std::result::Result<T, E>;

/// The functions, for callers that have a handle. A handle comes only from the loader, so the functions are
/// present.
fn cl() -> &'static Functions {
    functions().expect("there is a handle, so there is a loader")
}

fn check(status: cl_int) -> Result<()> {
    if status == CL_SUCCESS { Ok(()) } else { Err(Status(status)) }
}

macro_rules! owned {
    ($($(#[$doc:meta])* $name:ident, $raw:ident, $release:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Debug)]
        pub(crate) struct $name($raw);

        impl $name {
            /// Takes over the reference that a function returned together with its status.
            fn from_raw(raw: $raw, status: cl_int) -> Result<Self> {
                check(status)?;
                // The standard does not allow a null handle here, and a release of it would crash.
                if raw.is_null() { Err(Status(CL_OUT_OF_HOST_MEMORY)) } else { Ok(Self(raw)) }
            }
        }

        impl Drop for $name {
            fn drop(&mut self) {
                // SAFETY: the object is alive, since one reference to it is owned here.
                if let Err(status) = check(unsafe { (cl().$release)(self.0) }) {
                    log::debug!("{} returned {status:?}", stringify!($release));
                }
            }
        }

        // SAFETY: OpenCL's objects belong to no thread.
        unsafe impl Send for $name {}
    )*};
}

owned! {
    /// Programs, buffers and queues of a device are made in a context, and keep it alive.
    Context, cl_context, clReleaseContext;
    /// Runs commands one after another, in the order in which they were enqueued.
    Queue, cl_command_queue, clReleaseCommandQueue;
    /// Memory of a device.
    Buffer, cl_mem, clReleaseMemObject;
    /// Built source. Kernels keep it alive.
    Program, cl_program, clReleaseProgram;
    /// A function of a program, with its arguments. One thread at a time may use it.
    Kernel, cl_kernel, clReleaseKernel;
    /// The state of a command in a queue.
    Event, cl_event, clReleaseEvent;
}

// SAFETY: any number of threads may call OpenCL's functions at once, except `clSetKernelArg`.
unsafe impl Sync for Context {}
// SAFETY: as above.
unsafe impl Sync for Program {}
// SAFETY: as above.
unsafe impl Sync for Queue {}
// SAFETY: as above.
unsafe impl Sync for Buffer {}
// SAFETY: as above; the arguments are set through `&mut` alone.
unsafe impl Sync for Kernel {}
// SAFETY: as above.
unsafe impl Sync for Event {}

/// A platform: a driver. Never released.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Platform(cl_platform_id);

/// A device of a platform. Never released.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DeviceId {
    platform: cl_platform_id,
    device: cl_device_id,
}

// SAFETY: a handle to what lives as long as the process.
unsafe impl Send for DeviceId {}
// SAFETY: as above.
unsafe impl Sync for DeviceId {}

/// Every platform, in the loader's order. None where there is no loader.
pub(crate) fn platforms() -> Result<Vec<Platform>> {
    let Some(cl) = functions() else { return Ok(Vec::new()) };
    let mut count = 0;
    // SAFETY: no entries are asked for, and `count` takes one number.
    match check(unsafe { (cl.clGetPlatformIDs)(0, null_mut(), &mut count) }) {
        Err(Status(CL_PLATFORM_NOT_FOUND_KHR)) => return Ok(Vec::new()),
        found => found?,
    }
    if count == 0 {
        return Ok(Vec::new());
    }
    let mut platforms = vec![null_mut(); count as usize];
    // SAFETY: there is room for `count` entries.
    check(unsafe { (cl.clGetPlatformIDs)(count, platforms.as_mut_ptr(), &mut count) })?;
    platforms.truncate(count as usize);
    Ok(platforms.into_iter().map(Platform).collect())
}

impl Platform {
    pub(crate) fn string(self, what: cl_platform_info) -> Result<String> {
        // SAFETY: `info` passes room for as many bytes as it says.
        info(|size, to, needs| unsafe { (cl().clGetPlatformInfo)(self.0, what, size, to, needs) }).map(text)
    }

    /// The platform's devices, in its order.
    pub(crate) fn devices(self) -> Result<Vec<DeviceId>> {
        let all = CL_DEVICE_TYPE_ALL;
        let mut count = 0;
        // SAFETY: no entries are asked for, and `count` takes one number.
        match check(unsafe { (cl().clGetDeviceIDs)(self.0, all, 0, null_mut(), &mut count) }) {
            Err(Status(CL_DEVICE_NOT_FOUND)) => return Ok(Vec::new()),
            found => found?,
        }
        if count == 0 {
            return Ok(Vec::new());
        }
        let mut devices = vec![null_mut(); count as usize];
        // SAFETY: there is room for `count` entries.
        check(unsafe { (cl().clGetDeviceIDs)(self.0, all, count, devices.as_mut_ptr(), &mut count) })?;
        devices.truncate(count as usize);
        Ok(devices.into_iter().map(|device| DeviceId { platform: self.0, device }).collect())
    }
}

impl DeviceId {
    pub(crate) fn string(self, what: cl_device_info) -> Result<String> {
        self.bytes(what).map(text)
    }

    /// A number of 32 or 64 bits.
    pub(crate) fn number(self, what: cl_device_info) -> Result<u64> {
        number(&self.bytes(what)?)
    }

    fn bytes(self, what: cl_device_info) -> Result<Vec<u8>> {
        // SAFETY: `info` passes room for as many bytes as it says.
        info(|size, to, needs| unsafe { (cl().clGetDeviceInfo)(self.device, what, size, to, needs) })
    }
}

impl Context {
    pub(crate) fn new(device: DeviceId) -> Result<Self> {
        let properties = [CL_CONTEXT_PLATFORM as cl_context_properties, device.platform as _, 0];
        let mut status = 0;
        // SAFETY: the list of properties ends with 0, and there is one device.
        let raw = unsafe {
            (cl().clCreateContext)(properties.as_ptr(), 1, &device.device, None, null_mut(), &mut status)
        };
        Self::from_raw(raw, status)
    }
}

/// Why there is no program.
pub(crate) enum BuildError {
    /// The source did not compile. This is the compiler's log.
    Log(String),
    Status(Status),
}

impl From<Status> for BuildError {
    fn from(status: Status) -> Self {
        Self::Status(status)
    }
}

impl Program {
    pub(crate) fn build(
        context: &Context,
        device: DeviceId,
        source: &str,
        options: &str,
    ) -> Result<Self, BuildError> {
        let invalid = |_| Status(CL_INVALID_VALUE);
        let options = CString::new(options).map_err(invalid)?;
        let (mut start, length) = (source.as_ptr().cast(), source.len());
        let mut status = 0;
        // SAFETY: one string of `length` bytes.
        let raw = unsafe { (cl().clCreateProgramWithSource)(context.0, 1, &mut start, &length, &mut status) };
        let program = Self::from_raw(raw, status)?;
        // SAFETY: one device, options that end with 0, and no callback: the call returns when the build is
        // done.
        let built = unsafe {
            (cl().clBuildProgram)(program.0, 1, &device.device, options.as_ptr(), None, null_mut())
        };
        let Err(status) = check(built) else { return Ok(program) };
        let log = info(|size, to, needs| {
            // SAFETY: `info` passes room for as many bytes as it says.
            unsafe {
                (cl().clGetProgramBuildInfo)(program.0, device.device, CL_PROGRAM_BUILD_LOG, size, to, needs)
            }
        });
        match log.map(text) {
            Ok(log) if !log.is_empty() => Err(BuildError::Log(log)),
            _ if status == Status(CL_BUILD_PROGRAM_FAILURE) => {
                Err(BuildError::Log("the compiler does not say why".into()))
            }
            _ => Err(BuildError::Status(status)),
        }
    }
}

impl Buffer {
    /// A buffer of this many bytes. `flags` are `CL_MEM_…` without a host pointer.
    pub(crate) fn with_bytes(context: &Context, flags: cl_mem_flags, bytes: usize) -> Result<Self> {
        let mut status = 0;
        // SAFETY: no host memory is passed.
        let raw = unsafe { (cl().clCreateBuffer)(context.0, flags, bytes, null_mut(), &mut status) };
        Self::from_raw(raw, status)
    }
}

impl Kernel {
    pub(crate) fn new(program: &Program, name: &str) -> Result<Self> {
        let name = CString::new(name).map_err(|_| Status(CL_INVALID_KERNEL_NAME))?;
        let mut status = 0;
        // SAFETY: the name ends with 0.
        let raw = unsafe { (cl().clCreateKernel)(program.0, name.as_ptr(), &mut status) };
        Self::from_raw(raw, status)
    }

    /// Binds a buffer, which must outlive the kernel's last run.
    pub(crate) fn set_buffer(&mut self, index: usize, buffer: &Buffer) -> Result<()> {
        let value: *const cl_mem = &buffer.0;
        // SAFETY: the value of such an argument is a handle, and is copied.
        check(unsafe { (cl().clSetKernelArg)(self.0, index as cl_uint, size_of::<cl_mem>(), value.cast()) })
    }

    /// Sets a structure of words.
    pub(crate) fn set_words(&mut self, index: usize, words: &[u32]) -> Result<()> {
        // SAFETY: as many bytes as there are, which are copied.
        check(unsafe {
            (cl().clSetKernelArg)(self.0, index as cl_uint, size_of_val(words), words.as_ptr().cast())
        })
    }
}

impl Queue {
    /// A queue that runs commands in order, with times for every command.
    pub(crate) fn new(context: &Context, device: DeviceId) -> Result<Self> {
        let mut status = 0;
        // SAFETY: the device is the context's.
        let raw = unsafe {
            (cl().clCreateCommandQueue)(context.0, device.device, CL_QUEUE_PROFILING_ENABLE, &mut status)
        };
        Self::from_raw(raw, status)
    }

    /// Fills the start of a buffer, and waits.
    pub(crate) fn write(&self, buffer: &Buffer, data: &[u8]) -> Result<()> {
        let (size, from) = (data.len(), data.as_ptr().cast());
        // SAFETY: `data` has `size` bytes, and is not needed after the blocking call.
        check(unsafe {
            (cl().clEnqueueWriteBuffer)(self.0, buffer.0, CL_TRUE, 0, size, from, 0, null(), null_mut())
        })
    }

    /// Enqueues filling the start of a buffer.
    ///
    /// # Safety
    /// `data` stays where it is, unchanged, until the event is complete.
    pub(crate) unsafe fn start_write(&self, buffer: &Buffer, data: &[u8]) -> Result<Event> {
        let (size, from) = (data.len(), data.as_ptr().cast());
        let mut event = null_mut();
        // SAFETY: `data` has `size` bytes, for as long as it takes.
        let status = unsafe {
            (cl().clEnqueueWriteBuffer)(self.0, buffer.0, CL_FALSE, 0, size, from, 0, null(), &mut event)
        };
        Event::from_raw(event, status)
    }

    /// Enqueues a kernel on `groups` workgroups of `group_size` × 1.
    ///
    /// # Safety
    /// All its arguments are set and fit, so the kernel stays within its buffers.
    pub(crate) unsafe fn run(&self, kernel: &Kernel, groups: [u32; 2], group_size: usize) -> Result<Event> {
        let global = [groups[0] as usize * group_size, groups[1] as usize];
        let local = [group_size, 1];
        let mut event = null_mut();
        // SAFETY: both sizes have two numbers; the kernel is sound by this function's contract.
        let status = unsafe {
            let (global, local) = (global.as_ptr(), local.as_ptr());
            (cl().clEnqueueNDRangeKernel)(self.0, kernel.0, 2, null(), global, local, 0, null(), &mut event)
        };
        Event::from_raw(event, status)
    }

    /// Waits until all earlier commands are done, and copies the start of a buffer out.
    pub(crate) fn read(&self, buffer: &Buffer, out: &mut [u8]) -> Result<()> {
        let (size, to) = (out.len(), out.as_mut_ptr().cast());
        // SAFETY: `out` has room for `size` bytes, and the call blocks.
        check(unsafe {
            (cl().clEnqueueReadBuffer)(self.0, buffer.0, CL_TRUE, 0, size, to, 0, null(), null_mut())
        })
    }

    /// Tells the device to begin.
    pub(crate) fn flush(&self) -> Result<()> {
        // SAFETY: the queue is alive.
        check(unsafe { (cl().clFlush)(self.0) })
    }

    /// Waits until all enqueued commands are done.
    pub(crate) fn finish(&self) -> Result<()> {
        // SAFETY: the queue is alive.
        check(unsafe { (cl().clFinish)(self.0) })
    }
}

impl Event {
    /// Waits for all events. The status is that of the first one whose command failed.
    pub(crate) fn wait<'a>(events: impl Iterator<Item = &'a Self> + Clone) -> Result<()> {
        let raw: Vec<cl_event> = events.clone().map(|event| event.0).collect();
        if raw.is_empty() {
            return Ok(());
        }
        // SAFETY: as many events as are passed, all alive.
        let waited = check(unsafe { (cl().clWaitForEvents)(raw.len() as cl_uint, raw.as_ptr()) });
        match waited {
            Err(status) if status == Status(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST) => {
                events.clone().try_for_each(Self::succeeded)?;
                Err(status)
            }
            waited => waited,
        }
    }

    fn succeeded(&self) -> Result<()> {
        let what = CL_EVENT_COMMAND_EXECUTION_STATUS;
        // SAFETY: `info` passes room for as many bytes as it says.
        let state = info(|size, to, needs| unsafe { (cl().clGetEventInfo)(self.0, what, size, to, needs) })?;
        let state = number(&state)? as cl_int;
        if state < 0 { Err(Status(state)) } else { Ok(()) }
    }

    /// The time that the completed command ran, in nanoseconds.
    pub(crate) fn nanoseconds(&self) -> Result<u64> {
        let at = |what: cl_profiling_info| {
            // SAFETY: `info` passes room for as many bytes as it says.
            info(|size, to, needs| unsafe { (cl().clGetEventProfilingInfo)(self.0, what, size, to, needs) })
                .and_then(|bytes| number(&bytes))
        };
        Ok(at(CL_PROFILING_COMMAND_END)?.saturating_sub(at(CL_PROFILING_COMMAND_START)?))
    }
}

/// Asks for the size of an answer, then for the answer.
fn info(ask: impl Fn(usize, *mut c_void, *mut usize) -> cl_int) -> Result<Vec<u8>> {
    let mut size = 0;
    check(ask(0, null_mut(), &mut size))?;
    let mut bytes = vec![0; size];
    if size > 0 {
        check(ask(size, bytes.as_mut_ptr().cast(), null_mut()))?;
    }
    Ok(bytes)
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8_lossy(&bytes).trim_matches(|c: char| c == '\0' || c.is_whitespace()).to_owned()
}

fn number(bytes: &[u8]) -> Result<u64> {
    match bytes.len() {
        4 => Ok(bytemuck::pod_read_unaligned::<u32>(bytes).into()),
        8 => Ok(bytemuck::pod_read_unaligned(bytes)),
        _ => Err(Status(CL_INVALID_VALUE)),
    }
}
