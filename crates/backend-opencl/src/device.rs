//! OpenCL devices, found and opened.
use crate::OpenClSession;
use crate::cl::{self, BuildError, Context, DeviceId, Platform, Program};
use crate::status::Status;
use opencl_sys::*;
use rhytid_core::plan::PlanLimits;
use rhytid_core::{Backend, DeviceErrorKind, DeviceInfo, DeviceKind, Error, Result, Rig, UploadOptions};
use rhytid_kernels::table::{Each, Kernel, WORKGROUP_SIZE, builds};
use rhytid_kernels::tile::TILE;
use std::sync::{Mutex, PoisonError};

/// There is no option that trades accuracy for speed. With relaxed or unsafe arithmetic, a device could
/// reorder sums, drop infinities, and replace squares of small numbers by zero. Then devices would no longer
/// agree.
const BUILD_OPTIONS: &str = "-cl-std=CL1.2";

/// A kernel, and the frames that a work item computes.
type Build = (Kernel, u32);

/// An OpenCL device, with its kernels built. Sessions may outlive it.
#[derive(Debug)]
pub struct OpenCl {
    pub(crate) name: String,
    pub(crate) device: DeviceId,
    pub(crate) context: Context,
    programs: Vec<(Build, Program)>,
    /// On a processor, the vertices of a work item in the kernels that have a choice.
    vertices: Option<u32>,
    pub(crate) limits: PlanLimits,
    pub(crate) memory_bytes: u64,
}

impl Backend for OpenCl {
    const NAME: &'static str = "opencl";
    type Session = OpenClSession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(usable_devices()?.into_iter().map(|(_, info)| info).collect())
    }

    fn open(device: &DeviceInfo) -> Result<Self> {
        Self::open_with(device, |kernel| kernel.entry().opencl.to_owned())
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<OpenClSession> {
        OpenClSession::new(self, rig, options)
    }
}

impl OpenCl {
    /// Opens a device with kernels from this source.
    pub(crate) fn open_with(info: &DeviceInfo, source: impl Fn(Kernel) -> String) -> Result<Self> {
        let name = info.id();
        let error = |kind, message| Error::Device { kind, device: name.clone(), message };
        let devices = usable_devices()?;
        let count = devices.len();
        let found = devices.into_iter().find(|(_, found)| {
            (found.index, &found.name, &found.driver) == (info.index, &info.name, &info.driver)
        });
        let Some((device, _)) = found else {
            let message = format!(
                "there is no such OpenCL device called {} now, found {count} others; list the devices again",
                info.name
            );
            return Err(error(DeviceErrorKind::NotFound, message));
        };
        let asking = || Status::error(&name, "asking for the device's limits");
        let group = device.number(CL_DEVICE_MAX_WORK_GROUP_SIZE).map_err(asking())?;
        if group < WORKGROUP_SIZE.into() {
            let message = format!(
                "a kernel needs workgroups of {WORKGROUP_SIZE}, and this device has {group} at the most"
            );
            return Err(error(DeviceErrorKind::Unsupported, message));
        }
        let limits = PlanLimits {
            max_binding_bytes: device.number(CL_DEVICE_MAX_MEM_ALLOC_SIZE).map_err(asking())?,
            // OpenCL's only limit is that of its 32-bit ids.
            max_workgroups: u32::MAX / WORKGROUP_SIZE,
        };
        let memory_bytes = device.number(CL_DEVICE_GLOBAL_MEM_SIZE).map_err(asking())?;
        let context = Context::new(device).map_err(Status::error(&name, "making a context"))?;
        // A GPU computes vertices side by side in a workgroup, a processor in a work item.
        let vertices = (info.kind == DeviceKind::Cpu).then_some(TILE as u32);
        let build = |(kernel, frames): Build| {
            let entry = kernel.entry();
            let mut options = BUILD_OPTIONS.to_owned();
            if entry.batched {
                options += &format!(" -D FRAMES={frames}");
            }
            if entry.each == Each::Vertex {
                options += &format!(" -D VERTICES={}", vertices.unwrap_or(entry.at_once));
            }
            let program = Program::build(&context, device, &source(kernel), &options);
            let program = program.map_err(|failure| match failure {
                BuildError::Log(log) => {
                    let message =
                        format!("the kernel {} does not build; the compiler says:\n{log}", entry.name);
                    error(DeviceErrorKind::Build, message)
                }
                BuildError::Status(status) => {
                    Status::error(&name, &format!("building the kernel {}", entry.name))(status)
                }
            });
            Ok(((kernel, frames), program?))
        };
        let programs = builds().map(build).collect::<Result<_>>()?;
        Ok(Self { name, device, context, programs, vertices, limits, memory_bytes })
    }

