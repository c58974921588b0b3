//! Vulkan devices, opened here or lent by a host application.
use crate::VulkanSession;
use crate::context::Context;
use crate::error::error;
use crate::instance::Instance;
use crate::physical::physical_devices;
use crate::validation;
use ash::vk;
use rhytid_core::plan::PlanLimits;
use rhytid_core::{Backend, DeviceErrorKind, DeviceInfo, Result, Rig, UploadOptions};
use std::sync::{Arc, Mutex};

/// A Vulkan device, opened. Sessions may outlive it, and may be used on several threads at once.
pub struct Vulkan {
    pub(crate) context: Arc<Context>,
}

/// The objects that a host application lends: see [`Vulkan::from_device`].
pub struct HostDevice {
    /// An instance of Vulkan 1.1 or later.
    pub instance: ash::Instance,
    /// A physical device of `instance`, of Vulkan 1.1 or later.
    pub physical_device: vk::PhysicalDevice,
    /// A device made from `physical_device`. It needs no feature or extension.
    pub device: ash::Device,
    /// A queue of `device`. Code that submits to it, or waits for it to be idle, must hold the lock. This
    /// includes the host application.
    pub queue: Arc<Mutex<vk::Queue>>,
    /// The queue's family, which must support compute.
    pub queue_family: u32,
}

impl Backend for Vulkan {
    const NAME: &'static str = "vulkan";
    type Session = VulkanSession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Self::devices_with(validation::requested())
    }

    fn open(device: &DeviceInfo) -> Result<Self> {
        Self::open_with(device, validation::requested())
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<VulkanSession> {
        self.upload_within(rig, options, self.context.limits)
    }
}

impl Vulkan {
    /// Uses a device that the host application has opened. Objects of the host application are never
    /// destroyed.
    ///
    /// `RHYTID_VULKAN_VALIDATION` has no effect here, since the layers of the instance are already fixed.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`]: `Unsupported` if the device lacks something that the kernels need,
    /// `NotFound` if it does not belong to the instance.
    ///
    /// # Safety
    /// All parts of `host` are valid and belong together as [`HostDevice`] says. They outlive the returned
    /// value and every session made from it. The queue is used only under its lock.
    pub unsafe fn from_device(host: HostDevice) -> Result<Self> {
        let mut found = physical_devices(&host.instance)?.into_iter();
        let Some(mut physical) = found.find(|physical| physical.raw == host.physical_device) else {
            let message = "the host application's device is not among its instance's devices that have \
                           Vulkan 1.1 and a compute queue";
            return Err(error(DeviceErrorKind::NotFound, Self::NAME, message.into()));
        };
        physical.queue_family = host.queue_family;
        // SAFETY: the caller guarantees this.
        let context = unsafe { Context::of_host(host.instance, &physical, host.device, host.queue) }?;
        Ok(Self { context: Arc::new(context) })
    }

    /// The description of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.context.info
    }

    pub(crate) fn devices_with(validation: bool) -> Result<Vec<DeviceInfo>> {
        let Some(instance) = Instance::new(validation)? else { return Ok(Vec::new()) };
        let devices = physical_devices(&instance.raw)?.into_iter().map(|physical| physical.info).collect();
        instance.check()?;
        Ok(devices)
    }

    pub(crate) fn open_with(device: &DeviceInfo, validation: bool) -> Result<Self> {
        let not_found = |found: &str| {
            let message = format!("there is no such Vulkan device now: {found}; list the devices again");
            error(DeviceErrorKind::NotFound, &device.id(), message)
        };
        let Some(instance) = Instance::new(validation)? else { return Err(not_found("no driver was found")) };
        let found = physical_devices(&instance.raw)?;
        let number = found.len();
        let physical = found.into_iter().nth(device.index).filter(|_| device.backend == Self::NAME);
        let physical = physical.ok_or_else(|| not_found(&format!("{number} are present")))?;
        if physical.info.name != device.name {
            return Err(not_found(&format!("it was {} and is {}", device.name, physical.info.name)));
        }
        Ok(Self { context: Arc::new(Context::open(instance, &physical)?) })
    }

    /// Uploads as if the device had lower limits.
    pub(crate) fn upload_within(
        &self,
        rig: &Rig,
        options: UploadOptions,
        limits: PlanLimits,
    ) -> Result<VulkanSession> {
        VulkanSession::new(&self.context, rig, options, limits)
    }
}
