//! The devices of this machine, and their capabilities.
use crate::error::failed;
use ash::{khr, vk};
use rhytid_core::plan::PlanLimits;
use rhytid_core::{DeviceInfo, DeviceKind, Result};
use std::ffi::{CStr, c_char};

/// A device that can compute.
pub(crate) struct Physical {
    pub(crate) raw: vk::PhysicalDevice,
    pub(crate) info: DeviceInfo,
    /// The queue family to compute on.
    pub(crate) queue_family: u32,
    pub(crate) limits: PlanLimits,
    /// The number of storage buffers that a shader can have.
    pub(crate) max_storage_buffers: u32,
    /// Nanoseconds in a tick of the timestamps.
    pub(crate) timestamp_period: f32,
    /// Whether the device has `VK_KHR_portability_subset`, which must then be enabled.
    pub(crate) portability_subset: bool,
}

/// Every device of Vulkan 1.1 or later with a queue that computes.
pub(crate) fn physical_devices(instance: &ash::Instance) -> Result<Vec<Physical>> {
    // SAFETY: the instance is alive, here and below.
    let found = match unsafe { instance.enumerate_physical_devices() } {
        Ok(found) => found,
        // Some loaders return this error where drivers are installed but none has a device.
        Err(vk::Result::ERROR_INITIALIZATION_FAILED) => Vec::new(),
        Err(result) => return Err(failed("vulkan", "listing the devices")(result)),
    };
    let mut devices = Vec::new();
    for raw in found {
        if let Some(device) = examine(instance, raw, devices.len())? {
            devices.push(device);
        }
    }
    Ok(devices)
}

fn examine(instance: &ash::Instance, raw: vk::PhysicalDevice, index: usize) -> Result<Option<Physical>> {
    // SAFETY: `raw` is one of the instance's devices, here and below.
    let version = unsafe { instance.get_physical_device_properties(raw) }.api_version;
    if version < vk::API_VERSION_1_1 {
        log::warn!("a device of Vulkan 1.0 is left out: 1.1 is needed");
        return Ok(None);
    }
    let Some(queue_family) = compute_queue_family(instance, raw) else { return Ok(None) };
    // SAFETY: as above.
    let extensions = unsafe { instance.enumerate_device_extension_properties(raw) };
    let extensions = extensions.map_err(failed("vulkan", "listing a device's extensions"))?;
    let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));

    let mut maintenance = vk::PhysicalDeviceMaintenance3Properties::default();
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut maintenance);
    let names_driver = version >= vk::API_VERSION_1_2 || has(khr::driver_properties::NAME);
    if names_driver {
        properties = properties.push_next(&mut driver);
    }
    // SAFETY: as above; the structures behind `properties` are known to a device of this version.
    unsafe { instance.get_physical_device_properties2(raw, &mut properties) };
    let device = properties.properties;
    let limits = device.limits;
    let [x, y, _] = limits.max_compute_work_group_count;
    let max_binding_bytes =
        u64::from(limits.max_storage_buffer_range).min(maintenance.max_memory_allocation_size);
    let driver = if names_driver {
        format!("{} {}", text(&driver.driver_name), text(&driver.driver_info))
    } else {
        version_text(device.driver_version)
    };
    let info = DeviceInfo {
        backend: "vulkan",
        index,
        name: text(&device.device_name),
        driver: driver.trim().to_owned(),
        kind: match device.device_type {
            vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
            vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::IntegratedGpu,
            vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::DiscreteGpu,
            vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::VirtualGpu,
            _ => DeviceKind::Other,
        },
        memory_bytes: device_local_bytes(instance, raw),
        max_binding_bytes: Some(max_binding_bytes),
    };
    Ok(Some(Physical {
        raw,
        info,
        queue_family,
        limits: PlanLimits { max_binding_bytes, max_workgroups: x.min(y) },
        max_storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
        timestamp_period: limits.timestamp_period,
        portability_subset: has(khr::portability_subset::NAME),
    }))
}

/// The first family that supports compute and measures time. If none measures time, the first that supports
/// compute.
fn compute_queue_family(instance: &ash::Instance, raw: vk::PhysicalDevice) -> Option<u32> {
    // SAFETY: `raw` is one of the instance's devices.
    let families = unsafe { instance.get_physical_device_queue_family_properties(raw) };
    let computes = |family: &vk::QueueFamilyProperties| {
        family.queue_count > 0 && family.queue_flags.contains(vk::QueueFlags::COMPUTE)
    };
    let measured = families.iter().position(|family| computes(family) && family.timestamp_valid_bits > 0);
    measured.or_else(|| families.iter().position(computes)).map(|family| family as u32)
}

/// The device's own memory: its largest heap. Others are windows into it, or of little use.
fn device_local_bytes(instance: &ash::Instance, raw: vk::PhysicalDevice) -> Option<u64> {
    // SAFETY: `raw` is one of the instance's devices.
    let memory = unsafe { instance.get_physical_device_memory_properties(raw) };
    let heaps = memory.memory_heaps_as_slice().iter();
    heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL)).map(|heap| heap.size).max()
}

/// The text in a driver's array of characters, up to the first null.
fn text(characters: &[c_char]) -> String {
    let bytes: Vec<u8> = characters.iter().map(|&c| c as u8).take_while(|&c| c != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

fn version_text(version: u32) -> String {
    let [major, minor, patch] =
        [vk::api_version_major(version), vk::api_version_minor(version), vk::api_version_patch(version)];
    format!("{major}.{minor}.{patch}")
}
