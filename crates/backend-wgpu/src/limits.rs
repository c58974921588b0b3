//! The limits of wgpu: those with which a device is opened, and those that the kernels need.
use rhytid_kernels::table::{Kernel, WORKGROUP_SIZE};

/// WebGPU's default limits, or less where the adapter has less. In a browser, arrays may be as large as the
/// adapter allows, since browsers have tested that.
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

/// Whether the kernels can be compiled for an adapter.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn has_compute_shaders(adapter: &wgpu::Adapter) -> bool {
    let info = adapter.get_info();
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
        && (info.backend != wgpu::Backend::Gl || opengl_has_compute_shaders(&info.driver_info))
}

/// Whether the shading language of an OpenGL `version` has compute shaders. OpenGL has them from 4.3 on,
/// OpenGL ES from 3.1 on. An older OpenGL may have them by an extension. wgpu accepts that, but cannot
/// compile shaders for it.
#[cfg(not(target_arch = "wasm32"))]
fn opengl_has_compute_shaders(version: &str) -> bool {
    let (number, first) = match version.strip_prefix("OpenGL ES ") {
        Some(number) => (number, (3, 1)),
        None => (version, (4, 3)),
    };
    let mut numbers = number.split(|c: char| !c.is_ascii_digit()).map(str::parse::<u32>);
    match (numbers.next(), numbers.next()) {
        (Some(Ok(major)), Some(Ok(minor))) => (major, minor) >= first,
        _ => true,
    }
}

/// The first limit that is too low for the kernels, if any.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Versions as drivers report them. An H100's OpenGL has compute shaders as an extension.
    #[test]
    fn an_opengl_too_old_for_compute_shaders_is_known_by_its_version() {
        for (version, expected) in [
            ("3.3.0 NVIDIA 580.159.04", false),
            ("4.2.13 Compatibility Profile", false),
            ("OpenGL ES 3.0 Mesa 22.3.6", false),
            ("4.5 (Core Profile) Mesa 22.3.6", true),
            ("4.6.0 NVIDIA 580.159.04", true),
            ("OpenGL ES 3.1 Mesa 22.3.6", true),
            ("OpenGL ES 3.2 NVIDIA 580.159.04", true),
            ("no number", true),
        ] {
            assert_eq!(opengl_has_compute_shaders(version), expected, "{version}");
        }
    }
}
