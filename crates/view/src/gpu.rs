//! The device of the window.

use rhytid_backend_wgpu::Wgpu;
use rhytid_core::Result;

/// The device that draws. It also evaluates, if it can run the kernels.
#[derive(Debug, Clone)]
pub(crate) struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    kernels: Option<Wgpu>,
}

impl Gpu {
    /// # Errors
    /// As [`Wgpu::from_device`], of a device that has compute shaders.
    pub(crate) fn new(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self> {
        let has_compute_shaders = device.limits().max_compute_workgroups_per_dimension > 0;
        let kernels = || Wgpu::from_device(device.clone(), queue.clone());
        Ok(Self { kernels: has_compute_shaders.then(kernels).transpose()?, device, queue })
    }

    /// The device.
    pub(crate) fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The device's queue.
    pub(crate) fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The kernels on the device. `None` without compute shaders, as in a browser with WebGL 2. Then the
    /// processor evaluates.
    pub(crate) fn kernels(&self) -> Option<&Wgpu> {
        self.kernels.as_ref()
    }

    /// The device's name. Browsers may keep it to themselves.
    pub(crate) fn name(&self) -> String {
        let info = self.device.adapter_info();
        let known = [info.name, info.driver, info.driver_info].into_iter().find(|name| !name.is_empty());
        known.unwrap_or_else(|| "a device that the browser does not name".to_owned())
    }
}
