//! Drawing a mesh's buffers into a render pass.

use crate::camera::Camera;
use crate::heat::Heat;
use crate::image::Images;
use crate::look::{Look, SKIN, WIRE};
use crate::picture::Picture;
use crate::posed::Posed;
use crate::target::Target;
use crate::textured::{Surface, Textured};
use crate::vertices::Vertices;
use rhytid_core::{Error, Faces, Result, Rig, human};
use std::num::NonZeroU64;

/// Words of the uniforms: two matrices, a colour, a range and a table of colours.
const UNIFORM_WORDS: usize = 16 + 16 + 4 + 4 + 4 * crate::heat::COLOURS;

/// Draws one mesh.
#[derive(Debug)]
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    target: Target,
    uniforms: wgpu::Buffer,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    images: Images,
    matcap: wgpu::BindGroup,
    textured: Option<Textured>,
    posed: Option<Posed>,
    /// Smooth, Gouraud, flat, the surface behind a wireframe, heat, lit heat, wire, matcap.
    pipelines: [wgpu::RenderPipeline; 8],
    triangles: wgpu::Buffer,
    edges: wgpu::Buffer,
    /// The look that [`Renderer::draw`] draws.
    look: Look,
}

impl Renderer {
    /// For passes that draw a mesh into `target`. The mesh has the polygons `faces`, whose edges are the
    /// wires, and their `triangles`, as in a rig.
    ///
    /// # Errors
    /// [`Error::Input`] if the mesh is too large for `device`; [`Error::Device`] if the device refuses, such
    /// as for lack of memory.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        faces: &Faces,
        triangles: &[[u32; 3]],
        target: Target,
    ) -> Result<Self> {
        let (triangles, edges) = (bytemuck::cast_slice(triangles), edges(faces));
        let edges: &[u8] = bytemuck::cast_slice(&edges);
        let (needed, most) = (triangles.len().max(edges.len()), device.limits().max_buffer_size);
        let what = format!("a mesh of {}", human::counted(faces.len(), "face"));
        crate::allowed(&what, &[("max_buffer_size", needed as u64, most)], crate::FEWER)?;
        crate::checked(device, "preparing to draw", || {
            let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("view"),
                size: 4 * UNIFORM_WORDS as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("view"),
                entries: &[wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: NonZeroU64::new(4 * UNIFORM_WORDS as u64),
                    },
                    count: None,
                }],
            });
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("view"),
                layout: &layout,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniforms.as_entire_binding() }],
            });
            let indices = |label, contents: &[u8]| {
                let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: contents.len().max(4) as u64,
                    usage: wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                queue.write_buffer(&buffer, 0, contents);
                buffer
            };
            let images = Images::new(device);
            Self {
                device: device.clone(),
                queue: queue.clone(),
                target,
                uniforms,
                group,
                matcap: images.group(device, queue, &Picture::clay()),
                textured: None,
                posed: None,
                pipelines: pipelines(device, &layout, &images.layout, target),
                images,
                layout,
                triangles: indices("triangles", triangles),
                edges: indices("edges", edges),
                look: Look::Smooth,
            }
        })
    }

    /// Sets the ball for [`Look::Matcap`]. The ball must fill the picture.
    ///
    /// # Errors
    /// [`Error::Input`] if the picture is too large for the device; [`Error::Device`], such as for lack of
    /// memory.
    pub fn set_matcap(&mut self, ball: &Picture) -> Result<()> {
        self.takes(ball)?;
        let group = || self.images.group(&self.device, &self.queue, ball);
        self.matcap = crate::checked(&self.device, "taking a matcap", group)?;
        Ok(())
    }

    /// Sets the images for [`Look::Textured`], on the mesh that the renderer was made for.
    ///
    /// # Errors
    /// [`Error::Input`] if the parts of the surface do not belong to one mesh, or an image is too large for
    /// the device. Gives [`Error::Device`] if the device refuses, such as for lack of memory, or if its
    /// vertex shaders cannot read storage buffers.
    pub fn set_textures(&mut self, surface: Surface<'_>) -> Result<()> {
        surface.images.iter().flatten().try_for_each(|image| self.takes(image))?;
        let corners = surface.corners()?;
        let textured = || {
            let layouts = [&self.layout, &self.images.layout];
            Textured::new(
                &self.device,
                &self.queue,
                layouts,
                self.target,
                surface.images,
                &self.images,
                corners,
            )
        };
        self.textured = Some(crate::checked(&self.device, "taking textures", textured)?);
        Ok(())
    }

    /// Takes a rig that [`Renderer::draw_posed`] evaluates while it draws. It is the rig of the mesh that the
    /// renderer was made for.
    ///
    /// The rig is kept in textures, with its basis in clusters. So it also runs on a device without compute
    /// shaders and without storage buffers. The limits of WebGL 2 are enough.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig has another number of triangles than the mesh, if its wrinkles are not
    /// functions of vector strains, or if it is too large for the device. [`Error::Device`], such as for lack
    /// of memory.
    pub fn set_rig(&mut self, rig: &Rig) -> Result<()> {
        let triangles = &rig.surface().triangles;
        if size_of_val(&triangles[..]) as u64 != self.triangles.size() {
            return Err(Error::mismatch(format!(
                "a rig of {}, where the renderer was made for a mesh of {}",
                human::counted(triangles.len(), "triangle"),
                human::count(self.triangles.size() as usize / size_of::<[u32; 3]>())
            )));
        }
        self.posed = Some(Posed::new(&self.device, &self.queue, &self.layout, self.target, rig)?);
        Ok(())
    }

    /// The bytes of the rig's textures, where there is a rig.
    pub fn rig_bytes(&self) -> Option<u64> {
        self.posed.as_ref().map(Posed::bytes)
    }

    /// Sends a frame of the rig: the positions of its H handles, 3 numbers each.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no rig, if the number of positions is another, or if one is not finite.
    pub fn pose(&mut self, handle_positions: &[f32]) -> Result<()> {
        let posed = self.posed.as_mut().ok_or_else(no_rig)?;
        posed.send(handle_positions)
    }

    /// Computes all vertices of the frame that was sent, in a pass of its own. [`Look::Smooth`] needs this,
    /// since a normal needs the vertices around its vertex.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no rig. [`Error::Device`].
    pub fn place(&mut self) -> Result<()> {
        let posed = self.posed.as_mut().ok_or_else(no_rig)?;
        crate::checked(&self.device, "placing the vertices", || posed.place())
    }

    /// The V positions that [`Renderer::place`] computed last. Waits for them.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no rig. [`Error::Device`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_placed(&self) -> Result<Vec<[f32; 3]>> {
        pollster::block_on(self.read_placed_async()?)
    }

    /// [`Renderer::read_placed`] for browsers, which do not allow waiting. Elsewhere it waits within the
    /// first poll.
    ///
    /// # Errors
    /// As [`Renderer::read_placed`].
    pub fn read_placed_async(&self) -> Result<impl Future<Output = Result<Vec<[f32; 3]>>> + use<>> {
        self.posed()?.read_positions()
    }

    /// Draws the frame of the rig that was sent last into a pass, as [`Renderer::draw`] does. For
    /// [`Look::Flat`] the vertex shader evaluates the rig. For [`Look::Smooth`] it takes the vertices that
    /// [`Renderer::place`] computed, and computes their normals.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no rig, if the vertices are not placed for a smooth look, or if the look
    /// is another one.
    pub fn draw_posed(&self, pass: &mut wgpu::RenderPass<'_>) -> Result<()> {
        let posed = self.posed()?;
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_index_buffer(self.triangles.slice(..), wgpu::IndexFormat::Uint32);
        let indices = (self.triangles.size() / 4) as u32;
        match self.look {
            Look::Smooth if posed.is_placed() => posed.draw_smooth(pass, indices),
            Look::Smooth => {
                return Err(Error::empty("a smooth frame is to be drawn, and its vertices were not placed"));
            }
            Look::Flat => posed.draw_flat(pass, indices),
            _ => {
                return Err(Error::mismatch(
                    "a rig in textures is drawn smooth or flat, not in another look",
                ));
            }
        }
        Ok(())
    }

    fn posed(&self) -> Result<&Posed> {
        self.posed.as_ref().ok_or_else(no_rig)
    }

    /// Whether the device has textures as large as `image`.
    fn takes(&self, image: &Picture) -> Result<()> {
        let [width, height] = image.size;
        let (what, most) =
            (format!("an image of {width} × {height} pixels"), self.device.limits().max_texture_dimension_2d);
        let limits = [("max_texture_dimension_2d", u64::from(width.max(height)), u64::from(most))];
        crate::allowed(&what, &limits, "make it smaller")
    }

    /// Sets what the next pass shows, seen by `camera` in a picture whose width is `aspect` times its height.
    /// Work that was submitted before does not change. Within one submission, all passes show the last look
    /// that was set.
    pub fn show(&mut self, camera: &Camera, aspect: f32, look: Look) {
        let to_camera = camera.view();
        let mut words = Vec::with_capacity(UNIFORM_WORDS);
        words.extend((camera.projection(aspect) * to_camera).to_cols_array());
        words.extend(to_camera.to_cols_array());
        let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
        words.extend(opaque(if look == Look::Wireframe { WIRE } else { SKIN }));
        let heat = match look {
            Look::Heat(heat) | Look::LitHeat(heat) => heat,
            _ => Heat::From0(1.0),
        };
        let [low, high] = heat.range();
        words.extend([low, high, 0.0, 0.0]);
        words.extend(heat.table().into_iter().flat_map(opaque));
        self.queue.write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&words));
        self.look = look;
    }

    /// Draws a frame into a pass whose attachments are the [`Target`] that the renderer was made for.
    ///
    /// # Errors
    /// [`Error::Input`] if the look needs numbers or textures, and there are none.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, vertices: Vertices<'_>) -> Result<()> {
        pass.set_bind_group(0, &self.group, &[]);
        if self.look == Look::Textured {
            let missing = || Error::empty("textures are to be shown, and the renderer was given none");
            self.textured.as_ref().ok_or_else(missing)?.draw(&self.device, pass, vertices);
            return Ok(());
        }
        pass.set_vertex_buffer(0, vertices.positions);
        pass.set_vertex_buffer(1, vertices.normals);
        if let Look::Heat(_) | Look::LitHeat(_) = self.look {
            let missing = || Error::empty("a heat map needs a number for each vertex, and there are none");
            pass.set_vertex_buffer(2, vertices.numbers.ok_or_else(missing)?);
        }
        if self.look == Look::Matcap {
            pass.set_bind_group(1, &self.matcap, &[]);
        }
        let [smooth, gouraud, flat, behind, heat, lit_heat, wire, matcap] = &self.pipelines;
        pass.set_pipeline(match self.look {
            Look::Smooth | Look::Textured => smooth,
            Look::Matcap => matcap,
            Look::Gouraud => gouraud,
            Look::Flat => flat,
            Look::Wireframe => behind,
            Look::Heat(_) => heat,
            Look::LitHeat(_) => lit_heat,
        });
        pass.set_index_buffer(self.triangles.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..(self.triangles.size() / 4) as u32, 0, 0..1);
        if self.look == Look::Wireframe {
            pass.set_pipeline(wire);
            pass.set_index_buffer(self.edges.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..(self.edges.size() / 4) as u32, 0, 0..1);
        }
        Ok(())
    }
}

