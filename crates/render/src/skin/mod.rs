//! Skin: light enters it and leaves it nearby, its surface shines, and wrinkles cast shadows.
//!
//! Light falls on each vertex from a key light with soft shadows and from a sky. Wrinkles and hollows see
//! only a part of the sky. This light spreads along the surface by the six Gaussians of E. d'Eon and D.
//! Luebke (GPU Gems 3, chapter 14). They are heat kernels, applied with the cotangent Laplacian of the mesh
//! at rest. The reflection of the surface, two GGX lobes, is added without spreading. Units are physical: lx,
//! cd/m², mm.

mod compute;
mod diffusion;
mod pieces;
mod profile;
mod sky;
#[cfg(test)]
mod tests;
mod visibility;

pub use profile::{Gaussian, SKIN_PROFILE};
pub use sky::Sky;

use crate::camera::Camera;
use crate::target::Target;
use crate::vertices::Vertices;
use compute::Bind;
use diffusion::{Diffusion, Effort};
use glam::Vec3;
use pieces::Pieces;
use rhytid_core::{NoProgress, Progress, Result, human};
use visibility::{Arrays, KeyLight, SkyLight, Visibility};

/// Words of the scene's uniforms: two matrices, a direction, the key light, the sky, the surface and the
/// display.
const SCENE_WORDS: usize = 16 + 16 + 4 + 4 + 36 + 4 + 4;
/// Limits for the polynomials of the Laplacian. A face of 530,000 vertices, a quarter of a millimetre apart,
/// needs 70. More than `always` are not used for the finest two-hundredth of the surface.
const EFFORT: Effort = Effort { always: 40, longest: 128, spared: 0.005 };
/// Words of a frame's uniforms.
const FRAME_WORDS: usize = 4;

/// Refuses skin on V `vertices` where it needs more than `device` allows. `bytes` is the size of the largest
/// buffer, apart from the buffers per vertex.
fn allowed(device: &wgpu::Device, vertices: usize, bytes: u64) -> Result<()> {
    let limits = device.limits();
    let counts = [
        ("max_storage_buffers_per_shader_stage", 5, limits.max_storage_buffers_per_shader_stage),
        ("max_compute_invocations_per_workgroup", 64, limits.max_compute_invocations_per_workgroup),
        ("max_compute_workgroup_size_x", 64, limits.max_compute_workgroup_size_x),
        ("max_compute_workgroups_per_dimension", 65_535, limits.max_compute_workgroups_per_dimension),
        ("max_texture_dimension_2d", visibility::SIDES[0], limits.max_texture_dimension_2d),
    ];
    let bytes = bytes.max(16 * vertices as u64);
    let sizes = [
        ("max_storage_buffer_binding_size", bytes, limits.max_storage_buffer_binding_size),
        ("max_buffer_size", bytes, limits.max_buffer_size),
    ];
    let all: Vec<(&str, u64, u64)> = counts
        .map(|(name, needed, most)| (name, u64::from(needed), u64::from(most)))
        .into_iter()
        .chain(sizes)
        .collect();
    let what = format!("skin on {} vertices", human::count(vertices));
    crate::allowed(&what, &all, "draw without skin, or a mesh of fewer vertices")
}

/// The material of skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skin {
    /// The part of red, green and blue light that leaves the skin again, linear, 0 to 1.
    pub albedo: [f32; 3],
    /// The part of perpendicular light that the surface reflects: ((n − 1)/(n + 1))² for the refractive index
    /// n.
    pub reflectance: f32,
    /// The roughness of the two lobes, 0 to 1. α is its square.
    pub roughness: [f32; 2],
    /// The share of the first lobe.
    pub first_lobe: f32,
    /// How far light spreads.
    pub profile: [Gaussian; 6],
}

impl Default for Skin {
    /// Light skin. Its sources are listed in docs/render.md.
    fn default() -> Self {
        Self {
            // The patch "light skin" of a ColorChecker: 194, 150, 130 in sRGB.
            albedo: [0.539, 0.305, 0.223],
            // n = 1.4.
            reflectance: 0.028,
            roughness: [0.36, 0.62],
            first_lobe: 0.5,
            profile: SKIN_PROFILE,
        }
    }
}

/// How radiance becomes a display's light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Unchanged, up to 1.
    Linear,
    /// Khronos PBR Neutral: all colours but the brightest stay unchanged.
    Neutral,
    /// AgX: more contrast, and bright colours turn white sooner.
    Agx,
}

