//! Devices of wgpu, opened here or lent by a host application.
use crate::WgpuSession;
use crate::faults::{Faults, error};
use crate::gpu::Gpu;
#[cfg(not(target_arch = "wasm32"))]
use crate::limits::{has_compute_shaders, lacking};
use crate::limits::{limits, max_binding_bytes};
use rhytid_core::plan::PlanLimits;
use rhytid_core::{Backend, DeviceErrorKind, DeviceInfo, DeviceKind, Result, Rig, UploadOptions};
use std::sync::Arc;

/// A device of wgpu. Clones share it.
#[derive(Debug, Clone)]
pub struct Wgpu {
    pub(crate) gpu: Arc<Gpu>,
    limits: PlanLimits,
}

impl Wgpu {
    /// Opens the device that wgpu prefers. Use this in browsers, which do not allow waiting.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`]: there is none, it cannot run the kernels, or its driver fails.
    pub async fn request() -> Result<Self> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = instance().request_adapter(&options).await;
        let adapter = adapter.map_err(|reason| {
            let message =
                format!("{reason}; install a driver for Vulkan, Metal, Direct3D 12 or OpenGL ES 3.1");
            error(DeviceErrorKind::NotFound, Self::NAME, message)
        })?;
        let id = format!("{} ({})", Self::NAME, adapter.get_info().name);
        let (device, queue, faults) = request(&adapter, &id).await?;
        Ok(Self::new(Gpu::new(id, device, queue, faults)?))
    }

    /// Computes on the device of a host application, which can then draw with the results. Its limits must be
    /// WebGPU's defaults or better. With the feature `TIMESTAMP_QUERY`, stages are timed. The host keeps its
    /// handlers for uncaptured errors and for the loss of the device. Errors of this backend's own calls do
    /// not reach them.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`]: `Unsupported`, naming the limit that is too low, or `Build`.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self> {
        let id = format!("{} ({})", Self::NAME, device.adapter_info().name);
        Ok(Self::new(Gpu::new(id, device, queue, Arc::default())?))
    }

    fn new(gpu: Gpu) -> Self {
        Self { limits: gpu.limits, gpu: Arc::new(gpu) }
    }

    /// The same device, with arrays and batches split into bindings of at most `bytes`. This has an effect
    /// only if the device allows more. A rig then has more and smaller pieces of memory. The results have the
    /// same bits.
    #[must_use]
    pub fn with_bindings_of_at_most(mut self, bytes: u64) -> Self {
        self.limits.max_binding_bytes = self.limits.max_binding_bytes.min(bytes);
        self
    }

    /// The description of the device. The index of a device that was requested or lent is 0, since it has no
    /// place in the list of [`Backend::devices`].
    pub fn info(&self) -> DeviceInfo {
        info(0, &self.gpu.device.adapter_info(), self.limits.max_binding_bytes)
    }

    /// The request for a device that [`Wgpu::from_device`] accepts. It has WebGPU's default limits and, where
    /// the adapter has them, timestamps.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor {
            label: Some("rhytid"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits(adapter),
            ..Default::default()
        }
    }

    /// Whether an adapter of any instance is the device that was listed.
    pub fn is(adapter: &wgpu::Adapter, device: &DeviceInfo) -> bool {
        info_of_adapter(device.index, adapter) == *device
    }

    /// The rank of an adapter. Sorted by rank, adapters are in the order of [`Backend::devices`]: GPUs before
    /// software.
    pub fn rank(adapter: &wgpu::Adapter) -> u8 {
        let info = adapter.get_info();
        let of_kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        };
        of_kind + if info.backend == wgpu::Backend::Gl { OPENGL as u8 } else { 0 }
    }

    /// The device, for a renderer that draws with the results.
    pub fn device(&self) -> &wgpu::Device {
        &self.gpu.device
    }

    /// The queue to which batches are submitted. Work that a renderer submits to it after a batch runs after
    /// the batch.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.gpu.queue
    }

    /// Opens a device and its queue without the kernels, which takes less time. This is for a program that
    /// only draws.
    ///
    /// # Errors
    /// As [`Backend::open`].
    pub fn open_to_draw(device: &DeviceInfo) -> Result<(wgpu::Device, wgpu::Queue)> {
        let (device, queue, _) = blocking(request(&adapter_of(device)?, &device.id()))?;
        Ok((device, queue))
    }
}

/// Opens an adapter, with the receiver of the device's faults.
async fn request(adapter: &wgpu::Adapter, id: &str) -> Result<(wgpu::Device, wgpu::Queue, Arc<Faults>)> {
    let (device, queue) = adapter
        .request_device(&Wgpu::device_descriptor(adapter))
        .await
        .map_err(|reason| error(DeviceErrorKind::Driver, id, format!("the device did not open: {reason}")))?;
    let faults = Faults::new(&device);
    Ok((device, queue, faults))
}