    /// New kernel objects for the caller, without arguments: one for each value of `FRAMES`.
    pub(crate) fn kernels(&self, kernel: Kernel) -> Result<Vec<(u32, cl::Kernel)>> {
        let programs = self.programs.iter().filter(|((of, _), _)| *of == kernel);
        let made = programs.map(|((_, frames), program)| {
            let made = cl::Kernel::new(program, kernel.name())
                .map_err(Status::error(&self.name, "making a kernel"))?;
            Ok((*frames, made))
        });
        made.collect()
    }

    /// Work items of a workgroup.
    pub(crate) fn workgroup_size(&self, kernel: Kernel) -> usize {
        let entry = kernel.entry();
        let vertices = self.vertices.filter(|_| entry.each == Each::Vertex).unwrap_or(entry.at_once);
        (WORKGROUP_SIZE * entry.at_once / vertices) as usize
    }
}

/// Every device that can run the kernels. Platforms are in the order of their names, devices in the driver's
/// order.
fn usable_devices() -> Result<Vec<(DeviceId, DeviceInfo)>> {
    // Some loaders find nothing while another thread is loading the drivers.
    static LOADING: Mutex<()> = Mutex::new(());
    let _loading = LOADING.lock().unwrap_or_else(PoisonError::into_inner);

    let platforms = cl::platforms().map_err(Status::error(OpenCl::NAME, "listing the platforms"))?;
    let name = |platform: Platform| platform.string(CL_PLATFORM_NAME).unwrap_or_else(|_| "OpenCL".into());
    let mut platforms: Vec<(String, Platform)> = platforms.into_iter().map(|p| (name(p), p)).collect();
    platforms.sort_by(|(a, _), (b, _)| a.cmp(b));

    let mut usable = Vec::new();
    let mut failure = None;
    for (platform, id) in platforms {
        // If a driver fails, the devices of other drivers are still listed.
        let devices = id.devices().unwrap_or_else(|status| {
            let doing = format!("listing the devices of {platform}");
            let error = Status::error(OpenCl::NAME, &doing)(status);
            log::warn!("{error}");
            failure = Some(error);
            Vec::new()
        });
        for device in devices {
            match describe(&platform, device, usable.len()) {
                Ok(info) => usable.push((device, info)),
                Err(reason) => {
                    let name = device.string(CL_DEVICE_NAME).unwrap_or_default();
                    log::warn!("opencl: {platform}: {name} is left out: {reason}");
                }
            }
        }
    }
    match failure {
        Some(error) if usable.is_empty() => Err(error),
        _ => Ok(usable),
    }
}

/// The description of a device, or the reason why it cannot run the kernels.
fn describe(platform: &str, device: DeviceId, index: usize) -> Result<DeviceInfo, String> {
    let unknown = |what: &str| format!("it does not tell its {what}");
    for (what, reason) in [
        (CL_DEVICE_AVAILABLE, "it is not available"),
        (CL_DEVICE_COMPILER_AVAILABLE, "it has no compiler"),
        (CL_DEVICE_ENDIAN_LITTLE, "it is big-endian"),
    ] {
        if device.number(what) != Ok(1) {
            return Err(reason.into());
        }
    }
    let profile = device.string(CL_DEVICE_PROFILE).map_err(|_| unknown("profile"))?;
    if profile != "FULL_PROFILE" {
        return Err(format!("its profile is {profile}, and the kernels need FULL_PROFILE"));
    }
    let version = device.string(CL_DEVICE_OPENCL_C_VERSION).map_err(|_| unknown("version of OpenCL C"))?;
    if version.starts_with("OpenCL C 1.0") || version.starts_with("OpenCL C 1.1") {
        return Err(format!("it compiles {version}, and the kernels need 1.2"));
    }

    let has = |kind: cl_device_type| device.number(CL_DEVICE_TYPE).is_ok_and(|bits| bits & kind != 0);
    let kind = if has(CL_DEVICE_TYPE_CPU) {
        DeviceKind::Cpu
    } else if !has(CL_DEVICE_TYPE_GPU) {
        DeviceKind::Other
    } else if device.number(CL_DEVICE_HOST_UNIFIED_MEMORY) == Ok(1) {
        DeviceKind::IntegratedGpu
    } else {
        DeviceKind::DiscreteGpu
    };
    let driver_version = device.string(CL_DRIVER_VERSION).map_err(|_| unknown("driver's version"))?;
    let largest = device.number(CL_DEVICE_MAX_MEM_ALLOC_SIZE).map_err(|_| unknown("largest buffer"))?;
    Ok(DeviceInfo {
        backend: OpenCl::NAME,
        index,
        name: device.string(CL_DEVICE_NAME).map_err(|_| unknown("name"))?,
        driver: format!("{platform}, {driver_version}"),
        kind,
        memory_bytes: device.number(CL_DEVICE_GLOBAL_MEM_SIZE).ok(),
        max_binding_bytes: Some(largest),
    })
}
