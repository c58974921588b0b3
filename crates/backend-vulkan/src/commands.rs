//! One command buffer: it is recorded, runs once, and is recorded again.
use crate::context::Context;
use crate::error::failed;
use ash::vk;
use rhytid_core::Result;
use std::sync::Arc;

pub(crate) struct Commands {
    context: Arc<Context>,
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    done: vk::Fence,
    running: bool,
}

impl Commands {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self> {
        // If a call fails from here on, `drop` destroys the objects that exist. Null handles are ignored.
        let mut commands = Self {
            context: context.clone(),
            pool: vk::CommandPool::null(),
            buffer: vk::CommandBuffer::null(),
            done: vk::Fence::null(),
            running: false,
        };
        let failed = || failed(&context.id, "making a command buffer");
        let create = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(context.queue_family);
        // SAFETY: the device is alive, here and in the whole file; it has this queue family.
        commands.pool = unsafe { context.device.create_command_pool(&create, None) }.map_err(failed())?;
        let allocate = vk::CommandBufferAllocateInfo::default()
            .command_pool(commands.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: no other code uses the pool.
        let buffers = unsafe { context.device.allocate_command_buffers(&allocate) }.map_err(failed())?;
        commands.buffer = buffers[0];
        let create = vk::FenceCreateInfo::default();
        // SAFETY: as above.
        commands.done = unsafe { context.device.create_fence(&create, None) }.map_err(failed())?;
        Ok(commands)
    }

    /// Waits until the last submission is done, then begins to record.
    pub(crate) fn begin(&mut self) -> Result<vk::CommandBuffer> {
        self.wait()?;
        let device = &self.context.device;
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool is ours alone, and its command buffer does not run.
        unsafe {
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .and_then(|()| device.begin_command_buffer(self.buffer, &begin))
        }
        .map_err(failed(&self.context.id, "beginning a command buffer"))?;
        Ok(self.buffer)
    }

    /// Submits everything that was recorded since [`Commands::begin`]. It starts after `wait` is signalled,
    /// and signals `signal` at its end.
    ///
    /// # Safety
    /// The recorded commands are sound, and stay so until they are done. The semaphores belong to the device.
    /// Those of `wait` are signalled or will be. Those of `signal` are not signalled.
    pub(crate) unsafe fn submit(&mut self, wait: &[vk::Semaphore], signal: &[vk::Semaphore]) -> Result<()> {
        let (device, id) = (&self.context.device, &self.context.id);
        let stages = vec![vk::PipelineStageFlags::ALL_COMMANDS; wait.len()];
        let buffers = [self.buffer];
        let submit = vk::SubmitInfo::default()
            .command_buffers(&buffers)
            .wait_semaphores(wait)
            .wait_dst_stage_mask(&stages)
            .signal_semaphores(signal);
        // SAFETY: the command buffer is being recorded, the fence is not in use, and the queue is locked.
        unsafe {
            device
                .end_command_buffer(self.buffer)
                .and_then(|()| device.reset_fences(&[self.done]))
                .and_then(|()| device.queue_submit(*self.context.queue(), &[submit], self.done))
        }
        .map_err(failed(id, "submitting work to the device"))?;
        self.running = true;
        Ok(())
    }

    /// Waits until the last submission is done.
    pub(crate) fn wait(&mut self) -> Result<()> {
        if !self.running {
            return Ok(());
        }
        // SAFETY: the fence was submitted.
        let waited = unsafe { self.context.device.wait_for_fences(&[self.done], true, u64::MAX) };
        // A lost device is also done.
        self.running = waited.is_err_and(|result| result != vk::Result::ERROR_DEVICE_LOST);
        if self.running {
            self.context.abandon();
        }
        waited.map_err(failed(&self.context.id, "waiting for the device"))
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        if let Err(cause) = self.wait() {
            log::warn!("{cause}");
        }
        if self.context.is_abandoned() {
            return;
        }
        // SAFETY: no command of it runs any more.
        unsafe {
            self.context.device.destroy_fence(self.done, None);
            self.context.device.destroy_command_pool(self.pool, None);
        }
    }
}
