//! A rig on a device of wgpu.
use crate::device::blocking;
use crate::faults::{Pending, scoped};
use crate::gpu::Gpu;
use futures_channel::oneshot;
use rhytid_core::plan::{Dispatch, Plan, PlanLimits, Role, Slice};
use rhytid_core::{HandleFrames, Result, Rig, Session, Stage, UploadOptions};
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;
use wgpu::BufferUsages;

/// A rig in a device's memory, and the results of the last batch.
#[derive(Debug)]
pub struct WgpuSession {
    gpu: Arc<Gpu>,
    plan: Plan,
    /// The buffers of the plan.
    buffers: Vec<wgpu::Buffer>,
    /// The parameter blocks of the largest batch's dispatches, `params_stride` bytes apart.
    params: wgpu::Buffer,
    params_stride: usize,
    /// One bind group for each dispatch of the largest batch.
    bind_groups: Vec<wgpu::BindGroup>,
    timer: Option<Timer>,
    /// The buffer through which results are read. It is as large as the largest result so far.
    staging: Option<wgpu::Buffer>,
    /// The frames of the last batch. 0 if there was none, or if it failed.
    frames: usize,
    dispatches: Vec<Dispatch>,
    slices: Vec<Slice>,
    /// Whether its stages on demand have been computed.
    demanded: bool,
    /// Errors of earlier calls that are not known yet.
    pending: Pending,
}

/// The begin and the end of each pass, in ticks of the device.
#[derive(Debug)]
struct Timer {
    queries: wgpu::QuerySet,
    ticks: wgpu::Buffer,
}

