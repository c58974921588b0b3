//! wgpu's limits: those that a device is opened with, and those that the kernels need.
use rhytid_kernels::table::{Kernel, WORKGROUP_SIZE};

/// WebGPU's default limits, or less where the adapter has less. In a browser arrays may be as large as the adapter takes: whoever wrote
/// the browser has tried that.
pub(crate) fn limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    let has = adapter.limits();
    let limits = wgpu::Limits::default().or_worse_values_from(&has);
    if !cfg!(target_arch = "wasm32") {
        return limits;
    }
    wgpu::Limits {
        max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
        max_buffer_size: has.max_buffer_size,
        ..limits
    }
}

/// What `limits` lack for the kernels to run.
pub(crate) fn lacking(limits: &wgpu::Limits) -> Option<String> {
    let storage_buffers =
        Kernel::ALL.iter().map(|kernel| kernel.entry().bindings.len()).max().unwrap_or(0) as u32;
    let bindings = storage_buffers + 1;
    [
        ("max_bind_groups", limits.max_bind_groups, 1),
        ("max_bindings_per_bind_group", limits.max_bindings_per_bind_group, bindings),
        ("max_storage_buffers_per_shader_stage", limits.max_storage_buffers_per_shader_stage, storage_buffers),
        ("max_uniform_buffers_per_shader_stage", limits.max_uniform_buffers_per_shader_stage, 1),
        ("max_compute_invocations_per_workgroup", limits.max_compute_invocations_per_workgroup, WORKGROUP_SIZE),
        ("max_compute_workgroup_size_x", limits.max_compute_workgroup_size_x, WORKGROUP_SIZE),
        ("max_compute_workgroups_per_dimension", limits.max_compute_workgroups_per_dimension, 1),
    ]
    .into_iter()
    .find(|(_, has, needs)| has < needs)
    .map(|(limit, has, needs)| {
        format!("the kernels need {limit} of {needs}, and this device has {has}; request it with WebGPU's default limits")
    })
}

/// The largest array that a kernel can address, in bytes.
pub(crate) fn max_binding_bytes(limits: &wgpu::Limits) -> u64 {
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}
