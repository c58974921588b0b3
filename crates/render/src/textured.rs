//! A mesh in the colours of images.

use crate::image::Images;
use crate::look::SKIN;
use crate::picture::{Picture, to_srgb};
use crate::target::Target;
use crate::vertices::Vertices;
use bytemuck::{Pod, Zeroable};
use rhytid_core::{Error, Faces, Materials, Result, Uvs};
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::ops::Range;
use std::sync::Arc;

/// The images of a mesh, and the places of its corners on them.
#[derive(Debug, Clone, Copy)]
pub struct Surface<'a> {
    /// The polygons.
    pub faces: &'a Faces,
    /// Their triangles, as a rig has them.
    pub triangles: &'a [[u32; 3]],
    /// The place of each corner on its image.
    pub uvs: &'a Uvs,
    /// The material of each face, if there are materials.
    pub materials: Option<&'a Materials>,
    /// An image for each material. Without materials, one image for all faces. An image with opacities below
    /// 255 is drawn over all others, so that what is behind it is seen through it. Faces without an image
    /// have the colour of [`crate::Look::Smooth`].
    pub images: &'a [Option<Arc<Picture>>],
}

/// A corner as the shader reads it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Corner {
    vertex: u32,
    uv: [f32; 2],
}

impl Surface<'_> {
    /// The corners of the triangles of each image. The last list is of triangles without an image.
    ///
    /// # Errors
    /// [`Error::Input`] if the parts do not belong together.
    pub(crate) fn corners(&self) -> Result<Vec<Vec<Corner>>> {
        let vertices = self.triangles.as_flattened().iter().max().map_or(0, |last| *last as usize + 1);
        let fault = |what: &str| Error::mismatch(format!("the textures of a mesh: {what}"));
        let corners = self.faces.triangle_corners(self.triangles);
        let corners = corners.ok_or_else(|| fault("its triangles are not those of its faces"))?;
        let count = match &self.uvs.corners {
            Some(named) => named.len().min(self.faces.indices.len()),
            None => self.uvs.values.len().min(vertices),
        };
        let expected = if self.uvs.corners.is_some() { self.faces.indices.len() } else { vertices };
        if count < expected {
            return Err(fault("it has fewer texture coordinates than corners"));
        }
        let none = self.images.len();
        let image_of = |face: usize| match self.materials {
            Some(materials) => {
                materials.of_face.get(face).map_or(none, |material| *material as usize).min(none)
            }
            None => 0,
        };
        let mut of_images = vec![Vec::new(); none + 1];
        let faces = self.faces.counts.iter().enumerate();
        let of_triangles =
            faces.flat_map(|(face, count)| std::iter::repeat_n(image_of(face), *count as usize - 2));
        for ((triangle, corners), image) in self.triangles.iter().zip(&corners).zip(of_triangles) {
            for (&vertex, &corner) in triangle.iter().zip(corners) {
                let at = self.uvs.corners.as_ref().map_or(vertex, |named| named[corner as usize]);
                let uv = *self
                    .uvs
                    .values
                    .get(at as usize)
                    .ok_or_else(|| fault("a corner has no texture coordinate"))?;
                of_images[image].push(Corner { vertex, uv });
            }
        }
        Ok(of_images)
    }
}

/// The triangles of an image.
#[derive(Debug)]
struct Drawn {
    corners: Range<u32>,
    image: wgpu::BindGroup,
    is_opaque: bool,
}

/// Draws a mesh with its images.
#[derive(Debug)]
pub(crate) struct Textured {
    pipeline: wgpu::RenderPipeline,
    /// For what is not opaque.
    clear: wgpu::RenderPipeline,
    frame: wgpu::BindGroupLayout,
    corners: wgpu::Buffer,
    images: Vec<Drawn>,
}

impl Textured {
    /// `layouts` are those of the view and of an image. `corners` has a list for each image, and one for
    /// triangles without an image.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        [view, image]: [&wgpu::BindGroupLayout; 2],
        target: Target,
        pictures: &[Option<Arc<Picture>>],
        images: &Images,
        of_images: Vec<Vec<Corner>>,
    ) -> Self {
        let storage = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: true },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let frame = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[storage(0), storage(1)],
        });
        let skin = Picture::filled([1, 1], [to_srgb(SKIN[0]), to_srgb(SKIN[1]), to_srgb(SKIN[2]), 255]);
        let mut first = 0;
        let mut groups = Vec::new();
        // A picture of many materials is on the device once.
        let mut known: HashMap<*const Picture, wgpu::BindGroup> = HashMap::new();
        for (i, corners) in of_images.iter().enumerate().filter(|(_, corners)| !corners.is_empty()) {
            let picture = pictures.get(i).and_then(Option::as_deref).unwrap_or(&skin);
            let range = first..first + corners.len() as u32;
            first = range.end;
            let group = known.entry(picture).or_insert_with(|| images.group(device, queue, picture));
            groups.push(Drawn { corners: range, image: group.clone(), is_opaque: picture.is_opaque() });
        }
        let corners = of_images.concat();
        let contents: &[u8] = bytemuck::cast_slice(&corners);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("corners"),
            size: contents.len().max(4) as u64,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, contents);
        let layouts = [view, image, &frame];
        Self {
            pipeline: pipeline(device, &layouts, target, true),
            clear: pipeline(device, &layouts, target, false),
            frame,
            corners: buffer,
            images: groups,
        }
    }

    /// Draws a frame. The view must be set.
    pub(crate) fn draw(
        &self,
        device: &wgpu::Device,
        pass: &mut wgpu::RenderPass<'_>,
        vertices: Vertices<'_>,
    ) {
        let frame = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.frame,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: storage(vertices.positions) },
                wgpu::BindGroupEntry { binding: 1, resource: storage(vertices.normals) },
            ],
        });
        // What is clear comes last, over all that is seen through it.
        for (pipeline, is_opaque) in [(&self.pipeline, true), (&self.clear, false)] {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(2, &frame, &[]);
            pass.set_vertex_buffer(0, self.corners.slice(..));
            for drawn in self.images.iter().filter(|drawn| drawn.is_opaque == is_opaque) {
                pass.set_bind_group(1, &drawn.image, &[]);
                pass.draw(drawn.corners.clone(), 0..1);
            }
        }
    }
}

fn storage(slice: wgpu::BufferSlice<'_>) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
        buffer: slice.buffer(),
        offset: slice.offset(),
        size: NonZeroU64::new(slice.size()),
    })
}

fn pipeline(
    device: &wgpu::Device,
    groups: &[&wgpu::BindGroupLayout; 3],
    target: Target,
    is_opaque: bool,
) -> wgpu::RenderPipeline {
    let source = [include_str!("shader.wgsl"), include_str!("textured.wgsl")].concat();
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let module =
        device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("textured"), source });
    let attribute =
        |format, offset, shader_location| wgpu::VertexAttribute { format, offset, shader_location };
    let buffers = [Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Corner>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &[
            attribute(wgpu::VertexFormat::Uint32, 0, 0),
            attribute(wgpu::VertexFormat::Float32x2, 4, 1),
        ],
    })];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("textured"),
        layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("textured"),
            bind_group_layouts: &groups.map(Some),
            immediate_size: 0,
        })),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("textured_corner"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(target.depth_test(is_opaque)),
        multisample: target.multisample(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(if is_opaque { "textured" } else { "clear" }),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: target.color,
                blend: (!is_opaque).then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