impl WgpuSession {
    pub(crate) fn new(gpu: Arc<Gpu>, rig: &Rig, options: UploadOptions, limits: PlanLimits) -> Result<Self> {
        let plan = Plan::new(rig, options, limits, &gpu.id)?;
        let dispatches = plan.dispatches(options.max_frames);
        let alignment = gpu.device.limits().min_uniform_buffer_offset_alignment as usize;
        let most_words = dispatches.iter().map(|dispatch| dispatch.params.len()).max().unwrap_or(1);
        let params_stride = params_bytes(most_words).next_multiple_of(alignment);
        let mut pending = Pending::default();
        let turn = gpu.turn();

        let mut buffers = Vec::with_capacity(plan.buffers().len());
        for (i, planned) in plan.buffers().iter().enumerate() {
            let usage = match planned.role {
                Role::Constant { .. } | Role::Input { .. } => BufferUsages::STORAGE | BufferUsages::COPY_DST,
                Role::Result { stage: Stage::Positions | Stage::Normals, .. } => {
                    BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::VERTEX
                }
                Role::Result { .. } => BufferUsages::STORAGE | BufferUsages::COPY_SRC,
                Role::Scratch { .. } => BufferUsages::STORAGE,
            };
            let doing = format!("uploading {}", planned.buffer.name());
            let submission = scoped(&gpu.device, &mut pending, || {
                let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(planned.buffer.name()),
                    size: planned.bytes,
                    usage,
                    mapped_at_creation: false,
                });
                let contents = plan.contents(rig, i);
                if !contents.is_empty() {
                    gpu.queue.write_buffer(&buffer, 0, &contents);
                }
                buffers.push(buffer);
                (!contents.is_empty()).then(|| gpu.queue.submit([]))
            });
            gpu.check(pending.known(), &doing)?;
            // wgpu keeps a copy until the data are on the device. With this wait, it keeps only one buffer,
            // not the whole rig.
            if let Some(submission) = submission {
                gpu.wait(&submission, &doing)?;
            }
        }

        let (params, bind_groups, timer) = scoped(&gpu.device, &mut pending, || {
            let params = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("params"),
                size: (dispatches.len().max(1) * params_stride) as u64,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let bind_group = |(i, dispatch)| bind_group(&gpu, dispatch, &buffers, &params, i * params_stride);
            let bind_groups = dispatches.iter().enumerate().map(bind_group).collect();
            (params, bind_groups, Timer::new(&gpu.device, passes(&dispatches).count() as u32))
        });
        gpu.check(pending.known(), "binding the buffers")?;
        drop(turn);

        Ok(Self {
            gpu,
            plan,
            buffers,
            params,
            params_stride,
            bind_groups,
            timer,
            staging: None,
            frames: 0,
            dispatches: Vec::new(),
            slices: Vec::new(),
            demanded: false,
            pending,
        })
    }

    /// The buffers that hold a stage of the last batch, each with its frames, in the order of the batch. They
    /// are arrays of f32, frames × [`Stage::values_per_frame`]. Every batch uses the same buffers. Those of
    /// positions and normals can be bound as vertex buffers: `Float32x3`, 12 bytes apart.
    ///
    /// Work that is submitted to the same queue after a batch sees its results. A stage that is [on
    /// demand](Plan::is_on_demand) is complete only when it has been read.
    pub fn results(&self, stage: Stage) -> impl Iterator<Item = (Range<usize>, &wgpu::Buffer)> {
        self.slices
            .iter()
            .map(move |slice| (slice.frames.clone(), &self.buffers[slice.results[stage as usize]]))
    }

    /// Waits until the last batch is done, for example to time it. Reading waits by itself, and drawing needs
    /// no wait. In a browser this does not wait.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`].
    pub fn wait(&self) -> Result<()> {
        let _turn = self.gpu.turn();
        self.gpu.wait(&self.gpu.queue.submit([]), "waiting for a batch")
    }

    /// [`Session::read`] for browsers. Elsewhere it waits within the first poll.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`]. This includes errors of the last batch, which are not known sooner in
    /// a browser.
    pub async fn read_async(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        out.clear();
        if self.plan.is_on_demand(stage) && !self.demanded {
            self.demand(stage)?;
        }
        let frame_bytes = self.plan.frame_bytes(stage);
        for slice in self.slices.clone() {
            let first = out.len();
            let bytes = slice.frames.len() * frame_bytes;
            out.resize(first + bytes / 4, 0.0);
            let buffer = self.buffers[slice.results[stage as usize]].clone();
            self.read_buffer(&buffer, bytemuck::cast_slice_mut(&mut out[first..])).await?;
        }
        Ok(())
    }

    /// [`Session::stage_times`] for browsers. Elsewhere it waits within the first poll.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`].
    pub async fn stage_times_async(&mut self) -> Result<Option<[Duration; 6]>> {
        let Some(ticks) = self.timer.as_ref().map(|timer| timer.ticks.clone()) else { return Ok(None) };
        let stages = passes(&self.dispatches).map(|pass| pass[0].stage);
        let stages: Vec<Stage> = stages.filter(|stage| !self.plan.is_on_demand(*stage)).collect();
        let mut spans = vec![[0_u64; 2]; stages.len()];
        self.read_buffer(&ticks, bytemuck::cast_slice_mut(&mut spans)).await?;
        let nanoseconds_per_tick = f64::from(self.gpu.queue.get_timestamp_period());
        let mut times = [Duration::ZERO; 6];
        for (stage, [begin, end]) in stages.into_iter().zip(spans) {
            let nanoseconds = end.saturating_sub(begin) as f64 * nanoseconds_per_tick;
            times[stage as usize] += Duration::from_nanos(nanoseconds as u64);
        }
        Ok(Some(times))
    }

    /// Fills `out` with the first bytes of `source`.
    async fn read_buffer(&mut self, source: &wgpu::Buffer, out: &mut [u8]) -> Result<()> {
        const DOING: &str = "reading results";
        if out.is_empty() {
            return Ok(());
        }
        let bytes = out.len() as u64;
        let (mapped, mapping) = oneshot::channel();
        let staging = {
            let _turn = self.gpu.turn();
            // The buffer is kept only after a success: a caller that stops waiting would leave it mapped.
            let staging = self.staging.take().filter(|staging| staging.size() >= bytes);
            let device = &self.gpu.device;
            let (staging, submission) = scoped(device, &mut self.pending, || {
                let staging = staging.unwrap_or_else(|| {
                    device.create_buffer(&wgpu::BufferDescriptor {
                        label: Some("staging"),
                        size: bytes,
                        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
                        mapped_at_creation: false,
                    })
                });
                let mut encoder = device.create_command_encoder(&Default::default());
                encoder.copy_buffer_to_buffer(source, 0, &staging, 0, bytes);
                let submission = self.gpu.queue.submit([encoder.finish()]);
                staging.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
                    // The receiver may be gone.
                    let _ = mapped.send(result);
                });
                (staging, submission)
            });
            self.gpu.check(self.pending.known(), DOING)?;
            self.gpu.wait(&submission, DOING)?;
            staging
        };
        let (mapping, fault) = (mapping.await, self.pending.all().await);
        let _turn = self.gpu.turn();
        self.gpu.check(fault, DOING)?;
        match mapping {
            Ok(Ok(())) => {}
            Ok(Err(reason)) => return Err(self.gpu.lost(DOING, &reason.to_string())),
            Err(_) => return Err(self.gpu.lost(DOING, "the driver never delivered the results")),
        }
        let view = scoped(&self.gpu.device, &mut self.pending, || staging.get_mapped_range(0..bytes));
        let view = view.map_err(|reason| self.gpu.lost(DOING, &reason.to_string()))?;
        out.copy_from_slice(&view);
        drop(view);
        staging.unmap();
        self.staging = Some(staging);
        Ok(())
    }

    /// Encodes and submits the current dispatches of the stages for which `wanted` is true. Measures them if
    /// `timed` is true.
    fn submit(&self, wanted: impl Fn(Stage) -> bool, timed: bool) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut bind_groups = &self.bind_groups[..];
        let timer = self.timer.as_ref().filter(|_| timed);
        let mut queries = 0;
        for dispatches in passes(&self.dispatches) {
            let (of_pass, others) = bind_groups.split_at(dispatches.len());
            bind_groups = others;
            if !wanted(dispatches[0].stage) {
                continue;
            }
            let timestamp_writes = timer.map(|timer| wgpu::ComputePassTimestampWrites {
                query_set: &timer.queries,
                beginning_of_pass_write_index: Some(queries),
                end_of_pass_write_index: Some(queries + 1),
            });
            queries += 2;
            let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            for (dispatch, bind_group) in dispatches.iter().zip(of_pass) {
                pass.set_pipeline(self.gpu.pipeline(dispatch.kernel, dispatch.frames_at_once));
                pass.set_bind_group(0, bind_group, &[]);
                let [x, y] = dispatch.workgroups;
                pass.dispatch_workgroups(x, y, 1);
            }
        }
        if let Some(timer) = timer {
            encoder.resolve_query_set(&timer.queries, 0..queries, &timer.ticks, 0);
        }
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// Computes a stage that the batch left out.
    fn demand(&mut self, stage: Stage) -> Result<()> {
        let _turn = self.gpu.turn();
        let mut pending = std::mem::take(&mut self.pending);
        scoped(&self.gpu.device, &mut pending, || self.submit(|wanted| wanted == stage, false));
        self.pending = pending;
        self.gpu.check(self.pending.known(), "computing a stage")?;
        self.demanded = true;
        Ok(())
    }
}