/// The lights of a face, and the camera's exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lights {
    /// The direction to the key light, in the camera's space: x to the picture's right, y up, z towards the
    /// viewer.
    pub toward: [f32; 3],
    /// The irradiance of the key light at perpendicular incidence, in lx.
    pub key: [f32; 3],
    /// The width of the soft edge of its shadows, in millimetres.
    pub penumbra: f32,
    /// All other light.
    pub sky: Sky,
    /// Exposure value at ISO 100: a radiance of 1.2 · 2^EV cd/m² is a display's white.
    pub exposure: f32,
    /// How the exposed picture is displayed.
    pub tone: Tone,
}

impl Default for Lights {
    /// A portrait: a warm key light from the upper left, and a sky that is brighter above and on the right.
    fn default() -> Self {
        let sky = Sky::from_radiance(|[x, y, z]| {
            let (above, right, behind) = (0.5 + 0.5 * y, 0.5 + 0.5 * x, 0.5 - 0.5 * z);
            [
                24.0 + 34.0 * above + 26.0 * right + 20.0 * behind,
                22.0 + 38.0 * above + 28.0 * right + 22.0 * behind,
                21.0 + 46.0 * above + 32.0 * right + 26.0 * behind,
            ]
        });
        Self {
            toward: [-0.55, 0.55, 0.63],
            key: [1090.0, 1000.0, 900.0],
            penumbra: 1.5,
            sky,
            exposure: 7.6,
            tone: Tone::Neutral,
        }
    }
}

/// Draws one mesh as skin.
#[derive(Debug)]
pub struct SkinRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    skin: Skin,
    millimetres: f32,
    scene: wgpu::Buffer,
    frame: wgpu::Buffer,
    triangles: wgpu::Buffer,
    /// V × 4 bytes.
    albedos: wgpu::Buffer,
    visibility: Visibility,
    receiving: wgpu::BindGroupLayout,
    receive: wgpu::ComputePipeline,
    diffusion: Diffusion,
    /// V × 4 each: the spread light, and what is seen of light, of the frame that was lit last. They stay
    /// whole while the next frame is lit.
    lit: [wgpu::Buffer; 2],
    group: wgpu::BindGroup,
    pipeline: wgpu::RenderPipeline,
}

