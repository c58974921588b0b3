//! A rig on an OpenCL device.
use crate::OpenCl;
use crate::cl::{self, Buffer, Event, Queue};
use crate::status::Status;
use opencl_sys::{CL_MEM_READ_ONLY, CL_MEM_READ_WRITE, CL_PROFILING_INFO_NOT_AVAILABLE};
use rhytid_core::plan::{Dispatch, Input, Plan, Role};
use rhytid_core::{DeviceErrorKind, Error, HandleFrames, Result, Rig, Session, Stage, UploadOptions};
use std::time::Duration;

/// A rig in an OpenCL device's memory, and the results of the last batch.
#[derive(Debug)]
pub struct OpenClSession {
    device: String,
    plan: Plan,
    queue: Queue,
    /// In the plan's order.
    buffers: Vec<Buffer>,
    /// The kernel of each dispatch of the largest batch. Its buffers are bound once.
    kernels: Vec<Bound>,
    /// Frames of the last batch. `dispatches` are what it ran. The kernels have these parameters.
    frames: usize,
    dispatches: Vec<Dispatch>,
    /// The memory from which `writes` copy.
    inputs: Vec<Vec<f32>>,
    writes: Vec<Event>,
    /// The events of those `dispatches` that have run, with their stages.
    runs: Vec<(Stage, Event)>,
}

/// A kernel with its buffers.
#[derive(Debug)]
struct Bound {
    workgroup_size: usize,
    /// One build for each value of `FRAMES`.
    builds: Vec<(u32, cl::Kernel)>,
}

impl Bound {
    /// The kernel that runs `dispatch`.
    fn build(&mut self, dispatch: &Dispatch) -> Result<&mut cl::Kernel> {
        let mut builds = self.builds.iter_mut();
        let found = builds.find(|(frames, _)| *frames == dispatch.frames_at_once);
        found.map(|(_, kernel)| kernel).ok_or_else(|| {
            let (name, frames) = (dispatch.kernel.name(), dispatch.frames_at_once);
            Error::Internal(format!(
                "there is no OpenCL program of the kernel {name} for {frames} frames at once"
            ))
        })
    }
}

impl OpenClSession {
    pub(crate) fn new(on: &OpenCl, rig: &Rig, options: UploadOptions) -> Result<Self> {
        let device = on.name.clone();
        let plan = Plan::new(rig, options, on.limits, &device)?;
        // Some drivers allocate on first use. Without this check, the operating system would then stop the
        // program.
        if plan.bytes() > on.memory_bytes {
            let message = format!(
                "the rig with batches of {} frames needs {} bytes, and the device has {}; make batches smaller, or store the \
                 basis as fp16",
                options.max_frames,
                plan.bytes(),
                on.memory_bytes
            );
            return Err(Error::Device { kind: DeviceErrorKind::OutOfMemory, device, message });
        }
        let queue = Queue::new(&on.context, on.device).map_err(Status::error(&device, "making a queue"))?;
        let mut buffers = Vec::with_capacity(plan.buffers().len());
        for (index, planned) in plan.buffers().iter().enumerate() {
            let flags = if matches!(planned.role, Role::Result { .. } | Role::Scratch { .. }) {
                CL_MEM_READ_WRITE
            } else {
                CL_MEM_READ_ONLY
            };
            let doing = format!("making the buffer {} of {} bytes", planned.buffer.name(), planned.bytes);
            let buffer = Buffer::with_bytes(&on.context, flags, planned.bytes as usize)
                .map_err(Status::error(&device, &doing))?;
            let contents = plan.contents(rig, index);
            if !contents.is_empty() {
                let doing =
                    format!("filling the buffer {} with {} bytes", planned.buffer.name(), contents.len());
                queue.write(&buffer, &contents).map_err(Status::error(&device, &doing))?;
            }
            buffers.push(buffer);
        }
        let mut kernels = Vec::new();
        for dispatch in plan.dispatches(options.max_frames) {
            let mut builds = on.kernels(dispatch.kernel)?;
            for (argument, &buffer) in dispatch.buffers.iter().enumerate() {
                let doing =
                    format!("binding {} to {}", plan.buffers()[buffer].buffer.name(), dispatch.kernel.name());
                for (_, kernel) in &mut builds {
                    kernel.set_buffer(argument, &buffers[buffer]).map_err(Status::error(&device, &doing))?;
                }
            }
            kernels.push(Bound { workgroup_size: on.workgroup_size(dispatch.kernel), builds });
        }
        Ok(Self {
            device,
            plan,
            queue,
            buffers,
            kernels,
            frames: 0,
            dispatches: Vec::new(),
            inputs: Vec::new(),
            writes: Vec::new(),
            runs: Vec::new(),
        })
    }

