//! Memory barriers: what comes after one sees what came before.
use crate::context::Context;
use ash::vk;

/// What touches memory, and where in the pipeline.
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
    /// Records that every `after` sees every `before`. `commands` is being recorded on this device.
    pub(crate) fn barrier(&self, commands: vk::CommandBuffer, before: Access, after: Access) {
        let memory = [vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1)];
        let flags = vk::DependencyFlags::empty();
        // SAFETY: callers are in the middle of recording.
        unsafe {
            self.device.cmd_pipeline_barrier(commands, before.0, after.0, flags, &memory, &[], &[]);
        }
    }
}
