//! An opened device, which all its sessions share.
use crate::error::{error, failed, too_large};
use crate::instance::Instance;
use crate::physical::Physical;
use crate::pipeline::Pipeline;
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};
use rhytid_core::plan::PlanLimits;
use rhytid_core::{DeviceErrorKind, DeviceInfo, Result};
use rhytid_kernels::table::{Kernel, builds};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Small sessions share a piece of memory of this size. If more is needed, larger pieces follow.
const FIRST_PIECE: u64 = 16 << 20;
/// The largest piece that buffers share. A larger buffer has memory of its own.
const LARGEST_PIECE: u64 = 256 << 20;

pub(crate) struct Context {
    pub(crate) info: DeviceInfo,
    pub(crate) id: String,
    pub(crate) device: ash::Device,
    pub(crate) queue_family: u32,
    pub(crate) limits: PlanLimits,
    /// `None` where the queue cannot measure time.
    pub(crate) clock: Option<Clock>,
    queue: Arc<Mutex<vk::Queue>>,
    pipelines: Vec<Pipeline>,
    cache: vk::PipelineCache,
    /// `None` only before it is made, and while everything is being destroyed.
    allocator: Mutex<Option<Allocator>>,
    /// `None` where instance and device belong to the host application. Otherwise both are destroyed with
    /// this context.
    instance: Option<Instance>,
    abandoned: AtomicBool,
}

/// The clock behind a queue's timestamps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    /// Nanoseconds in a tick.
    pub(crate) period: f32,
    /// The valid bits of a timestamp.
    pub(crate) mask: u64,
}

impl Clock {
    /// The time from one timestamp to a later one. The counter may have wrapped around between them.
    pub(crate) fn between(self, start: u64, end: u64) -> Duration {
        let ticks = end.wrapping_sub(start) & self.mask;
        Duration::from_nanos((ticks as f64 * f64::from(self.period)) as u64)
    }
}

