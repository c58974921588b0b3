//! The light that reaches each vertex. The mesh is drawn as the key light and the directions of the sky see
//! it.

use super::compute::{self, Bind};
use super::pieces::Pieces;
use crate::camera::Sphere;
use glam::{Mat4, Vec3, Vec4};
use rhytid_core::Result;

/// Words of a direction's uniforms.
const DIRECTION_WORDS: usize = 28;
/// Texels of a side of the key light's map, and of the sky's.
pub(super) const SIDES: [u32; 2] = [2048, 512];
/// The number of directions of the sky.
pub(super) const SKY: usize = 32;
/// The factor by which a moving mesh may exceed its ball at rest.
const ROOM: f32 = 1.15;

/// Finds the part of light that reaches each vertex of a frame.
#[derive(Debug)]
pub(crate) struct Visibility {
    queue: wgpu::Queue,
    directions: wgpu::Buffer,
    stride: u32,
    layout: wgpu::BindGroupLayout,
    casting: wgpu::BindGroup,
    caster: wgpu::RenderPipeline,
    begin: wgpu::ComputePipeline,
    look: wgpu::ComputePipeline,
    /// The maps of the key light and of the sky: distances, and the depths for depth tests.
    maps: [[wgpu::TextureView; 2]; 2],
    sphere: Sphere,
    /// V × 4, as described in `visibility.wgsl`.
    pub seen: wgpu::Buffer,
}

/// The arrays of a frame on the device.
pub(super) struct Arrays<'a> {
    pub uniforms: wgpu::BindingResource<'a>,
    pub positions: wgpu::BindingResource<'a>,
    pub normals: wgpu::BindingResource<'a>,
    pub corners: wgpu::BufferSlice<'a>,
}

/// The key light, in the mesh's space.
#[derive(Clone, Copy)]
pub(super) struct KeyLight {
    /// The direction to the light.
    pub toward: Vec3,
    /// The width of the soft edge of its shadows, in mesh units.
    pub penumbra: f32,
}

/// A direction of the sky, in the mesh's space.
#[derive(Clone, Copy)]
pub(super) struct SkyLight {
    /// The direction to the light.
    pub toward: Vec3,
    /// The luminance from this direction.
    pub brings: f32,
}

