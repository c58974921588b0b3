//! A renderer with a wgpu device of its own: the face is computed and drawn on the same device, and its
//! vertices never cross to the host. Writes a picture.
//!
//! ```sh
//! cargo run --release -p rhytid-examples --example 104_own_renderer -- face.png
//! ```
use rhytid::devices::wgpu::{Wgpu, WgpuSession};
use rhytid::solve::solve;
use rhytid::{Animator, NoProgress, Rig, Stage, UploadOptions};
use std::error::Error;
use std::path::PathBuf;

/// Pixels on a side of the picture.
const SIZE: u32 = 768;

const SHADER: &str = "
struct Camera { center: vec4f, scale: f32 }
struct Corner { @builtin(position) at: vec4f, @location(0) normal: vec3f }

@group(0) @binding(0) var<uniform> camera: Camera;

@vertex fn vertex(@location(0) position: vec3f, @location(1) normal: vec3f) -> Corner {
    let p = (position - camera.center.xyz) * camera.scale;
    return Corner(vec4f(p.xy, 0.5 - 0.25 * p.z, 1), normal);
}

@fragment fn fragment(corner: Corner) -> @location(0) vec4f {
    let light = normalize(vec3f(-0.5, 0.6, 0.8));
    let lit = 0.15 + 0.85 * max(dot(normalize(corner.normal), light), 0.0);
    return vec4f(vec3f(0.86, 0.66, 0.55) * lit, 1);
}
";

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("face.png"), PathBuf::from);
    let face = rhytid_demo::face(60_000);
    let take = rhytid_demo::performance(&face);
    let rig = solve(&face, &NoProgress)?.rounded()?;
    let handles = take.handle_positions(&rig.handles().labels)?;

    // A renderer has these already. WebGPU's default limits are enough.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;

    let rhytid = Wgpu::from_device(device.clone(), queue.clone())?;
    let mut animator = Animator::new(&rhytid, &rig, UploadOptions::frames(1))?;

    // Once a frame: send the markers, then draw from the buffers that hold the results.
    let frame = take.frames() / 3;
    let mut frames = handles.chunks_exact(3 * rig.handles().len());
    animator.evaluate(frames.nth(frame).ok_or("the take is empty")?)?;
    let pixels = draw(&device, &queue, animator.session(), &rig)?;

    let mut png = png::Encoder::new(std::fs::File::create(&path)?, SIZE, SIZE);
    png.set_color(png::ColorType::Rgba);
    png.write_header()?.write_image_data(&pixels)?;
    println!(
        "{}: frame {frame} of {} vertices, drawn on {}",
        path.display(),
        rig.vertices(),
        adapter.get_info().name
    );
    Ok(())
}

/// The first frame of the last batch as rows of RGBA.
fn draw(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    session: &WgpuSession,
    rig: &Rig,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let buffer = |contents: &[u8], usage| {
        let size = contents.len() as u64;
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let buffer = device.create_buffer(&descriptor);
        queue.write_buffer(&buffer, 0, contents);
        buffer
    };
    let copied = wgpu::BufferUsages::COPY_DST;
    let indices = bytemuck::cast_slice(&rig.surface().triangles);
    let indices = buffer(indices, wgpu::BufferUsages::INDEX | copied);
    let camera = buffer(bytemuck::cast_slice(&camera(rig)), wgpu::BufferUsages::UNIFORM | copied);

    let color = target(device, wgpu::TextureFormat::Rgba8UnormSrgb, wgpu::TextureUsages::COPY_SRC);
    let depth = target(device, wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::empty());
    let pipeline = pipeline(device, color.format(), depth.format());
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: camera.as_entire_binding() }],
    });

    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
    let (color_view, depth_view) = (view(&color), view(&depth));
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &color_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color { r: 0.02, g: 0.02, b: 0.03, a: 1.0 }),
                store: wgpu::StoreOp::Store,
            },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(1.0),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    for (slot, stage) in [Stage::Positions, Stage::Normals].into_iter().enumerate() {
        let (_, results) = session.results(stage).next().ok_or("nothing was evaluated")?;
        pass.set_vertex_buffer(slot as u32, results.slice(..));
    }
    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
    pass.draw_indexed(0..rig.surface().triangles.len() as u32 * 3, 0, 0..1);
    drop(pass);
    read(device, queue, encoder, &color)
}

const EXTENT: wgpu::Extent3d = wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 };

/// A texture of the picture's size to draw into.
fn target(device: &wgpu::Device, format: wgpu::TextureFormat, usage: wgpu::TextureUsages) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: EXTENT,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}

/// Submits what `encoder` has, waits for it, and reads a texture as rows of RGBA.
fn read(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mut encoder: wgpu::CommandEncoder,
    color: &wgpu::Texture,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let picture = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE * SIZE * 4),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE * 4), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &picture, layout };
    encoder.copy_texture_to_buffer(color.as_image_copy(), to, EXTENT);
    queue.submit([encoder.finish()]);
    picture.map_async(wgpu::MapMode::Read, .., |_| ());
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(picture.get_mapped_range(..)?.to_vec())
}

/// The middle of the rest pose and the scale that makes it fill the picture, in the shader's layout.
fn camera(rig: &Rig) -> [f32; 8] {
    let bound = |c: usize, pick: fn(f32, f32) -> f32| {
        rig.surface().rest.iter().map(|p| p[c]).reduce(pick).unwrap_or(0.0)
    };
    let low: [f32; 3] = std::array::from_fn(|c| bound(c, f32::min));
    let high: [f32; 3] = std::array::from_fn(|c| bound(c, f32::max));
    let [x, y, z] = std::array::from_fn(|c| (low[c] + high[c]) / 2.0);
    let size = (0..3).map(|c| high[c] - low[c]).fold(0.0, f32::max);
    [x, y, z, 0.0, 1.9 / size, 0.0, 0.0, 0.0]
}

fn pipeline(
    device: &wgpu::Device,
    color: wgpu::TextureFormat,
    depth: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let source = wgpu::ShaderSource::Wgsl(SHADER.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    // Positions and normals as Rhytid writes them: three floats a vertex, nothing between.
    let attribute = |shader_location| {
        [wgpu::VertexAttribute { format: wgpu::VertexFormat::Float32x3, offset: 0, shader_location }]
    };
    let attributes = [attribute(0), attribute(1)];
    let buffers = attributes.each_ref().map(|attributes| {
        Some(wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        })
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: depth,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(color.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
