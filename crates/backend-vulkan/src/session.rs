//! A rig on a Vulkan device.
use crate::barrier::Access;
use crate::buffer::Buffer;
use crate::commands::Commands;
use crate::context::Context;
use crate::copy::{STAGING_BYTES, region, upload};
use crate::error::failed;
use ash::vk;
use gpu_allocator::MemoryLocation;
use rhytid_core::plan::{Dispatch, Plan, PlanLimits, Role};
use rhytid_core::{Error, HandleFrames, Result, Rig, Session, Stage, UploadOptions};
use std::sync::Arc;
use std::time::Duration;

/// Timestamps for a slice: before its first stage, and after each.
const TIMESTAMPS: usize = Stage::ALL.len() + 1;

/// A rig on a Vulkan device, and the results of the last batch.
pub struct VulkanSession {
    context: Arc<Context>,
    pub(crate) plan: Plan,
    max_frames: usize,
    /// Frames of the last batch.
    frames: usize,
    /// Whether its stages on demand have been computed.
    demanded: bool,
    /// The buffers, in the plan's order.
    buffers: Vec<Buffer>,
    /// The inputs of a batch, in memory that the host can write.
    inputs: Buffer,
    /// Memory in which the host can read a piece of a result.
    readback: Buffer,
    descriptor_pool: vk::DescriptorPool,
    /// One descriptor set for each dispatch of the largest batch.
    descriptor_sets: Vec<vk::DescriptorSet>,
    /// [`TIMESTAMPS`] queries for each slice. Null where the device cannot measure.
    timestamps: vk::QueryPool,
    batch: Commands,
    transfer: Commands,
    /// Plants a fault: the stages after this one do not wait for it.
    #[cfg(test)]
    pub(crate) no_barrier_after: Option<Stage>,
}

/// The place of consecutive frames of a stage's result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResultSlice {
    /// Frames × the stage's shape of `f32`, from offset 0, without padding. The buffer can be a storage
    /// buffer, a vertex buffer and the source of a copy. It belongs to the session's queue family only.
    pub buffer: vk::Buffer,
    /// The first frame in it, counted from the first of the batch.
    pub first_frame: usize,
    /// How many frames are in it.
    pub frames: usize,
}

impl VulkanSession {
    pub(crate) fn new(
        context: &Arc<Context>,
        rig: &Rig,
        options: UploadOptions,
        limits: PlanLimits,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as Usage;
        let plan = Plan::new(rig, options, limits, &context.id)?;
        context.require_memory(plan.bytes())?;
        let max_frames = options.max_frames;
        let mut buffers = Vec::with_capacity(plan.buffers().len());
        for planned in plan.buffers() {
            let usage = match planned.role {
                Role::Constant { .. } | Role::Input { .. } => Usage::STORAGE_BUFFER | Usage::TRANSFER_DST,
                Role::Scratch { .. } => Usage::STORAGE_BUFFER,
                Role::Result { .. } => Usage::STORAGE_BUFFER | Usage::TRANSFER_SRC | Usage::VERTEX_BUFFER,
            };
            let location = MemoryLocation::GpuOnly;
            buffers.push(Buffer::new(context, planned.buffer.name(), planned.bytes, usage, location)?);
        }
        let host_buffer = |name, bytes: usize, usage, location| {
            Buffer::new(context, name, (bytes as u64).max(4), usage, location)
        };
        let most = Stage::ALL.map(|stage| plan.frame_bytes(stage)).into_iter().max().unwrap_or(0);
        let readback_bytes = (most * max_frames).min(STAGING_BYTES as usize);
        let mut session = Self {
            context: context.clone(),
            max_frames,
            frames: 0,
            demanded: false,
            inputs: host_buffer(
                "inputs from the host",
                max_frames * plan.input_bytes(),
                Usage::TRANSFER_SRC,
                MemoryLocation::CpuToGpu,
            )?,
            readback: host_buffer(
                "results for the host",
                readback_bytes,
                Usage::TRANSFER_DST,
                MemoryLocation::GpuToCpu,
            )?,
            buffers,
            plan,
            descriptor_pool: vk::DescriptorPool::null(),
            descriptor_sets: Vec::new(),
            timestamps: vk::QueryPool::null(),
            batch: Commands::new(context)?,
            transfer: Commands::new(context)?,
            #[cfg(test)]
            no_barrier_after: None,
        };
        session.make_descriptor_sets()?;
        session.make_timestamps()?;
        upload(&session.plan, rig, &session.buffers, context, &mut session.transfer)?;
        context.check()?;
        Ok(session)
    }