impl SkinRenderer {
    /// For passes that draw a mesh into `target`. The mesh has V positions at `rest` and its `triangles`. Its
    /// unit is `millimetres` long.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`] if `device` refuses, such as for lack of memory;
    /// [`rhytid_core::Error::Input`] if the mesh is too large for it.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rest: &[[f32; 3]],
        triangles: &[[u32; 3]],
        millimetres: f64,
        target: Target,
        skin: Skin,
    ) -> Result<Self> {
        Self::with_progress(device, queue, rest, triangles, millimetres, target, skin, &NoProgress)
    }

    /// [`SkinRenderer::new`] for callers that show its progress or stop it. At half a million vertices it
    /// takes seconds.
    ///
    /// # Errors
    /// As [`SkinRenderer::new`]; [`rhytid_core::Error::Cancelled`].
    #[expect(clippy::too_many_arguments, reason = "those of `new`, and the progress")]
    pub fn with_progress(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rest: &[[f32; 3]],
        triangles: &[[u32; 3]],
        millimetres: f64,
        target: Target,
        skin: Skin,
        progress: &dyn Progress,
    ) -> Result<Self> {
        const STEP: &str = "prepare skin";
        progress.step(STEP, 0, 3)?;
        allowed(device, rest.len(), 0)?;
        let what = format!("a mesh of {}", human::counted(triangles.len(), "triangle"));
        let limits = [("max_buffer_size", 12 * triangles.len() as u64, device.limits().max_buffer_size)];
        crate::allowed(&what, &limits, crate::FEWER)?;
        let diffusion = Diffusion::new(device, queue, rest, triangles, millimetres, &skin.profile, EFFORT)?;
        progress.step(STEP, 1, 3)?;
        let visibility = Visibility::new(device, queue, rest, triangles)?;
        progress.step(STEP, 2, 3)?;
        let renderer = crate::checked(device, "preparing skin", || {
            let buffer = |label, size: usize, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: size.max(4) as u64,
                    usage: usage | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            };
            let scene = buffer("scene", 4 * SCENE_WORDS, wgpu::BufferUsages::UNIFORM);
            let indices = buffer("triangles", 12 * triangles.len(), wgpu::BufferUsages::INDEX);
            queue.write_buffer(&indices, 0, bytemuck::cast_slice(triangles));
            let albedos = buffer("albedos", 4 * rest.len(), wgpu::BufferUsages::VERTEX);
            queue.write_buffer(&albedos, 0, bytemuck::cast_slice(&vec![bytes(skin.albedo); rest.len()]));
            let uniform = |words| Bind::Uniform { words, dynamic: false };
            let receiving = compute::layout(
                device,
                &[
                    uniform(SCENE_WORDS),
                    uniform(FRAME_WORDS),
                    compute::read(),
                    compute::read(),
                    compute::write(),
                ],
            );
            let drawing = compute::layout(device, &[uniform(SCENE_WORDS)]);
            let source = include_str!("shade.wgsl");
            Self {
                device: device.clone(),
                queue: queue.clone(),
                skin,
                millimetres: millimetres as f32,
                frame: buffer("frame", 4 * FRAME_WORDS, wgpu::BufferUsages::UNIFORM),
                triangles: indices,
                albedos,
                visibility,
                receive: compute::pipeline(device, &receiving, "receive", source),
                receiving,
                diffusion,
                lit: ["spread light that is drawn", "seen light that is drawn"]
                    .map(|label| buffer(label, 16 * rest.len(), wgpu::BufferUsages::VERTEX)),
                group: compute::group(device, &drawing, [scene.as_entire_binding()]),
                pipeline: pipeline(device, &drawing, source, target),
                scene,
            }
        })?;
        progress.step(STEP, 3, 3)?;
        Ok(renderer)
    }

    /// Gives each of the V vertices its own albedo, such as for eyes and teeth.
    ///
    /// # Panics
    /// If there are more albedos than vertices.
    pub fn paint(&self, albedos: &[[f32; 3]]) {
        let albedos: Vec<[u8; 4]> = albedos.iter().map(|albedo| bytes(*albedo)).collect();
        self.queue.write_buffer(&self.albedos, 0, bytemuck::cast_slice(&albedos));
    }

    /// The part of the surface on which light does not spread far enough, since its triangles are too fine
    /// for the number of steps.
    pub fn too_fine(&self) -> f64 {
        self.diffusion.too_fine
    }

    /// Lights a frame and spreads the light. A pass can then draw the frame, seen by `camera` in a picture
    /// whose width is `aspect` times its height. Positions and normals must be in whole buffers with the
    /// usage `STORAGE`. A submission can have only one frame: with two, both would show the later one.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`].
    pub fn light(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        vertices: Vertices<'_>,
        camera: &Camera,
        aspect: f32,
        lights: &Lights,
    ) -> Result<()> {
        self.aim(camera, aspect, lights);
        self.light_pieces(&mut Pieces::Together(encoder), vertices, camera, lights)
    }

    /// [`SkinRenderer::light`] in many short submissions, with a wait after each. In between, others can use
    /// the device, and `progress` can stop the work. The light of the last frame then stays as it was.
    ///
    /// # Errors
    /// As [`SkinRenderer::light`]; [`rhytid_core::Error::Cancelled`].
    pub fn light_in_pieces(
        &self,
        vertices: Vertices<'_>,
        camera: &Camera,
        aspect: f32,
        lights: &Lights,
        progress: &dyn Progress,
    ) -> Result<()> {
        self.aim(camera, aspect, lights);
        let total = visibility::SKY as u64 + 1 + u64::from(self.diffusion.steps());
        let mut pieces = Pieces::apart(&self.device, &self.queue, progress, "light the skin", total)?;
        self.light_pieces(&mut pieces, vertices, camera, lights)?;
        pieces.finish()
    }

    /// Sets the camera and the lights of the next pass. The light that spreads in the skin, and what each
    /// vertex sees of light, stay those of the frame that was lit last. It takes hardly any time.
    pub fn aim(&self, camera: &Camera, aspect: f32, lights: &Lights) {
        let toward = Vec3::from_array(lights.toward).normalize_or(Vec3::Z);
        let words = self.words(camera, aspect, toward, lights);
        self.queue.write_buffer(&self.scene, 0, bytemuck::cast_slice(&words));
    }

    fn light_pieces(
        &self,
        pieces: &mut Pieces<'_>,
        vertices: Vertices<'_>,
        camera: &Camera,
        lights: &Lights,
    ) -> Result<()> {
        let view = camera.view();
        let toward = Vec3::from_array(lights.toward).normalize_or(Vec3::Z);
        let alignment = u64::from(self.device.limits().min_storage_buffer_offset_alignment);
        let [positions, normals] = [vertices.positions, vertices.normals].map(|slice| {
            let before = slice.offset() % alignment;
            let binding = wgpu::BufferBinding {
                buffer: slice.buffer(),
                offset: slice.offset() - before,
                size: wgpu::BufferSize::new(before + slice.size()),
            };
            (wgpu::BindingResource::Buffer(binding), (before / 4) as u32)
        });
        let vertices_count = (vertices.positions.size() / 12) as u32;
        self.queue.write_buffer(
            &self.frame,
            0,
            bytemuck::cast_slice(&[vertices_count, positions.1, normals.1, 0]),
        );
        let arrays = Arrays {
            uniforms: self.frame.as_entire_binding(),
            positions: positions.0,
            normals: normals.0,
            corners: vertices.positions,
        };
        let to_mesh = view.inverse();
        let sky: Vec<SkyLight> = sky::directions(visibility::SKY)
            .into_iter()
            .map(|direction| {
                let toward = Vec3::from_array(direction);
                let [r, g, b] = lights.sky.radiance(view.transform_vector3(toward).to_array());
                SkyLight { toward, brings: 0.2126 * r + 0.7152 * g + 0.0722 * b }
            })
            .collect();
        crate::checked(&self.device, "lighting skin", || {
            let key = KeyLight {
                toward: to_mesh.transform_vector3(toward),
                penumbra: lights.penumbra / self.millimetres,
            };
            self.visibility.run(&self.device, pieces, &arrays, &self.triangles, key, &sky)?;
            let group = compute::group(
                &self.device,
                &self.receiving,
                [
                    self.scene.as_entire_binding(),
                    self.frame.as_entire_binding(),
                    arrays.normals.clone(),
                    self.visibility.seen.as_entire_binding(),
                    self.diffusion.light.as_entire_binding(),
                ],
            );
            let mut pass = pieces.encoder().begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.receive);
            pass.set_bind_group(0, &group, &[]);
            compute::dispatch(&mut pass, vertices_count);
            drop(pass);
            self.diffusion.run(pieces)?;
            for (from, to) in [&self.diffusion.spread, &self.visibility.seen].into_iter().zip(&self.lit) {
                pieces.encoder().copy_buffer_to_buffer(from, 0, to, 0, to.size());
            }
            Ok(())
        })?
    }

    /// Waits until a submission is finished, for example for a measurement.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Device`].
    pub fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<()> {
        pieces::wait(&self.device, submission)
    }

    /// Draws the frame that was lit last into a pass whose attachments are the [`Target`] that the renderer
    /// was made for.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, vertices: Vertices<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.set_vertex_buffer(0, vertices.positions);
        pass.set_vertex_buffer(1, vertices.normals);
        pass.set_vertex_buffer(2, self.lit[0].slice(..));
        pass.set_vertex_buffer(3, self.lit[1].slice(..));
        pass.set_vertex_buffer(4, self.albedos.slice(..));
        pass.set_index_buffer(self.triangles.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..(self.triangles.size() / 4) as u32, 0, 0..1);
    }

    fn words(&self, camera: &Camera, aspect: f32, toward: Vec3, lights: &Lights) -> Vec<f32> {
        let view = camera.view();
        let [first, second] = self.skin.roughness;
        let opaque = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
        let mut words = Vec::with_capacity(SCENE_WORDS);
        words.extend((camera.projection(aspect) * view).to_cols_array());
        words.extend(view.to_cols_array());
        words.extend(toward.extend(0.0).to_array());
        words.extend(opaque(lights.key));
        words.extend(lights.sky.coefficients.into_iter().flat_map(opaque));
        words.extend([self.skin.reflectance, first, second, self.skin.first_lobe]);
        let tone = match lights.tone {
            Tone::Linear => 0.0,
            Tone::Neutral => 1.0,
            Tone::Agx => 2.0,
        };
        words.extend([1.0 / (1.2 * lights.exposure.exp2()), tone, 0.0, 0.0]);
        words
    }
}

fn bytes(albedo: [f32; 3]) -> [u8; 4] {
    let [r, g, b] = albedo.map(|x| (255.0 * x.clamp(0.0, 1.0)).round() as u8);
    [r, g, b, 255]
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    source: &str,
    target: Target,
) -> wgpu::RenderPipeline {
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("skin"), source });
    let attribute = |format, shader_location| [wgpu::VertexAttribute { format, offset: 0, shader_location }];
    let attributes = [
        attribute(wgpu::VertexFormat::Float32x3, 0),
        attribute(wgpu::VertexFormat::Float32x3, 1),
        attribute(wgpu::VertexFormat::Float32x4, 2),
        attribute(wgpu::VertexFormat::Float32x4, 3),
        attribute(wgpu::VertexFormat::Unorm8x4, 4),
    ];
    let buffers = attributes.each_ref().map(|attributes| {
        Some(wgpu::VertexBufferLayout {
            array_stride: attributes[0].format.size(),
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        })
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("skin"),
        layout: Some(&compute::pipeline_layout(device, layout)),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("corner"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(target.depth_test(true)),
        multisample: target.multisample(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("skin"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(target.color.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
