//! A renderer's own Vulkan device: it evaluates there, and draws with the buffers of the results.
//!
//! The functions are there without the feature `vulkan`, too, so that the interface does not depend on how
//! the library was built. They fail then.
use crate::animator::{RhytidAnimator, RhytidAnimatorOptions, animator_of, options_of};
use crate::arguments::{array, array_mut, free, object, out};
use crate::enums;
use crate::rig::{RhytidRig, rig_of};
use crate::status::{RhytidStatus, guarded};
use std::ffi::{c_char, c_void};
use std::ptr::null_mut;

#[cfg(not(feature = "vulkan"))]
#[path = "left_out.rs"]
mod with;
#[cfg(feature = "vulkan")]
#[path = "lent.rs"]
mod with;

/// A function of any type, as vkGetInstanceProcAddr returns it.
pub type RhytidFunction = Option<unsafe extern "C" fn()>;

/// vkGetInstanceProcAddr, with VkInstance as a pointer.
pub type RhytidGetInstanceProcAddr =
    Option<unsafe extern "C" fn(instance: *mut c_void, name: *const c_char) -> RhytidFunction>;

/// The objects of Vulkan that a renderer lends. They are Vulkan 1.1 or later, belong together, and outlive
/// the RhytidVulkan and every animator made with it. Rhytid destroys none of them. No feature or extension of
/// the device is needed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct RhytidVulkanHost {
    /// vkGetInstanceProcAddr, cast to this type.
    pub get_instance_proc_addr: RhytidGetInstanceProcAddr,
    /// The VkInstance.
    pub instance: *mut c_void,
    /// The VkPhysicalDevice, of the instance.
    pub physical_device: *mut c_void,
    /// The VkDevice, made from the physical device.
    pub device: *mut c_void,
    /// A VkQueue of the device.
    pub queue: *mut c_void,
    /// The queue's family, which supports compute.
    pub queue_family: u32,
}

/// A renderer's device. Any number of threads may use it at the same time.
pub struct RhytidVulkan {
    pub(crate) inner: with::Device,
}

/// Where consecutive frames of a stage are on the device.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct RhytidVulkanSlice {
    /// The VkBuffer: floats without padding, from offset 0. It can be a vertex buffer, a storage buffer and
    /// the source of a copy. It belongs to the animator, and to the family of the queue.
    pub buffer: u64,
    /// The first frame in it, counted from the first of the batch.
    pub first_frame: usize,
    /// How many frames are in it.
    pub frames: usize,
}

/// Uses a renderer's own device. *vulkan becomes the device, to be freed by rhytid_vulkan_free(); animators
/// made with it may outlive it.
///
/// Errors: RHYTID_STATUS_DEVICE_UNSUPPORTED if the device lacks something, RHYTID_STATUS_DEVICE_NOT_FOUND if
/// it does not belong to the instance, RHYTID_STATUS_LEFT_OUT.
///
/// # Safety
/// `host` leads to objects of Vulkan as [`RhytidVulkanHost`] says, and `vulkan` to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_vulkan_new(
    host: *const RhytidVulkanHost,
    vulkan: *mut *mut RhytidVulkan,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees both.
        let (vulkan, host) =
            unsafe { (out(vulkan, "vulkan", null_mut())?, object(host, "host", "your renderer")?) };
        // SAFETY: the caller guarantees the objects of the host.
        let inner = unsafe { with::device(host) }?;
        *vulkan = crate::arguments::give(RhytidVulkan { inner });
        Ok(())
    })
}

/// Frees what rhytid_vulkan_new() made, but no object of the renderer. NULL is ignored.
///
/// # Safety
/// `vulkan` is null or not used any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_vulkan_free(vulkan: *mut RhytidVulkan) {
    // SAFETY: the caller guarantees this.
    unsafe { free(vulkan) };
}