    fn make_descriptor_sets(&mut self) -> Result<()> {
        let device = &self.context.device;
        let failed = || failed(&self.context.id, "making the descriptor sets");
        let dispatches = self.plan.dispatches(self.max_frames);
        let bound: usize = dispatches.iter().map(|dispatch| dispatch.buffers.len()).sum();
        let sizes = [vk::DescriptorPoolSize::default()
            .ty(vk::DescriptorType::STORAGE_BUFFER)
            .descriptor_count(bound as u32)];
        let create =
            vk::DescriptorPoolCreateInfo::default().max_sets(dispatches.len() as u32).pool_sizes(&sizes);
        // SAFETY: the device is alive, here and in the whole file.
        self.descriptor_pool = unsafe { device.create_descriptor_pool(&create, None) }.map_err(failed())?;
        let layouts: Vec<_> =
            dispatches.iter().map(|d| self.context.pipeline(d.kernel, d.frames_at_once).set_layout).collect();
        let allocate = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(self.descriptor_pool)
            .set_layouts(&layouts);
        // SAFETY: the pool has room for these, and no other code uses it.
        self.descriptor_sets = unsafe { device.allocate_descriptor_sets(&allocate) }.map_err(failed())?;
        for (dispatch, &set) in dispatches.iter().zip(&self.descriptor_sets) {
            let infos: Vec<_> = dispatch
                .buffers
                .iter()
                .map(|&b| {
                    let raw = self.buffers[b].raw;
                    [vk::DescriptorBufferInfo::default().buffer(raw).range(vk::WHOLE_SIZE)]
                })
                .collect();
            let writes: Vec<_> = (0..)
                .zip(&infos)
                .map(|(binding, info)| {
                    vk::WriteDescriptorSet::default()
                        .dst_set(set)
                        .dst_binding(binding)
                        .descriptor_type(vk::DescriptorType::STORAGE_BUFFER)
                        .buffer_info(info)
                })
                .collect();
            // SAFETY: the set is not in use yet; its layout has these bindings.
            unsafe { device.update_descriptor_sets(&writes, &[]) };
        }
        Ok(())
    }

