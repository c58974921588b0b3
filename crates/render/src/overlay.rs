//! Dots and lines over a face: markers, handles, strain edges.

use crate::camera::Camera;
use crate::target::Target;
use rhytid_core::{Result, human};

/// A line with round ends, of the same width at any distance. A line without length is a dot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// The two ends, in mesh units.
    pub ends: [[f32; 3]; 2],
    /// Linear red, green and blue, 0 to 1.
    pub colour: [f32; 3],
    /// In pixels.
    pub width: f32,
}

impl Mark {
    /// A dot.
    pub fn dot(at: [f32; 3], colour: [f32; 3], width: f32) -> Self {
        Self { ends: [at; 2], colour, width }
    }
}

/// Floats of a mark: two ends, a colour and a width.
const FLOATS: usize = 10;
/// Words of the uniforms: two matrices, the picture's size in pixels and the lift.
const UNIFORM_WORDS: usize = 16 + 16 + 4;

/// Draws marks over the contents of a pass.
#[derive(Debug)]
pub struct Overlay {
    device: wgpu::Device,
    queue: wgpu::Queue,
    uniforms: wgpu::Buffer,
    group: wgpu::BindGroup,
    pipeline: wgpu::RenderPipeline,
    marks: wgpu::Buffer,
    count: u32,
}

impl Overlay {
    /// For passes that draw into `target`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`] if `device` refuses.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target: Target) -> Result<Self> {
        crate::checked(device, "preparing to draw marks", || {
            let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("marks' view"),
                size: 4 * UNIFORM_WORDS as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let pipeline = pipeline(device, target);
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("marks' view"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() }],
            });
            let marks = buffer(device, 1);
            Self { device: device.clone(), queue: queue.clone(), uniforms, group, pipeline, marks, count: 0 }
        })
    }

    /// Sets the marks of the next pass, seen by `camera` in a picture of `size` pixels. Marks are drawn
    /// `lift` mesh units nearer to the camera than they are. So marks on the skin are not half hidden in it.
    /// Marks farther behind the skin than `lift` are hidden. Later marks are over earlier ones.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if there are too many marks for the device;
    /// [`rhytid_core::Error::Device`], for lack of memory.
    pub fn show(&mut self, camera: &Camera, size: [u32; 2], lift: f32, marks: &[Mark]) -> Result<()> {
        let [width, height] = size.map(|n| n as f32);
        let mut words = Vec::with_capacity(UNIFORM_WORDS);
        words.extend(camera.projection(width / height).to_cols_array());
        words.extend(camera.view().to_cols_array());
        words.extend([width, height, lift, 0.0]);
        self.queue.write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&words));
        if self.marks.size() < (4 * FLOATS * marks.len()) as u64 {
            let count = marks.len().next_power_of_two();
            let what = human::counted(marks.len(), "mark");
            let limits =
                [("max_buffer_size", (4 * FLOATS * count) as u64, self.device.limits().max_buffer_size)];
            crate::allowed(&what, &limits, "draw fewer")?;
            let room = || buffer(&self.device, count);
            self.marks = crate::checked(&self.device, "making room for marks", room)?;
        }
        let floats: Vec<f32> = marks
            .iter()
            .flat_map(|mark| {
                let [a, b] = mark.ends;
                a.into_iter().chain(b).chain(mark.colour).chain([mark.width])
            })
            .collect();
        self.queue.write_buffer(&self.marks, 0, bytemuck::cast_slice(&floats));
        self.count = marks.len() as u32;
        Ok(())
    }

    /// Draws the marks into a pass. Surfaces that may hide them must be drawn before.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_vertex_buffer(0, self.marks.slice(..));
        pass.draw(0..6, 0..self.count);
    }
}

fn buffer(device: &wgpu::Device, marks: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("marks"),
        size: (4 * FLOATS * marks.max(1)) as u64,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn pipeline(device: &wgpu::Device, target: Target) -> wgpu::RenderPipeline {
    let source = wgpu::ShaderSource::Wgsl(include_str!("overlay.wgsl").into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("marks"), source });
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("marks"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("corner"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 4 * FLOATS as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(target.depth_test(false)),
        multisample: target.multisample(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("mark"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: target.color,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