/// As rhytid_animator_new(), on a renderer's own device. The device of the options has to be NULL.
///
/// # Safety
/// As for [`rhytid_animator_new`](crate::animator::rhytid_animator_new); `vulkan` leads to a RhytidVulkan.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_vulkan_animator(
    vulkan: *const RhytidVulkan,
    rig: *const RhytidRig,
    options: *const RhytidAnimatorOptions,
    animator: *mut *mut RhytidAnimator,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees all of them.
        let (animator, vulkan, rig, options) = unsafe {
            let animator = out(animator, "animator", null_mut())?;
            let vulkan = object(vulkan, "vulkan", "rhytid_vulkan_new()")?;
            (animator, vulkan, &rig_of(rig)?.rig, options_of(options))
        };
        *animator = with::animator(&vulkan.inner, rig, &options)?;
        Ok(())
    })
}

/// Calls call(user) while no other thread submits work to the renderer's queue: Rhytid holds its lock
/// meanwhile. A renderer does all of its own submissions to that queue in such calls, if more than one thread
/// uses the queue or its animators. call may not call Rhytid, throw an exception, or leave by longjmp.
///
/// # Safety
/// `vulkan` leads to a RhytidVulkan, and `call` to a function that accepts `user`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_vulkan_with_queue(
    vulkan: *const RhytidVulkan,
    call: Option<unsafe extern "C" fn(user: *mut c_void)>,
    user: *mut c_void,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees this.
        let vulkan = unsafe { object(vulkan, "vulkan", "rhytid_vulkan_new()") }?;
        let call =
            call.ok_or_else(|| crate::status::Failure::argument("call is null, expected a function"))?;
        // SAFETY: the caller guarantees the function and its argument.
        with::with_queue(&vulkan.inner, || unsafe { call(user) })
    })
}

/// As rhytid_animator_evaluate(), with semaphores, for an animator of Vulkan. The batch starts after the
/// semaphores of wait. Those of signal are signalled when the results are complete and visible to work that
/// waits for them. If the renderer may still be reading the last results, it signals a semaphore of wait when
/// it is done. Work that is submitted to the same queue after the call sees the results without a semaphore.
///
/// Errors: as rhytid_animator_evaluate(); RHYTID_STATUS_ARGUMENT if the animator is of another backend.
///
/// # Safety
/// As for [`rhytid_animator_evaluate`](crate::animator::rhytid_animator_evaluate). From `wait` and `signal`
/// on there are so many VkSemaphores. They are binary, belong to the animator's device, and live until the
/// batch is done. Each of `wait` is signalled, or the work that signals it was submitted. None of `signal` is
/// signalled.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_vulkan_evaluate(
    animator: *mut RhytidAnimator,
    positions: *const f32,
    count: usize,
    wait: *const u64,
    wait_count: usize,
    signal: *const u64,
    signal_count: usize,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees all of them.
        let (animator, positions, wait, signal) = unsafe {
            let animator = animator_of(animator)?;
            let positions = array(positions, count, "positions")?;
            (animator, positions, array(wait, wait_count, "wait")?, array(signal, signal_count, "signal")?)
        };
        // SAFETY: the caller guarantees the semaphores.
        let evaluated = unsafe { with::evaluate(animator, positions, wait, signal) }?;
        animator.keep_frames(positions, evaluated)
    })
}

/// Where a stage of the last batch, a RhytidStage, is on the device: *count becomes the number of buffers,
/// and the first capacity of them go to slices, in the order of their frames. Most rigs have one. slices may
/// be NULL if capacity is 0. The next batch overwrites the contents, and the buffers stay the same.
///
/// RHYTID_STAGE_LARGE_SCALE_NORMALS may be complete only when it has been read. All other stages are
/// complete.
///
/// Errors: RHYTID_STATUS_ARGUMENT if the animator is not one of Vulkan.
///
/// # Safety
/// `animator` leads to an animator, `count` to a number, and from `slices` on there is room for `capacity`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn rhytid_vulkan_results(
    animator: *mut RhytidAnimator,
    stage: u32,
    slices: *mut RhytidVulkanSlice,
    capacity: usize,
    count: *mut usize,
) -> RhytidStatus {
    guarded(|| {
        // SAFETY: the caller guarantees all of them.
        let (count, animator, slices) = unsafe {
            let count = out(count, "count", 0)?;
            (count, animator_of(animator)?, array_mut(slices, capacity, "slices")?)
        };
        let results = with::results(animator, enums::stage(stage)?)?;
        *count = results.len();
        for (place, result) in slices.iter_mut().zip(results) {
            *place = result;
        }
        Ok(())
    })
}
