//! Memory barriers: work after a barrier sees the results of work before it.
use crate::context::Context;
use ash::vk;

/// An access to memory, with its stage in the pipeline.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Access(vk::PipelineStageFlags, vk::AccessFlags);

impl Access {
    pub(crate) const COPY_WRITE: Self =
        Self(vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
    pub(crate) const KERNEL_READ: Self =
        Self(vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_READ);
    pub(crate) const KERNEL_WRITE: Self =
        Self(vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE);
    pub(crate) const HOST_READ: Self = Self(vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);
    pub(crate) const ANY_READ: Self =
        Self(vk::PipelineStageFlags::ALL_COMMANDS, vk::AccessFlags::MEMORY_READ);
}

impl Context {
    /// Records a barrier: every access `after` sees the results of every access `before`. `commands` must be
    /// in recording, and belong to this device.
    pub(crate) fn barrier(&self, commands: vk::CommandBuffer, before: Access, after: Access) {
        let memory = [vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1)];
        let flags = vk::DependencyFlags::empty();
        // SAFETY: callers are in the middle of recording.
        unsafe {
            self.device.cmd_pipeline_barrier(commands, before.0, after.0, flags, &memory, &[], &[]);
        }
    }
}
