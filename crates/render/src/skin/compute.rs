//! The few calls that make and run a kernel of the renderer.

/// What a kernel reads and writes.
pub(super) enum Bind {
    Uniform {
        words: usize,
        dynamic: bool,
    },
    Storage {
        writes: bool,
    },
    /// A texture of whole numbers.
    Texture,
}

pub(super) fn read() -> Bind {
    Bind::Storage { writes: false }
}

pub(super) fn write() -> Bind {
    Bind::Storage { writes: true }
}

pub(super) fn layout(device: &wgpu::Device, binds: &[Bind]) -> wgpu::BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = (0..)
        .zip(binds)
        .map(|(binding, bind)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE | vertex(bind),
            ty: match *bind {
                Bind::Uniform { words, dynamic } => wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: dynamic,
                    min_binding_size: wgpu::BufferSize::new(4 * words as u64),
                },
                Bind::Storage { writes } => wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: !writes },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                Bind::Texture => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

/// Passes that draw use the uniforms too.
fn vertex(bind: &Bind) -> wgpu::ShaderStages {
    match bind {
        Bind::Uniform { .. } => wgpu::ShaderStages::VERTEX_FRAGMENT,
        Bind::Storage { .. } | Bind::Texture => wgpu::ShaderStages::NONE,
    }
}

pub(super) fn group<const N: usize>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: [wgpu::BindingResource<'_>; N],
) -> wgpu::BindGroup {
    let mut binding = 0..;
    let entries =
        resources.map(|resource| wgpu::BindGroupEntry { binding: binding.next().unwrap_or(0), resource });
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

pub(super) fn pipeline_layout(device: &wgpu::Device, layout: &wgpu::BindGroupLayout) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    })
}

pub(super) fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    entry: &str,
    source: &str,
) -> wgpu::ComputePipeline {
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(entry), source });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&pipeline_layout(device, layout)),
        module: &module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}

/// Runs `count` invocations in workgroups of 64. The workgroups are in rows, since a dispatch has at most
/// 65,535 of them along each axis.
pub(super) fn dispatch(pass: &mut wgpu::ComputePass<'_>, count: u32) {
    let groups = count.div_ceil(64);
    let rows = groups.div_ceil(65_535).max(1);
    pass.dispatch_workgroups(groups.div_ceil(rows).max(1), rows, 1);
}