impl Context {
    /// Opens one of `instance`'s devices.
    pub(crate) fn open(instance: Instance, physical: &Physical) -> Result<Self> {
        let id = physical.info.id();
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(physical.queue_family)
            .queue_priorities(&[1.0])];
        let mut extensions = Vec::new();
        if physical.portability_subset {
            extensions.push(ash::khr::portability_subset::NAME.as_ptr());
        }
        // Every device has this feature. If an index is wrong in spite of all checks, the kernel reads zeros,
        // and not another program's memory.
        let features = vk::PhysicalDeviceFeatures::default().robust_buffer_access(true);
        let create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features);
        // SAFETY: the device is one of the instance's, it has this queue family and these extensions.
        let device = unsafe { instance.raw.create_device(physical.raw, &create, None) };
        let device = device.map_err(failed(&id, "opening the device"))?;
        // SAFETY: the device was made with one queue of this family.
        let queue = unsafe { device.get_device_queue(physical.queue_family, 0) };
        let raw_instance = instance.raw.clone();
        let queue = Arc::new(Mutex::new(queue));
        Self::build(raw_instance, physical, device, queue, Some(instance))
    }

    /// Uses a device that the host application has opened.
    ///
    /// # Safety
    /// As [`crate::Vulkan::from_device`].
    pub(crate) unsafe fn of_host(
        instance: ash::Instance,
        physical: &Physical,
        device: ash::Device,
        queue: Arc<Mutex<vk::Queue>>,
    ) -> Result<Self> {
        Self::build(instance, physical, device, queue, None)
    }

    fn build(
        raw_instance: ash::Instance,
        physical: &Physical,
        device: ash::Device,
        queue: Arc<Mutex<vk::Queue>>,
        instance: Option<Instance>,
    ) -> Result<Self> {
        // If a call fails from here on, `drop` destroys the objects that exist.
        let mut context = Self {
            info: physical.info.clone(),
            id: physical.info.id(),
            device,
            queue_family: physical.queue_family,
            limits: physical.limits,
            clock: clock(&raw_instance, physical),
            queue,
            pipelines: Vec::new(),
            cache: vk::PipelineCache::null(),
            allocator: Mutex::new(None),
            instance,
            abandoned: AtomicBool::new(false),
        };
        let most_bindings = Kernel::ALL.iter().map(|kernel| kernel.entry().bindings.len()).max().unwrap_or(0);
        if (physical.max_storage_buffers as usize) < most_bindings {
            let found = physical.max_storage_buffers;
            let message = format!("a kernel needs {most_bindings} storage buffers, this device has {found}");
            return Err(error(DeviceErrorKind::Unsupported, &context.id, message));
        }
        context.make_allocator(raw_instance, physical.raw)?;
        let create = vk::PipelineCacheCreateInfo::default();
        // SAFETY: the device is alive.
        let cache = unsafe { context.device.create_pipeline_cache(&create, None) };
        context.cache = cache.map_err(failed(&context.id, "making a pipeline cache"))?;
        context.pipelines =
            builds().map(|(kernel, frames_at_once)| Pipeline::new(kernel, frames_at_once)).collect();
        for pipeline in &mut context.pipelines {
            pipeline.build(&context.device, &context.id, context.cache)?;
        }
        context.check()?;
        Ok(context)
    }

    fn make_allocator(&mut self, instance: ash::Instance, physical_device: vk::PhysicalDevice) -> Result<()> {
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance,
            device: self.device.clone(),
            physical_device,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: AllocationSizes::new(FIRST_PIECE, FIRST_PIECE)
                .with_max_device_memblock_size(LARGEST_PIECE)
                .with_max_host_memblock_size(LARGEST_PIECE),
        });
        let allocator = allocator.map_err(|cause| {
            let message = format!("making an allocator failed: {cause}");
            error(DeviceErrorKind::Driver, &self.id, message)
        })?;
        self.allocator = Mutex::new(Some(allocator));
        Ok(())
    }

    /// The queue. The holder of its lock may submit.
    pub(crate) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls `use_it` with the allocator.
    pub(crate) fn with_allocator<T>(&self, use_it: impl FnOnce(&mut Allocator) -> T) -> T {
        let mut allocator = self.allocator.lock().unwrap_or_else(PoisonError::into_inner);
        use_it(allocator.as_mut().expect("the allocator lives as long as the context"))
    }

    /// Fails if the device's memory has fewer than this many free bytes. Some drivers would still grant the
    /// memory, and then fail when it is used.
    pub(crate) fn require_memory(&self, bytes: u64) -> Result<()> {
        let Some(memory) = self.info.memory_bytes else { return Ok(()) };
        let used = self.with_allocator(|allocator| allocator.generate_report().total_allocated_bytes);
        if used.saturating_add(bytes) <= memory {
            return Ok(());
        }
        let what = format!("{bytes} bytes are needed, it has {memory}, and {used} of them are in use");
        Err(too_large(&self.id, &what))
    }

    pub(crate) fn pipeline(&self, kernel: Kernel, frames_at_once: u32) -> &Pipeline {
        let is =
            |pipeline: &&Pipeline| (pipeline.kernel, pipeline.frames_at_once) == (kernel, frames_at_once);
        let found = self.pipelines.iter().find(is);
        found.expect("every kernel has a pipeline")
    }

    /// Fails if the validation layer has ever reported a message on this device or its sessions.
    pub(crate) fn check(&self) -> Result<()> {
        match self.instance.as_ref().and_then(|instance| instance.messages.as_ref()) {
            Some(messages) => messages.check(&self.id),
            None => Ok(()),
        }
    }

    /// The messages of the validation layer, which outlive the device.
    #[cfg(test)]
    pub(crate) fn messages(&self) -> Option<Arc<crate::validation::Messages>> {
        self.instance.as_ref().and_then(|instance| instance.messages.clone())
    }
}

impl Context {
    /// Called after a failed wait for work that may still be running. From now on, nothing of the device is
    /// destroyed or freed until the process ends, since it may be in use.
    pub(crate) fn abandon(&self) {
        self.abandoned.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Relaxed)
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        if self.is_abandoned() {
            std::mem::forget(self.allocator.get_mut().unwrap_or_else(PoisonError::into_inner).take());
            std::mem::forget(self.instance.take());
            return;
        }
        // SAFETY: sessions keep their context alive, and wait for the device before they are dropped. So
        // nothing is in use any more. The device is destroyed only if it is ours, and before its instance.
        unsafe {
            for pipeline in &self.pipelines {
                pipeline.destroy(&self.device);
            }
            self.device.destroy_pipeline_cache(self.cache, None);
            drop(self.allocator.get_mut().unwrap_or_else(PoisonError::into_inner).take());
            if self.instance.is_some() {
                self.device.destroy_device(None);
            }
        }
    }
}

fn clock(instance: &ash::Instance, physical: &Physical) -> Option<Clock> {
    // SAFETY: the device is one of the instance's.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical.raw) };
    let bits = families.get(physical.queue_family as usize)?.timestamp_valid_bits;
    (bits > 0).then(|| Clock { period: physical.timestamp_period, mask: u64::MAX >> (64 - bits.min(64)) })
}
