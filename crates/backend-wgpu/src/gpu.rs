//! An opened device with its compiled kernels, shared by the sessions on it.
use crate::faults::{Faults, Pending, error, error_of, scoped};
use crate::limits::{lacking, max_binding_bytes};
use rhytid_core::plan::PlanLimits;
use rhytid_core::{DeviceErrorKind, Error, Result};
use rhytid_kernels::table::{Access, Kernel, builds};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The device, its queue and its pipelines.
#[derive(Debug)]
pub(crate) struct Gpu {
    /// The name of the device in errors.
    pub id: String,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// The limits of one buffer and of one dispatch.
    pub limits: PlanLimits,
    /// The pipelines, in the order of [`builds`].
    pipelines: Vec<wgpu::ComputePipeline>,
    faults: Arc<Faults>,
    turn: Option<Mutex<()>>,
}

impl Gpu {
    /// Compiles the kernels for `device`, whose limits must be sufficient. `faults` collects the faults of a
    /// device that this crate has opened.
    pub(crate) fn new(
        id: String,
        device: wgpu::Device,
        queue: wgpu::Queue,
        faults: Arc<Faults>,
    ) -> Result<Self> {
        let limits = device.limits();
        if let Some(lacking) = lacking(&limits) {
            return Err(error(DeviceErrorKind::Unsupported, &id, lacking));
        }
        let mut pending = Pending::default();
        let pipelines = scoped(&device, &mut pending, || {
            builds().map(|(k, frames)| pipeline(&device, k, frames)).collect()
        });
        let gl = device.adapter_info().backend == wgpu::Backend::Gl;
        let gpu = Self {
            id,
            device,
            queue,
            limits: PlanLimits {
                max_binding_bytes: max_binding_bytes(&limits),
                max_workgroups: limits.max_compute_workgroups_per_dimension,
            },
            pipelines,
            faults,
            turn: gl.then(Mutex::default),
        };
        gpu.check(pending.known(), "building the kernels").map_err(|e| match e {
            Error::Device { kind: DeviceErrorKind::Driver, device, message } => {
                Error::Device { kind: DeviceErrorKind::Build, device, message }
            }
            e => e,
        })?;
        Ok(gpu)
    }

    pub(crate) fn pipeline(&self, kernel: Kernel, frames_at_once: u32) -> &wgpu::ComputePipeline {
        let index = builds().position(|build| build == (kernel, frames_at_once));
        &self.pipelines[index.unwrap_or_else(|| unreachable!("{} is one of the kernels", kernel.name()))]
    }

    /// A lock to hold during calls of wgpu, and for [`Gpu::check`] and [`Gpu::wait`]. On GL all threads share
    /// a context. wgpu panics if one of them keeps it busy for some seconds. Other APIs need no lock.
    pub(crate) fn turn(&self) -> Option<MutexGuard<'_, ()>> {
        self.turn.as_ref().map(|turn| turn.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// An error if the device is lost. Otherwise the error of `fault`, which occurred while `doing`
    /// something.
    pub(crate) fn check(&self, fault: Option<wgpu::Error>, doing: &str) -> Result<()> {
        if let Some(reason) = self.faults.lost.get() {
            return Err(self.lost(doing, reason));
        }
        let Some(fault) = fault.or_else(|| self.faults.take_uncaptured()) else { return Ok(()) };
        // A lost device refuses every call as invalid. A host's device does not report its loss to this
        // crate.
        if matches!(fault, wgpu::Error::Validation { .. }) && self.refuses_everything() {
            return Err(self.lost(doing, "it refuses everything"));
        }
        Err(error_of(&fault, &self.id, doing))
    }

    /// Whether even the simplest call fails.
    fn refuses_everything(&self) -> bool {
        scoped(&self.device, &mut Pending::default(), || {
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("probe"),
                size: 16,
                usage: wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: true,
            });
            buffer.get_mapped_range_mut(..).is_err()
        })
    }

    /// Waits until the device has finished `submission`.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn wait(&self, submission: &wgpu::SubmissionIndex, doing: &str) -> Result<()> {
        use std::panic::{AssertUnwindSafe, catch_unwind};
        use std::time::{Duration, Instant};
        let wait = wgpu::PollType::Wait { submission_index: Some(submission.clone()), timeout: None };
        loop {
            self.check(None, doing)?;
            let start = Instant::now();
            // wgpu panics if the device is lost meanwhile.
            match catch_unwind(AssertUnwindSafe(|| self.device.poll(wait.clone()))) {
                Ok(Ok(_)) => return Ok(()),
                // GL waits for at most two seconds. If it returns sooner, the driver has refused to wait.
                Ok(Err(wgpu::PollError::Timeout)) if start.elapsed() > Duration::from_secs(1) => {}
                Ok(Err(reason)) => return Err(self.lost(doing, &reason.to_string())),
                Err(_) => return Err(self.lost(doing, "the driver stopped answering")),
            }
        }
    }

    /// Browsers do not allow waiting; the work proceeds without it.
    #[cfg(target_arch = "wasm32")]
    pub(crate) fn wait(&self, _: &wgpu::SubmissionIndex, _: &str) -> Result<()> {
        Ok(())
    }

    /// Marks the device as lost from now on, and gives the error.
    pub(crate) fn lost(&self, doing: &str, reason: &str) -> Error {
        let reason = self.faults.lost.get_or_init(|| reason.to_owned());
        let message =
            format!("the device was lost while {doing} ({reason}); open it again or use another one");
        error(DeviceErrorKind::Lost, &self.id, message)
    }
}

fn pipeline(device: &wgpu::Device, kernel: Kernel, frames_at_once: u32) -> wgpu::ComputePipeline {
    let entry = kernel.entry();
    let storage = entry
        .bindings
        .iter()
        .map(|binding| wgpu::BufferBindingType::Storage { read_only: binding.access == Access::Read });
    let entries: Vec<wgpu::BindGroupLayoutEntry> = storage
        .chain([wgpu::BufferBindingType::Uniform])
        .enumerate()
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    let label = Some(entry.name);
    let bind_group_layout =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&bind_group_layout)],
        immediate_size: 0,
    });
    let source = wgpu::ShaderSource::Wgsl(entry.wgsl.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let constants = [("FRAMES", f64::from(frames_at_once))];
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: Some(&layout),
        module: &module,
        entry_point: Some(entry.name),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: if entry.batched { &constants } else { &[] },
            ..Default::default()
        },
        cache: None,
    })
}