impl Visibility {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rest: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Self> {
        let spacings: Vec<[f32; 4]> =
            spacings(rest, triangles).into_iter().map(|spacing| [0.0, 0.0, 1.0, spacing]).collect();
        crate::checked(device, "preparing shadows", || {
            let alignment = device.limits().min_uniform_buffer_offset_alignment;
            let stride = (4 * DIRECTION_WORDS as u32).next_multiple_of(alignment);
            let directions = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("directions"),
                size: u64::from(stride) * (SKY + 1) as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let direction = || Bind::Uniform { words: DIRECTION_WORDS, dynamic: true };
            let layout = compute::layout(
                device,
                &[
                    direction(),
                    Bind::Uniform { words: super::FRAME_WORDS, dynamic: false },
                    Bind::Texture,
                    compute::read(),
                    compute::read(),
                    compute::write(),
                ],
            );
            let casting_layout = compute::layout(device, &[direction()]);
            let source = include_str!("visibility.wgsl");
            let map = |side| {
                let texture = |format, usage| {
                    let texture = device.create_texture(&wgpu::TextureDescriptor {
                        label: Some("distances from a light"),
                        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
                        mip_level_count: 1,
                        sample_count: 1,
                        dimension: wgpu::TextureDimension::D2,
                        format,
                        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                        view_formats: &[],
                    });
                    texture.create_view(&wgpu::TextureViewDescriptor::default())
                };
                [
                    texture(wgpu::TextureFormat::R32Uint, wgpu::TextureUsages::TEXTURE_BINDING),
                    texture(wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::empty()),
                ]
            };
            let around = Sphere::around(rest);
            let seen = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("what is seen of light"),
                size: 16 * rest.len().max(1) as u64,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_SRC
                    | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&seen, 0, bytemuck::cast_slice(&spacings));
            Self {
                queue: queue.clone(),
                casting: compute::group(device, &casting_layout, [direction_of(&directions)]),
                directions,
                stride,
                caster: caster(device, &casting_layout, source),
                begin: compute::pipeline(device, &layout, "begin", source),
                look: compute::pipeline(device, &layout, "look", source),
                layout,
                maps: SIDES.map(map),
                sphere: Sphere { radius: ROOM * around.radius, ..around },
                seen,
            }
        })
    }

    /// Finds the part of light that reaches each vertex, for the `key` light and the `sky`. Each light is a
    /// piece of the work.
    ///
    /// # Errors
    /// As the pieces' `next`.
    pub(super) fn run(
        &self,
        device: &wgpu::Device,
        pieces: &mut Pieces<'_>,
        arrays: &Arrays<'_>,
        triangles: &wgpu::Buffer,
        key: KeyLight,
        sky: &[SkyLight],
    ) -> Result<()> {
        let vertices = (arrays.corners.size() / 12) as u32;
        let mut bytes = Vec::with_capacity(self.stride as usize * (sky.len() + 1));
        bytes.extend_from_slice(bytemuck::bytes_of(&self.direction(key.toward, 0.0, Some(key.penumbra))));
        for (i, light) in (1..).zip(sky) {
            bytes.resize(self.stride as usize * i, 0);
            bytes.extend_from_slice(bytemuck::bytes_of(&self.direction(light.toward, light.brings, None)));
        }
        self.queue.write_buffer(&self.directions, 0, &bytes);
        let groups = self.maps.each_ref().map(|[map, _]| {
            compute::group(
                device,
                &self.layout,
                [
                    direction_of(&self.directions),
                    arrays.uniforms.clone(),
                    wgpu::BindingResource::TextureView(map),
                    arrays.positions.clone(),
                    arrays.normals.clone(),
                    self.seen.as_entire_binding(),
                ],
            )
        });
        let compute = |encoder: &mut wgpu::CommandEncoder, pipeline, map: usize, offset| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &groups[map], &[offset]);
            compute::dispatch(&mut pass, vertices);
        };
        compute(pieces.encoder(), &self.begin, 0, 0);
        for i in 0..=sky.len() as u32 {
            let (map, offset) = (usize::from(i > 0), i * self.stride);
            self.cast(pieces.encoder(), map, offset, arrays.corners, triangles);
            compute(pieces.encoder(), &self.look, map, offset);
            pieces.next()?;
        }
        Ok(())
    }

    fn cast(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        map: usize,
        offset: u32,
        corners: wgpu::BufferSlice<'_>,
        triangles: &wgpu::Buffer,
    ) {
        let [distances, depth] = &self.maps[map];
        let far = wgpu::Color { r: f64::from(f32::MAX.to_bits()), ..wgpu::Color::TRANSPARENT };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: distances,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(far), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.caster);
        pass.set_bind_group(0, &self.casting, &[offset]);
        pass.set_vertex_buffer(0, corners);
        pass.set_index_buffer(triangles.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..(triangles.size() / 4) as u32, 0, 0..1);
    }

    /// The uniforms of a direction. Only the key light has a `penumbra`.
    fn direction(&self, toward: Vec3, brings: f32, penumbra: Option<f32>) -> [f32; DIRECTION_WORDS] {
        let side = SIDES[usize::from(penumbra.is_none())] as f32;
        let (r, center) = (self.sphere.radius, Vec3::from_array(self.sphere.center));
        let (right, down) = toward.any_orthonormal_pair();
        let texel = 2.0 * r / side;
        let row =
            |axis: Vec3, scale: f32, middle: f32| (scale * axis).extend(middle - scale * axis.dot(center));
        let map_from_mesh = Mat4::from_cols(
            row(right, 1.0 / texel, 0.5 * side),
            row(down, 1.0 / texel, 0.5 * side),
            row(-toward, 1.0, r),
            Vec4::W,
        )
        .transpose();
        let mut words = [0.0; DIRECTION_WORDS];
        words[..16].copy_from_slice(&map_from_mesh.to_cols_array());
        words[16..20].copy_from_slice(&toward.extend(brings).to_array());
        // A filter is at least about a texel wide. This also covers the error of a surface that bends between
        // its vertices.
        let radius = penumbra.map_or(1.5, |penumbra| (penumbra / texel).clamp(1.5, 16.0));
        words[20..24].copy_from_slice(&[side, radius, texel, 2.0 * r]);
        words[24] = f32::from_bits(u32::from(penumbra.is_some()));
        words
    }
}

/// The mean length of the edges at each vertex.
fn spacings(rest: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let mut sums = vec![(0.0, 0.0_f32); rest.len()];
    for triangle in triangles {
        for i in 0..3 {
            let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(|v| v as usize);
            let length = Vec3::from_array(rest[a]).distance(Vec3::from_array(rest[b]));
            for v in [a, b] {
                sums[v] = (sums[v].0 + length, sums[v].1 + 1.0);
            }
        }
    }
    sums.into_iter().map(|(sum, count)| sum / count.max(1.0)).collect()
}

fn direction_of(directions: &wgpu::Buffer) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: directions,
        offset: 0,
        size: wgpu::BufferSize::new(4 * DIRECTION_WORDS as u64),
    })
}

fn caster(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, source: &str) -> wgpu::RenderPipeline {
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("shadows"), source });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("shadows"),
        layout: Some(&compute::pipeline_layout(device, layout)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("caster"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("nearest"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::TextureFormat::R32Uint.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
