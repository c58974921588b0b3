//! A buffer and its memory.
use crate::context::Context;
use crate::error::{failed, not_allocated};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use rhytid_core::Result;
use std::sync::Arc;

pub(crate) struct Buffer {
    pub(crate) raw: vk::Buffer,
    pub(crate) bytes: usize,
    allocation: Allocation,
    context: Arc<Context>,
}

impl Buffer {
    /// `name` is for errors. `bytes` is above 0.
    pub(crate) fn new(
        context: &Arc<Context>,
        name: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self> {
        let device = &context.device;
        let create =
            vk::BufferCreateInfo::default().size(bytes).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the device is alive, here and below.
        let raw = unsafe { device.create_buffer(&create, None) };
        let raw = raw.map_err(failed(&context.id, &format!("making the buffer {name}")))?;
        let mut buffer =
            Self { raw, bytes: bytes as usize, allocation: Allocation::default(), context: context.clone() };
        // SAFETY: the buffer is the device's.
        let requirements = unsafe { device.get_buffer_memory_requirements(raw) };
        let allocation = context.with_allocator(|allocator| {
            allocator.allocate(&AllocationCreateDesc {
                name,
                requirements,
                location,
                linear: true,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
        });
        buffer.allocation = allocation.map_err(not_allocated(&context.id, name, requirements.size))?;
        let (memory, offset) = (
            // SAFETY: the memory is not freed while the buffer is there.
            unsafe { buffer.allocation.memory() },
            buffer.allocation.offset(),
        );
        // SAFETY: the memory was allocated for this buffer's requirements.
        let bound = unsafe { device.bind_buffer_memory(raw, memory, offset) };
        bound.map_err(failed(&context.id, &format!("giving memory to the buffer {name}")))?;
        Ok(buffer)
    }

    /// The bytes of a buffer in memory that is visible to the host. The device must not be using them.
    pub(crate) fn mapped(&mut self) -> &mut [u8] {
        let bytes = self.bytes;
        let mapped = self.allocation.mapped_slice_mut();
        &mut mapped.expect("memory that is not the GPU's alone is mapped")[..bytes]
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if self.context.is_abandoned() {
            return;
        }
        // SAFETY: code that drops a buffer has waited until the device is done with it.
        unsafe { self.context.device.destroy_buffer(self.raw, None) };
        let allocation = std::mem::take(&mut self.allocation);
        let freed = self.context.with_allocator(|allocator| allocator.free(allocation));
        if let Err(cause) = freed {
            log::error!("{}: memory could not be freed: {cause}", self.context.id);
        }
    }
}