    fn make_timestamps(&mut self) -> Result<()> {
        if self.context.clock.is_none() {
            return Ok(());
        }
        let count = TIMESTAMPS * self.plan.slices(self.max_frames).count();
        let create =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count as u32);
        // SAFETY: as above.
        let pool = unsafe { self.context.device.create_query_pool(&create, None) };
        self.timestamps = pool.map_err(failed(&self.context.id, "making timestamps"))?;
        Ok(())
    }

    /// As [`Session::evaluate`], for a renderer that shares the device. The batch starts after `wait`.
    /// `signal` is signalled when the results are complete and visible to work that waits for it. A renderer
    /// may still be reading the last results. It then has to signal a semaphore of `wait` when it is done.
    ///
    /// Work that the renderer submits later to the same queue sees the results without a semaphore.
    ///
    /// # Errors
    /// As [`Session::evaluate`]; [`Error::Input`] if the positions are not frames × H × 3 for 1 to
    /// [`UploadOptions::max_frames`] frames. It is not checked that they are finite.
    ///
    /// # Safety
    /// The semaphores are binary, belong to the session's device, and stay alive until the batch is done.
    /// Each semaphore of `wait` is signalled, or the work that signals it has been submitted. No semaphore of
    /// `signal` is signalled, or will be signalled by other work.
    pub unsafe fn evaluate_with(
        &mut self,
        frames: HandleFrames<'_>,
        wait: &[vk::Semaphore],
        signal: &[vk::Semaphore],
    ) -> Result<()> {
        let HandleFrames { positions, frames } = frames;
        let expected = frames.checked_mul(self.plan.values_per_frame());
        if frames == 0 || frames > self.max_frames || expected != Some(positions.len()) {
            return Err(Error::mismatch(format!(
                "a batch of {frames} frames has {} numbers, expected 1 to {} frames of {}",
                positions.len(),
                self.max_frames,
                self.plan.values_per_frame()
            )));
        }
        let commands = self.batch.begin()?;
        let mut copies = Vec::new();
        let mut filled = 0;
        for input in self.plan.inputs(HandleFrames { positions, frames }) {
            let bytes: &[u8] = bytemuck::cast_slice(&input.numbers);
            self.inputs.mapped()[filled..][..bytes.len()].copy_from_slice(bytes);
            copies.push((self.buffers[input.buffer].raw, region(filled, 0, bytes.len())));
            filled += bytes.len();
        }
        self.record(commands, frames, &copies);
        // SAFETY: the buffers live until the batch is done, and the caller guarantees the semaphores.
        unsafe { self.batch.submit(wait, signal) }?;
        (self.frames, self.demanded) = (frames, false);
        self.context.check()
    }

    /// Records a batch: first the copies of the inputs, then slice by slice one stage after the other.
    fn record(&self, commands: vk::CommandBuffer, frames: usize, copies: &[(vk::Buffer, vk::BufferCopy)]) {
        let device = &self.context.device;
        let measured = self.timestamps != vk::QueryPool::null();
        let slices: Vec<_> = self.plan.slices(frames).collect();
        if measured {
            let count = (TIMESTAMPS * slices.len()) as u32;
            // SAFETY: the pool has at least this many queries, and the last batch is done with it.
            unsafe { device.cmd_reset_query_pool(commands, self.timestamps, 0, count) };
        }
        for &(to, region) in copies {
            // SAFETY: the region is within both buffers.
            unsafe { device.cmd_copy_buffer(commands, self.inputs.raw, to, &[region]) };
        }
        self.context.barrier(commands, Access::COPY_WRITE, Access::KERNEL_READ);

        let timestamp = |query: usize| {
            if measured {
                let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
                // SAFETY: the pool has this query, and it was reset above.
                unsafe { device.cmd_write_timestamp(commands, stage, self.timestamps, query as u32) };
            }
        };
        let dispatches = self.plan.dispatches(frames);
        let in_batch = |(dispatch, _): &(&Dispatch, _)| !self.plan.is_on_demand(dispatch.stage);
        let mut dispatches = dispatches.iter().zip(&self.descriptor_sets).filter(in_batch).peekable();
        for slice in 0..slices.len() {
            timestamp(slice * TIMESTAMPS);
            for (i, stage) in Stage::ALL.into_iter().enumerate() {
                let mut before: Option<&Dispatch> = None;
                while let Some((dispatch, &set)) = dispatches.next_if(|(dispatch, _)| dispatch.stage == stage)
                {
                    if before.is_some_and(|before| dispatch.follows(before)) {
                        self.context.barrier(commands, Access::KERNEL_WRITE, Access::KERNEL_READ);
                    }
                    before = Some(dispatch);
                    self.record_dispatch(commands, dispatch, set);
                }
                timestamp(slice * TIMESTAMPS + 1 + i);
                #[cfg(test)]
                if self.no_barrier_after == Some(stage) {
                    continue;
                }
                self.context.barrier(commands, Access::KERNEL_WRITE, Access::KERNEL_READ);
            }
        }
        self.context.barrier(commands, Access::KERNEL_WRITE, Access::ANY_READ);
    }

    fn record_dispatch(&self, commands: vk::CommandBuffer, dispatch: &Dispatch, set: vk::DescriptorSet) {
        let device = &self.context.device;
        let pipeline = self.context.pipeline(dispatch.kernel, dispatch.frames_at_once);
        let [x, y] = dispatch.workgroups;
        // SAFETY: pipeline and set are alive and fit together. The plan stays within the limits.
        unsafe {
            let point = vk::PipelineBindPoint::COMPUTE;
            device.cmd_bind_pipeline(commands, point, pipeline.raw);
            device.cmd_bind_descriptor_sets(commands, point, pipeline.layout, 0, &[set], &[]);
            let params = bytemuck::cast_slice(&dispatch.params);
            device.cmd_push_constants(commands, pipeline.layout, vk::ShaderStageFlags::COMPUTE, 0, params);
            device.cmd_dispatch(commands, x, y, 1);
        }
    }

    /// Computes a stage that the batch left out, and waits for it.
    fn demand(&mut self, stage: Stage) -> Result<()> {
        let commands = self.transfer.begin()?;
        let dispatches = self.plan.dispatches(self.frames);
        for (dispatch, &set) in dispatches.iter().zip(&self.descriptor_sets) {
            if dispatch.stage == stage {
                self.record_dispatch(commands, dispatch, set);
            }
        }
        self.context.barrier(commands, Access::KERNEL_WRITE, Access::ANY_READ);
        // SAFETY: the commands are recorded above, and waited for below.
        unsafe { self.transfer.submit(&[], &[]) }?;
        self.transfer.wait()?;
        self.demanded = true;
        Ok(())
    }

    /// Waits for the last batch, and computes the stage if the batch left it out.
    fn complete(&mut self, stage: Stage) -> Result<()> {
        self.batch.wait()?;
        if self.plan.is_on_demand(stage) && !self.demanded {
            self.demand(stage)?;
        }
        Ok(())
    }

    /// Copies a part of a buffer to the begin of `readback`, and waits for the copy.
    fn fetch(&mut self, from: vk::Buffer, first: usize, bytes: usize) -> Result<()> {
        let commands = self.transfer.begin()?;
        let region = region(first, 0, bytes);
        // SAFETY: both buffers are alive until the copy is done, and the region is within them.
        unsafe { self.context.device.cmd_copy_buffer(commands, from, self.readback.raw, &[region]) };
        self.context.barrier(commands, Access::COPY_WRITE, Access::HOST_READ);
        // SAFETY: the commands are recorded above, and waited for below.
        unsafe { self.transfer.submit(&[], &[]) }?;
        self.transfer.wait()
    }

    /// As [`Session::read`], in the memory of the host to which the device copies: no second copy is made.
    /// The next call of the session overwrites it. `None` if the stage is in several buffers, or is larger
    /// than that memory, which has 16 MiB at most.
    ///
    /// # Errors
    /// As [`Session::read`].
    pub fn map(&mut self, stage: Stage) -> Result<Option<&[f32]>> {
        let bytes = self.frames * self.plan.frame_bytes(stage);
        let results = self.result(stage);
        let [result] = results[..] else { return Ok(None) };
        if bytes > self.readback.bytes {
            return Ok(None);
        }
        self.complete(stage)?;
        if bytes > 0 {
            self.fetch(result.buffer, 0, bytes)?;
        }
        self.context.check()?;
        Ok(Some(bytemuck::cast_slice(&self.readback.mapped()[..bytes])))
    }

    /// The places of the last batch's results on the device, in the order of their frames. The semaphores of
    /// [`VulkanSession::evaluate_with`] tell when the results are complete. A stage that is [on
    /// demand](rhytid_core::plan::Plan::is_on_demand) is complete when it has been read. The next batch
    /// overwrites the results. The buffers belong to the session.
    pub fn result(&self, stage: Stage) -> Vec<ResultSlice> {
        let at = Stage::ALL.iter().position(|&s| s == stage).unwrap_or(0);
        self.plan
            .slices(self.frames)
            .map(|slice| ResultSlice {
                buffer: self.buffers[slice.results[at]].raw,
                first_frame: slice.frames.start,
                frames: slice.frames.len(),
            })
            .collect()
    }
}