/// The adapter of a device.
fn adapter_of(device: &DeviceInfo) -> Result<wgpu::Adapter> {
    let found = adapters().into_iter().map(|(index, adapter)| (info_of_adapter(index, &adapter), adapter));
    let mut found = found.filter(|(info, _)| info == device);
    found.next().map(|(_, adapter)| adapter).ok_or_else(|| {
        let message = format!("there is no {} ({}) any more", device.name, device.driver);
        error(DeviceErrorKind::NotFound, &device.id(), message)
    })
}

impl Backend for Wgpu {
    const NAME: &'static str = "wgpu";
    type Session = WgpuSession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(adapters().iter().map(|(index, adapter)| info_of_adapter(*index, adapter)).collect())
    }

    fn open(device: &DeviceInfo) -> Result<Self> {
        let (opened, queue, faults) = blocking(request(&adapter_of(device)?, &device.id()))?;
        Ok(Self::new(Gpu::new(device.id(), opened, queue, faults)?))
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<WgpuSession> {
        WgpuSession::new(self.gpu.clone(), rig, options, self.limits)
    }
}

/// Each device has an instance of its own. On GL, devices of one instance share a context, which only one
/// thread at a time can use.
fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        // By default, debug builds turn on Vulkan's validation layer. That is for developers of wgpu, so it
        // is off here.
        flags: wgpu::InstanceFlags::empty().with_env(),
        ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
    })
}

/// Devices of OpenGL count from here. So they never get the index of another API's device whose driver is
/// broken.
const OPENGL: usize = 8;

/// The adapters that can run the kernels, with their index in the list of all: GPUs before software.
#[cfg(not(target_arch = "wasm32"))]
fn adapters() -> Vec<(usize, wgpu::Adapter)> {
    let mut adapters = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::all()));
    adapters.retain(|adapter| has_compute_shaders(adapter) && lacking(&limits(adapter)).is_none());
    adapters.sort_by_key(Wgpu::rank);
    let (gl, newer): (Vec<_>, Vec<_>) =
        adapters.into_iter().partition(|adapter| adapter.get_info().backend == wgpu::Backend::Gl);
    newer.into_iter().enumerate().chain((OPENGL..).zip(gl)).collect()
}

/// A browser answers later: see [`Wgpu::request`].
#[cfg(target_arch = "wasm32")]
fn adapters() -> Vec<(usize, wgpu::Adapter)> {
    Vec::new()
}

fn info_of_adapter(index: usize, adapter: &wgpu::Adapter) -> DeviceInfo {
    info(index, &adapter.get_info(), max_binding_bytes(&limits(adapter)))
}

fn info(index: usize, info: &wgpu::AdapterInfo, max_binding_bytes: u64) -> DeviceInfo {
    let api = match info.backend {
        wgpu::Backend::Vulkan => "Vulkan",
        wgpu::Backend::Metal => "Metal",
        wgpu::Backend::Dx12 => "Direct3D 12",
        wgpu::Backend::Gl => "OpenGL",
        wgpu::Backend::BrowserWebGpu => "WebGPU",
        wgpu::Backend::Noop => "none",
    };
    let driver: Vec<&str> =
        [api, &info.driver, &info.driver_info].into_iter().filter(|part| !part.is_empty()).collect();
    DeviceInfo {
        backend: Wgpu::NAME,
        index,
        name: info.name.clone(),
        driver: driver.join(", "),
        kind: match info.device_type {
            wgpu::DeviceType::DiscreteGpu => DeviceKind::DiscreteGpu,
            wgpu::DeviceType::IntegratedGpu => DeviceKind::IntegratedGpu,
            wgpu::DeviceType::VirtualGpu => DeviceKind::VirtualGpu,
            wgpu::DeviceType::Cpu => DeviceKind::Cpu,
            wgpu::DeviceType::Other => DeviceKind::Other,
        },
        memory_bytes: None,
        max_binding_bytes: Some(max_binding_bytes),
    }
}

/// Waits for `future`. Browsers do not allow this.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn blocking<T>(future: impl Future<Output = Result<T>>) -> Result<T> {
    pollster::block_on(future)
}

/// Waits for `future`. Browsers do not allow this.
#[cfg(target_arch = "wasm32")]
pub(crate) fn blocking<T>(_: impl Future<Output = Result<T>>) -> Result<T> {
    let message =
        "a browser does not let a program wait: use Wgpu::request, read_async and stage_times_async";
    Err(error(DeviceErrorKind::Unsupported, Wgpu::NAME, message))
}
