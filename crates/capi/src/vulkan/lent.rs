//! A device that a renderer lends.
use super::{RhytidVulkanHost, RhytidVulkanSlice};
use crate::animator::{RhytidAnimator, RhytidAnimatorOptions};
use crate::arguments::give;
use crate::held::Held;
use crate::status::{Failure, Result};
use rhytid::devices::vulkan::ash::{self, vk, vk::Handle};
use rhytid::devices::vulkan::{HostDevice, Vulkan, VulkanSession};
use rhytid::{Animator, Rig, Stage};
use std::ffi::c_void;
use std::sync::{Arc, Mutex, PoisonError};

pub(crate) struct Device {
    vulkan: Vulkan,
    queue: Arc<Mutex<vk::Queue>>,
}

/// # Safety
/// The objects are as [`RhytidVulkanHost`] says.
pub(super) unsafe fn device(host: &RhytidVulkanHost) -> Result<Device> {
    let missing =
        |name: &str| Failure::argument(format!("{name} of the host is null, expected your renderer's"));
    let load = host.get_instance_proc_addr.ok_or_else(|| missing("get_instance_proc_addr"))?;
    let objects = [
        ("instance", host.instance),
        ("physical_device", host.physical_device),
        ("device", host.device),
        ("queue", host.queue),
    ];
    if let Some((name, _)) = objects.into_iter().find(|(_, object)| object.is_null()) {
        return Err(missing(name));
    }
    let raw = |object: *mut c_void| object.expose_provenance() as u64;
    // SAFETY: it is the same function, whose VkInstance is a pointer.
    let get_instance_proc_addr =
        unsafe { std::mem::transmute::<Loader, vk::PFN_vkGetInstanceProcAddr>(load) };
    let functions = ash::StaticFn { get_instance_proc_addr };
    let queue = Arc::new(Mutex::new(vk::Queue::from_raw(raw(host.queue))));
    // SAFETY: the caller guarantees the instance and the device.
    let (instance, device) = unsafe {
        let instance = ash::Instance::load(&functions, vk::Instance::from_raw(raw(host.instance)));
        let device = ash::Device::load(instance.fp_v1_0(), vk::Device::from_raw(raw(host.device)));
        (instance, device)
    };
    let host = HostDevice {
        instance,
        physical_device: vk::PhysicalDevice::from_raw(raw(host.physical_device)),
        device,
        queue: queue.clone(),
        queue_family: host.queue_family,
    };
    // SAFETY: the caller guarantees the objects, and uses the queue by `with_queue`.
    Ok(Device { vulkan: unsafe { Vulkan::from_device(host) }?, queue })
}

type Loader = unsafe extern "C" fn(*mut c_void, *const std::ffi::c_char) -> super::RhytidFunction;

pub(super) fn animator(
    device: &Device,
    rig: &Rig,
    options: &RhytidAnimatorOptions,
) -> Result<*mut RhytidAnimator> {
    if !options.device.is_null() {
        return Err(Failure::argument(
            "the device of the options is a name, expected NULL: the animator is on your renderer's device",
        ));
    }
    let animator = Animator::new(&device.vulkan, rig, options.upload()?)?;
    Ok(give(RhytidAnimator::new(Held::Vulkan(animator), &device.vulkan.info().id(), rig)))
}

pub(super) fn with_queue(device: &Device, call: impl FnOnce()) -> Result {
    let _queue = device.queue.lock().unwrap_or_else(PoisonError::into_inner);
    call();
    Ok(())
}

fn session(animator: &mut RhytidAnimator) -> Result<&mut Animator<VulkanSession>> {
    let device = animator.device_name();
    match &mut animator.held {
        Held::Vulkan(animator) => Ok(animator),
        _ => {
            Err(Failure::argument(format!("the animator is on {device}, expected one on a device of Vulkan")))
        }
    }
}

/// # Safety
/// The semaphores are as [`VulkanSession::evaluate_with`] says.
pub(super) unsafe fn evaluate(
    animator: &mut RhytidAnimator,
    positions: &[f32],
    wait: &[u64],
    signal: &[u64],
) -> Result<rhytid::Result<()>> {
    let of = |raw: &[u64]| raw.iter().map(|&raw| vk::Semaphore::from_raw(raw)).collect::<Vec<_>>();
    let (wait, signal) = (of(wait), of(signal));
    let animator = session(animator)?;
    // SAFETY: the caller guarantees the semaphores.
    Ok(animator
        .evaluate_by(positions, |session, frames| unsafe { session.evaluate_with(frames, &wait, &signal) }))
}

pub(super) fn results(animator: &mut RhytidAnimator, stage: Stage) -> Result<Vec<RhytidVulkanSlice>> {
    let results = session(animator)?.session().result(stage).into_iter();
    Ok(results
        .map(|slice| RhytidVulkanSlice {
            buffer: slice.buffer.as_raw(),
            first_frame: slice.first_frame,
            frames: slice.frames,
        })
        .collect())
}