fn no_rig() -> Error {
    Error::empty("a rig is to be drawn, and the renderer was given none")
}

/// Each edge of a polygon once.
pub(crate) fn edges(faces: &Faces) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = faces
        .iter()
        .flat_map(|face| (0..face.len()).map(move |i| [face[i], face[(i + 1) % face.len()]]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn pipelines(
    device: &wgpu::Device,
    view: &wgpu::BindGroupLayout,
    image: &wgpu::BindGroupLayout,
    target: Target,
) -> [wgpu::RenderPipeline; 8] {
    let source = wgpu::ShaderSource::Wgsl(include_str!("shader.wgsl").into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("face"), source });
    let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
        device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("face"),
            bind_group_layouts: groups,
            immediate_size: 0,
        })
    };
    let (plain, with_image) = (layout(&[Some(view)]), layout(&[Some(view), Some(image)]));
    let attribute = |format, shader_location| [wgpu::VertexAttribute { format, offset: 0, shader_location }];
    let attributes = [
        attribute(wgpu::VertexFormat::Float32x3, 0),
        attribute(wgpu::VertexFormat::Float32x3, 1),
        attribute(wgpu::VertexFormat::Float32, 2),
    ];
    let buffers = attributes.each_ref().map(|attributes| {
        Some(wgpu::VertexBufferLayout {
            array_stride: attributes[0].format.size(),
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        })
    });
    let pipeline = |fragment: &str| {
        let [is_wire, is_behind] = ["wire", "behind"].map(|name| name == fragment);
        let has_numbers = ["heat", "lit_heat"].contains(&fragment);
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(if fragment == "matcap" { &with_image } else { &plain }),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(if has_numbers { "numbered_corner" } else { "corner" }),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: if has_numbers { &buffers } else { &buffers[..2] },
            },
            primitive: wgpu::PrimitiveState {
                topology: match is_wire {
                    true => wgpu::PrimitiveTopology::LineList,
                    false => wgpu::PrimitiveTopology::TriangleList,
                },
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                bias: match is_behind {
                    // The surface lies slightly behind the wires on it.
                    true => wgpu::DepthBiasState { constant: 2, slope_scale: 1.5, clamp: 0.0 },
                    false => wgpu::DepthBiasState::default(),
                },
                ..target.depth_test(true)
            }),
            multisample: target.multisample(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(target.color.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    };
    ["smooth_skin", "gouraud_skin", "flat_skin", "behind", "heat", "lit_heat", "wire", "matcap"].map(pipeline)
}