impl Session for VulkanSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        // SAFETY: no semaphores are passed.
        unsafe { self.evaluate_with(frames, &[], &[]) }
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.complete(stage)?;
        let frame_bytes = self.plan.frame_bytes(stage);
        out.clear();
        out.resize(self.frames * frame_bytes / 4, 0.0);
        for slice in self.result(stage) {
            let end = slice.frames * frame_bytes;
            for first in (0..end).step_by(self.readback.bytes) {
                let n = (end - first).min(self.readback.bytes);
                self.fetch(slice.buffer, first, n)?;
                let bytes: &mut [u8] = bytemuck::cast_slice_mut(out);
                let at = slice.first_frame * frame_bytes + first;
                bytes[at..][..n].copy_from_slice(&self.readback.mapped()[..n]);
            }
        }
        self.context.check()
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        self.batch.wait()?;
        let Some(clock) = self.context.clock else { return Ok(None) };
        let mut ticks = vec![0_u64; TIMESTAMPS * self.plan.slices(self.frames).count()];
        if !ticks.is_empty() {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: the last batch has written these queries.
            unsafe { self.context.device.get_query_pool_results(self.timestamps, 0, &mut ticks, flags) }
                .map_err(failed(&self.context.id, "reading timestamps"))?;
        }
        let mut times = [Duration::ZERO; 6];
        for of_slice in ticks.chunks_exact(TIMESTAMPS) {
            for (time, tick) in times.iter_mut().zip(of_slice.windows(2)) {
                *time += clock.between(tick[0], tick[1]);
            }
        }
        self.context.check()?;
        Ok(Some(times))
    }
}

impl Drop for VulkanSession {
    fn drop(&mut self) {
        for commands in [&mut self.batch, &mut self.transfer] {
            if let Err(cause) = commands.wait() {
                log::warn!("{cause}");
            }
        }
        if self.context.is_abandoned() {
            return;
        }
        // SAFETY: the device is done with them. Objects that were not made are null, which is ignored.
        unsafe {
            self.context.device.destroy_descriptor_pool(self.descriptor_pool, None);
            self.context.device.destroy_query_pool(self.timestamps, None);
        }
    }
}