impl Session for WgpuSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        const DOING: &str = "evaluating a batch";
        let _turn = self.gpu.turn();
        self.gpu.check(self.pending.known(), DOING)?;
        let same = self.frames == frames.frames;
        self.frames = 0;
        let mut pending = std::mem::take(&mut self.pending);
        if !same {
            self.dispatches = self.plan.dispatches(frames.frames);
            self.slices = self.plan.slices(frames.frames).collect();
        }
        scoped(&self.gpu.device, &mut pending, || {
            if !same {
                let mut params = vec![0; self.dispatches.len() * self.params_stride];
                for (params, dispatch) in params.chunks_exact_mut(self.params_stride).zip(&self.dispatches) {
                    let words: &[u8] = bytemuck::cast_slice(&dispatch.params);
                    params[..words.len()].copy_from_slice(words);
                }
                self.gpu.queue.write_buffer(&self.params, 0, &params);
            }
            for input in self.plan.inputs(frames) {
                let bytes = bytemuck::cast_slice(&input.numbers);
                self.gpu.queue.write_buffer(&self.buffers[input.buffer], 0, bytes);
            }
            self.submit(|stage| !self.plan.is_on_demand(stage), true);
        });
        self.pending = pending;
        self.gpu.check(self.pending.known(), DOING)?;
        (self.frames, self.demanded) = (frames.frames, false);
        Ok(())
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        blocking(self.read_async(stage, out))
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        blocking(self.stage_times_async())
    }
}

impl Drop for WgpuSession {
    fn drop(&mut self) {
        let _turn = self.gpu.turn();
        self.bind_groups.clear();
        self.buffers.clear();
        self.staging = None;
        self.timer = None;
    }
}

impl Timer {
    /// For the times of `passes` passes. `None` if the device cannot measure them.
    fn new(device: &wgpu::Device, passes: u32) -> Option<Self> {
        let count = passes * 2;
        let can = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        if !can || !(1..=wgpu::QUERY_SET_MAX_QUERIES).contains(&count) {
            return None;
        }
        let ty = wgpu::QueryType::Timestamp;
        Some(Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor { label: None, ty, count }),
            ticks: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("ticks"),
                size: u64::from(count) * u64::from(wgpu::QUERY_SIZE),
                usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
        })
    }
}

/// The dispatches that share a pass: those of one stage, so that it can be timed. wgpu orders dispatches that
/// depend on each other.
fn passes(dispatches: &[Dispatch]) -> impl Iterator<Item = &[Dispatch]> {
    dispatches.chunk_by(|a, b| a.stage == b.stage)
}

/// The size of a parameter block of `words` words. Uniform buffers are bound in multiples of 16 bytes.
fn params_bytes(words: usize) -> usize {
    (words * 4).next_multiple_of(16)
}

fn bind_group(
    gpu: &Gpu,
    dispatch: &Dispatch,
    buffers: &[wgpu::Buffer],
    params: &wgpu::Buffer,
    params_offset: usize,
) -> wgpu::BindGroup {
    let storage = dispatch.buffers.iter().map(|&buffer| buffers[buffer].as_entire_binding());
    let params = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: params,
        offset: params_offset as u64,
        size: wgpu::BufferSize::new(params_bytes(dispatch.params.len()) as u64),
    });
    let entries: Vec<wgpu::BindGroupEntry<'_>> = storage
        .chain([params])
        .enumerate()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(dispatch.kernel.name()),
        layout: &gpu.pipeline(dispatch.kernel, dispatch.frames_at_once).get_bind_group_layout(0),
        entries: &entries,
    })
}
