//! A host application computes on its own device, and draws with the results in their buffers.

use crate::support::{Sizes, expected, frames, rig, tested};
use rhytid_backend_wgpu::{Wgpu, WgpuSession};
use rhytid_core::{Animator, Backend, BasisStorage, DeviceErrorKind, Error, Rig, Stage, UploadOptions};

/// Pixels along a side of the picture.
const SIZE: u32 = 256;
/// Pixels in a unit of the mesh. The sheet's first vertex is at about pixel (64, 64).
const SCALE: f32 = 16.0;
const BORDER: f32 = 64.0;

/// Points at the vertices, in the colours of their normals.
const SHADER: &str = "
struct Point { @builtin(position) at: vec4f, @location(0) color: vec4f }

@vertex fn vertex(@location(0) position: vec3f, @location(1) normal: vec3f) -> Point {
    let pixel = position.xy * 16 + 64;
    return Point(vec4f(pixel.x / 128 - 1, 1 - pixel.y / 128, 0.5, 1), vec4f(normal * 0.5 + 0.5, 1));
}

@fragment fn fragment(point: Point) -> @location(0) vec4f {
    return point.color;
}
";

/// The host's devices, with these limits.
fn host_devices(limits: &wgpu::Limits) -> Vec<(wgpu::Device, wgpu::Queue)> {
    let devices = tested(Wgpu::devices().unwrap());
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let adapters = wgpu::Instance::new(descriptor).enumerate_adapters(wgpu::Backends::all());
    let is_tested = |adapter: &wgpu::Adapter| devices.iter().any(|device| Wgpu::is(adapter, device));
    let adapters = pollster::block_on(adapters).into_iter().filter(is_tested);
    let open = |adapter: wgpu::Adapter| {
        let required_limits = limits.clone();
        let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
        pollster::block_on(adapter.request_device(&descriptor)).unwrap()
    };
    adapters.map(open).collect()
}

#[test]
fn positions_and_normals_are_drawn_from_the_buffers_they_are_in() {
    let sizes = Sizes { vertices: 64, handles: 9, edges: 12, examples: 2, influences: 4 };
    let rig = rig(1, sizes);
    let batch = frames(2, &rig, 3);
    let expected = expected(&rig, &batch, BasisStorage::F32);
    for (device, queue) in host_devices(&wgpu::Limits::default()) {
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let wgpu = Wgpu::from_device(device.clone(), queue.clone()).unwrap();
        let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(3)).unwrap();
        animator.evaluate(&batch).unwrap();
        let pixels = draw(&device, &queue, animator.session(), &rig, 2);
        if let Some(error) = pollster::block_on(scope.pop()) {
            panic!("{error}");
        }

        let of_frame = |stage: Stage| {
            let (numbers, _) = expected[stage as usize].as_chunks::<3>();
            &numbers[2 * rig.vertices()..]
        };
        let mut seen = 0;
        let mut drawn = std::collections::HashMap::new();
        for (x, n) in of_frame(Stage::Positions).iter().zip(of_frame(Stage::Normals)) {
            let at = [x[0] * SCALE + BORDER, x[1] * SCALE + BORDER];
            let inside = at.iter().all(|c| (c - c.floor() - 0.5).abs() < 0.45);
            drawn.entry(at.map(|c| c.floor() as u32)).or_insert_with(Vec::new).push((n, inside));
        }
        for (&[x, y], normals) in &drawn {
            // Vertices on the border of a pixel, or several in one pixel, cannot be told apart, and are left
            // out.
            let [(n, true)] = normals[..] else { continue };
            let color: [u8; 4] = pixels[(y * SIZE + x) as usize];
            for (found, n) in color.iter().zip(n) {
                let expected = (n * 0.5 + 0.5) * 255.0;
                assert!(
                    (f32::from(*found) - expected).abs() <= 1.5,
                    "pixel {x}, {y}: {color:?}, normal {n:?}"
                );
            }
            seen += 1;
        }
        assert!(seen > 40, "only {seen} of 64 vertices are alone in their pixels");
        let lit = pixels.iter().filter(|pixel| pixel[3] != 0).count();
        assert!((seen..=64).contains(&lit), "{lit} pixels were drawn");
    }
}

/// Draws the vertices of one frame. The result has rows of RGBA from the top.
fn draw(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    session: &WgpuSession,
    rig: &Rig,
    frame: usize,
) -> Vec<[u8; 4]> {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let size = wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let source = wgpu::ShaderSource::Wgsl(SHADER.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let attribute = |shader_location| {
        [wgpu::VertexAttribute { format: wgpu::VertexFormat::Float32x3, offset: 0, shader_location }]
    };
    let attributes = [attribute(0), attribute(1)];
    let layouts = attributes.each_ref().map(|attributes| {
        Some(wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        })
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &layouts,
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::PointList,
            ..Default::default()
        },
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let picture = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE * SIZE * 4),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });

    let mut encoder = device.create_command_encoder(&Default::default());
    let view = texture.create_view(&Default::default());
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    let frame_bytes = rig.vertices() as u64 * 12;
    for (slot, stage) in [Stage::Positions, Stage::Normals].into_iter().enumerate() {
        let (frames, buffer) = session.results(stage).find(|(frames, _)| frames.contains(&frame)).unwrap();
        let first = (frame - frames.start) as u64 * frame_bytes;
        pass.set_vertex_buffer(slot as u32, buffer.slice(first..first + frame_bytes));
    }
    pass.draw(0..rig.vertices() as u32, 0..1);
    drop(pass);
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE * 4), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &picture, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
    queue.submit([encoder.finish()]);
    picture.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let pixels = picture.get_mapped_range(..).unwrap();
    pixels.as_chunks::<4>().0.to_vec()
}

#[test]
fn a_limit_that_is_too_low_is_named() {
    for (device, queue) in host_devices(&wgpu::Limits::downlevel_defaults()) {
        let error = Wgpu::from_device(device, queue).unwrap_err();
        assert!(matches!(error, Error::Device { kind: DeviceErrorKind::Unsupported, .. }), "{error}");
        assert!(error.to_string().contains("max_storage_buffers_per_shader_stage"), "{error}");
    }
}

#[test]
fn a_device_can_be_requested_without_naming_it() {
    if tested(Wgpu::devices().unwrap()).is_empty() {
        let error = pollster::block_on(Wgpu::request()).unwrap_err();
        assert!(matches!(error, Error::Device { kind: DeviceErrorKind::NotFound, .. }), "{error}");
        return;
    }
    let wgpu = pollster::block_on(Wgpu::request()).unwrap();
    let rig = rig(3, Sizes { vertices: 64, handles: 9, edges: 12, examples: 2, influences: 4 });
    let positions = frames(4, &rig, 2);
    let mut animator = Animator::new(&wgpu, &rig, UploadOptions::frames(2)).unwrap();
    animator.evaluate(&positions).unwrap();
    let mut found = Vec::new();
    pollster::block_on(animator.session_mut().read_async(Stage::Positions, &mut found)).unwrap();
    let expected = &expected(&rig, &positions, BasisStorage::F32)[Stage::Positions as usize];
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 2e-5 * (1.0 + b.abs())));
}
