//! The device of the window.

use rhytid_backend_wgpu::Wgpu;
use rhytid_core::Result;

/// The device that draws. It also evaluates, if it can run the kernels.
#[derive(Debug, Clone)]
pub(crate) struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    kernels: Option<Wgpu>,
    /// The name that the browser's page has for it.
    #[cfg(target_arch = "wasm32")]
    in_page: Option<String>,
}

impl Gpu {
    /// # Errors
    /// As [`Wgpu::from_device`], of a device that has compute shaders.
    pub(crate) fn new(device: wgpu::Device, queue: wgpu::Queue) -> Result<Self> {
        let has_compute_shaders = device.limits().max_compute_workgroups_per_dimension > 0;
        let kernels = || Wgpu::from_device(device.clone(), queue.clone());
        Ok(Self {
            kernels: has_compute_shaders.then(kernels).transpose()?,
            device,
            queue,
            #[cfg(target_arch = "wasm32")]
            in_page: None,
        })
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

    /// The device's name.
    pub(crate) fn name(&self) -> String {
        let info = self.device.adapter_info();
        let mut names = [info.name, info.driver, info.driver_info].into_iter();
        let known = names.find(|name| !name.is_empty());
        #[cfg(target_arch = "wasm32")]
        let known = known.or_else(|| self.in_page.clone());
        known.unwrap_or_else(|| "a device without a name".to_owned())
    }

    /// Names the device, if its driver does not.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn set_name(&mut self, name: String) {
        self.in_page = Some(name).filter(|name| !name.is_empty());
    }
}