    /// Gives the kernels their parameters for a batch of this size.
    fn prepare(&mut self, frames: usize) -> Result<()> {
        if self.frames == frames {
            return Ok(());
        }
        self.frames = 0;
        self.dispatches = self.plan.dispatches(frames);
        for (dispatch, bound) in self.dispatches.iter().zip(&mut self.kernels) {
            let doing = format!("setting the parameters of {}", dispatch.kernel.name());
            bound
                .build(dispatch)?
                .set_words(dispatch.buffers.len(), &dispatch.params)
                .map_err(Status::error(&self.device, &doing))?;
        }
        self.frames = frames;
        Ok(())
    }

    /// Starts the dispatches of the stages for which `wanted` is true.
    fn run(&mut self, wanted: impl Fn(Stage) -> bool) -> Result<()> {
        for (dispatch, bound) in self.dispatches.iter().zip(&mut self.kernels) {
            if !wanted(dispatch.stage) {
                continue;
            }
            let workgroup_size = bound.workgroup_size;
            let kernel = bound.build(dispatch)?;
            // SAFETY: buffers and parameters are the plan's for this rig, whose indices were checked.
            let event = unsafe { self.queue.run(kernel, dispatch.workgroups, workgroup_size) };
            let doing = || format!("starting the kernel {}", dispatch.kernel.name());
            let event = event.map_err(|status| Status::error(&self.device, &doing())(status))?;
            self.runs.push((dispatch.stage, event));
        }
        self.queue.flush().map_err(Status::error(&self.device, "starting the kernels"))
    }

    fn wait(&self) -> Result<()> {
        Event::wait(self.runs.iter().map(|(_, event)| event))
            .map_err(Status::error(&self.device, "running the kernels"))
    }
}

impl Session for OpenClSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        let copying = || Status::error(&self.device, "copying the inputs");
        // The inputs are about to be overwritten.
        Event::wait(self.writes.iter()).map_err(copying())?;
        self.writes.clear();
        self.runs.clear();
        self.prepare(frames.frames)?;
        self.inputs.clear();

        let copying = || Status::error(&self.device, "copying the inputs");
        for Input { buffer, numbers } in self.plan.inputs(frames) {
            self.inputs.push(numbers.into_owned());
            let numbers = &self.inputs[self.inputs.len() - 1];
            // SAFETY: code that changes or drops the inputs waits for the writes.
            let event =
                unsafe { self.queue.start_write(&self.buffers[buffer], bytemuck::cast_slice(numbers)) };
            self.writes.push(event.map_err(copying())?);
        }
        let on_demand = Stage::ALL.map(|stage| self.plan.is_on_demand(stage));
        self.run(|stage| !on_demand[stage as usize])
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        if self.plan.is_on_demand(stage) && self.runs.iter().all(|(ran, _)| *ran != stage) {
            self.run(|wanted| wanted == stage)?;
        }
        self.wait()?;
        let per_frame = self.plan.frame_bytes(stage) / size_of::<f32>();
        out.resize(self.frames * per_frame, 0.0);
        if per_frame == 0 {
            return Ok(());
        }
        for slice in self.plan.slices(self.frames) {
            let result = &self.buffers[slice.results[stage as usize]];
            let out = &mut out[slice.frames.start * per_frame..slice.frames.end * per_frame];
            self.queue
                .read(result, bytemuck::cast_slice_mut(out))
                .map_err(Status::error(&self.device, "reading a result"))?;
        }
        Ok(())
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        self.wait()?;
        let mut times = [Duration::ZERO; 6];
        for (stage, run) in &self.runs {
            match run.nanoseconds() {
                Ok(time) => times[*stage as usize] += Duration::from_nanos(time),
                Err(Status(CL_PROFILING_INFO_NOT_AVAILABLE)) => return Ok(None),
                Err(status) => return Err(Status::error(&self.device, "reading a kernel's times")(status)),
            }
        }
        Ok(Some(times))
    }
}

impl Drop for OpenClSession {
    fn drop(&mut self) {
        // The device may still be copying from the inputs, which are dropped here.
        if let Err(status) = self.queue.finish() {
            log::debug!("{}: waiting for the last batch returned {status:?}", self.device);
        }
    }
}
