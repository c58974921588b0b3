//! A rig that shaders evaluate while they draw it, without compute shaders and without storage buffers.
use crate::data_texture::{WIDTH, bytes_of, bytes_of_texel, filled, texture, write};
use crate::read_back::mapped;
use crate::target::Target;
use bytemuck::{Pod, Zeroable};
use rhytid_core::plan::{Plan, PlanLimits};
use rhytid_core::{BasisStorage, Error, HandleFrames, Result, Rig, UploadOptions, human};
use rhytid_kernels::differences::table_len;
use rhytid_kernels::large_scale::MOTION;
use rhytid_kernels::table::Buffer;
use rhytid_kernels::vector_differences::{self, vector_differences};
use std::num::NonZeroU64;

/// The arrays of the kernels that are textures of words, in the order of their bindings.
const EVALUATED: [Buffer; 8] = [
    Buffer::Rest,
    Buffer::Basis,
    Buffer::BasisRows,
    Buffer::InfluenceOffsets,
    Buffer::Influences,
    Buffer::InfluenceWeights,
    Buffer::BandWeights,
    Buffer::FeatureGains,
];

/// Those that the normals need.
const PLACED: [Buffer; 2] = [Buffer::FanOffsets, Buffer::Fans];

const POSITIONS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// As the shader has it.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Sizes {
    width: u32,
    vertices: u32,
    features: u32,
    centers: u32,
    motions: u32,
    vectors: u32,
    center: u32,
    unused: u32,
}

/// The rig's arrays in textures, and the frame that was sent last.
#[derive(Debug)]
pub(crate) struct Posed {
    device: wgpu::Device,
    queue: wgpu::Queue,
    plan: Plan,
    vertices: usize,
    vectors: usize,
    /// W, H×R.
    cluster_basis: Vec<f32>,
    strain_edges: Vec<[u32; 2]>,
    feature_lengths: Vec<f32>,
    example_vectors: Vec<[f32; 3]>,
    feature_limits: Vec<f32>,
    /// Of a frame: the motions of the clusters, the squared vector differences, and what is beyond the reach.
    frame: [wgpu::Texture; 3],
    /// A texel for each vertex.
    positions: wgpu::Texture,
    evaluated: wgpu::BindGroup,
    placed: wgpu::BindGroup,
    place: wgpu::RenderPipeline,
    flat: wgpu::RenderPipeline,
    smooth: wgpu::RenderPipeline,
    bytes: u64,
    /// Whether the vertices are those of the frame that was sent last.
    is_placed: bool,
}

impl Posed {
    /// `view` is the layout of the uniforms of a [`crate::Renderer`] for `target`.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig has no wrinkles of vector strains, or is too large for the device.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        view: &wgpu::BindGroupLayout,
        target: Target,
        rig: &Rig,
    ) -> Result<Self> {
        if !rig.vector_wrinkles() {
            return Err(Error::mismatch(
                "a rig whose wrinkles are not functions of vector strains, which shaders that draw need; solve it by \
                 the learned method with wrinkle_strains = \"vectors\"",
            ));
        }
        let everything = PlanLimits { max_binding_bytes: u64::MAX, max_workgroups: u32::MAX };
        let options = UploadOptions { max_frames: 1, basis: BasisStorage::Clustered };
        let plan = Plan::new(rig, options, everything, "drawing")?;
        let words = |buffer: Buffer| -> Vec<u32> {
            let index = plan.buffers().iter().position(|planned| planned.buffer == buffer);
            let bytes = index.map(|index| plan.contents(rig, index)).unwrap_or_default();
            let mut words = vec![0; bytes.len().div_ceil(4)];
            bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(&bytes);
            words
        };
        let constants = EVALUATED.map(words);
        let of_normals = PLACED.map(words);
        let cluster_basis: Vec<f32> = bytemuck::cast_vec(words(Buffer::ClusterBasis));
        let handles = rig.handles().len();
        let motions = cluster_basis.len() / handles;
        let vectors = if rig.handles().rotations { MOTION } else { 1 };
        let (features, centers) = (rig.handles().features(), rig.centers());
        let texels = [motions * vectors, table_len(features, centers) / 4, features.max(1)];
        let most = device.limits().max_texture_dimension_2d as usize;
        let largest = constants.iter().chain(&of_normals).map(Vec::len).chain(texels).max().unwrap_or(0);
        if largest.div_ceil(WIDTH) > most {
            return Err(Error::too_large(format!(
                "a rig of {}: an array needs a texture of {} rows, and this device allows {most}; {}",
                human::counted(rig.vertices(), "vertex"),
                largest.div_ceil(WIDTH),
                crate::FEWER
            )));
        }
        let sizes = Sizes {
            width: WIDTH as u32,
            vertices: rig.vertices() as u32,
            features: features as u32,
            centers: centers as u32,
            motions: motions as u32,
            vectors: vectors as u32,
            center: plan.center(),
            unused: 0,
        };
        crate::checked(device, "taking a rig", || {
            let constants = constants.map(|words| filled(device, queue, &words));
            let of_normals = of_normals.map(|words| filled(device, queue, &words));
            let frame = texels.map(|texels| {
                texture(device, wgpu::TextureFormat::Rgba32Float, texels, wgpu::TextureUsages::COPY_DST)
            });
            let positions =
                texture(device, POSITIONS, rig.vertices(), wgpu::TextureUsages::RENDER_ATTACHMENT);
            let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("sizes"),
                size: size_of::<Sizes>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&uniforms, 0, bytemuck::bytes_of(&sizes));
            let textures = || constants.iter().chain(&of_normals).chain(&frame).chain([&positions]);
            let bytes = textures().map(bytes_of).sum();
            let layouts = [evaluated_layout(device), placed_layout(device)];
            let evaluated: Vec<&wgpu::Texture> = constants.iter().chain(&frame).collect();
            let placed: Vec<&wgpu::Texture> = of_normals.iter().chain([&positions]).collect();
            let pipelines = pipelines(device, view, &layouts, target);
            Self {
                evaluated: group(device, &layouts[0], Some(&uniforms), &evaluated),
                placed: group(device, &layouts[1], None, &placed),
                place: pipelines.place,
                flat: pipelines.flat,
                smooth: pipelines.smooth,
                frame,
                positions,
                bytes,
                is_placed: false,
                device: device.clone(),
                queue: queue.clone(),
                vertices: rig.vertices(),
                vectors,
                cluster_basis,
                strain_edges: rig.handles().edge_numbers().to_vec(),
                feature_lengths: rig.handles().feature_lengths().iter().map(|&l| l as f32).collect(),
                example_vectors: rig.example_vectors().into_vec(),
                feature_limits: rig.feature_limits(),
                plan,
            }
        })
    }

    /// The bytes of all textures.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Sends a frame: H positions of handles.
    ///
    /// # Errors
    /// [`Error::Input`] if their number is another, or one is not finite.
    pub(crate) fn send(&mut self, handle_positions: &[f32]) -> Result<()> {
        let expected = self.plan.values_per_frame();
        if handle_positions.len() != expected || !handle_positions.iter().all(|x| x.is_finite()) {
            return Err(Error::mismatch(format!(
                "a frame of {}: expected {expected} finite numbers, three for each handle",
                human::counted(handle_positions.len(), "number")
            )));
        }
        let [mut displacements, mut excess, mut motions] = [const { Vec::new() }; 3];
        for input in self.plan.inputs(HandleFrames { positions: handle_positions, frames: 1 }) {
            match self.plan.buffers()[input.buffer].buffer {
                Buffer::Displacements => displacements = input.numbers.into_owned(),
                Buffer::VectorExcess => excess = input.numbers.into_owned(),
                Buffer::Motions => motions = input.numbers.into_owned(),
                _ => {}
            }
        }
        let moved = if self.vectors > 1 { &motions } else { &displacements };
        let numbers = [self.cluster_motions(moved), self.squared_vector_differences(&displacements), excess];
        for (texture, numbers) in self.frame.iter().zip(numbers) {
            write(&self.queue, texture, bytemuck::cast_slice(&numbers));
        }
        self.is_placed = false;
        Ok(())
    }

    /// W u, R times four numbers for each vector of a handle. `moved` has four numbers for each handle.
    fn cluster_motions(&self, moved: &[f32]) -> Vec<f32> {
        let handles = moved.len() / 4 / self.vectors;
        let rows = self.cluster_basis.len() / handles;
        let mut sums = vec![[0.0; 4]; rows * self.vectors];
        let (moved, _) = moved.as_chunks::<4>();
        for (sums, moved) in sums.chunks_exact_mut(rows).zip(moved.chunks_exact(handles)) {
            for (factors, u) in self.cluster_basis.chunks_exact(rows).zip(moved) {
                for (sum, factor) in sums.iter_mut().zip(factors) {
                    for c in 0..3 {
                        sum[c] += factor * u[c];
                    }
                }
            }
        }
        sums.into_flattened()
    }

    fn squared_vector_differences(&self, displacements: &[f32]) -> Vec<f32> {
        let u: Vec<[f32; 3]> =
            displacements.as_chunks::<4>().0.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
        let buffers = vector_differences::Buffers {
            strain_edges: &self.strain_edges,
            feature_lengths: &self.feature_lengths,
            example_vectors: &self.example_vectors,
            feature_limits: &self.feature_limits,
        };
        let features = self.feature_lengths.len();
        let centers = self.example_vectors.len() / features.max(1) + 1;
        let params = vector_differences::Params {
            frames: 1,
            handles: u.len() as u32,
            strain_edges: self.strain_edges.len() as u32,
            centers: centers as u32,
        };
        let mut table = vec![0.0; table_len(features, centers)];
        vector_differences(params, &u, &buffers, &mut table);
        table
    }

    /// Places all vertices of the frame that was sent, for [`Posed::draw_smooth`].
    pub(crate) fn place(&mut self) {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = self.positions.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("positions"),
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
        pass.set_pipeline(&self.place);
        pass.set_bind_group(2, &self.evaluated, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        self.queue.submit([encoder.finish()]);
        self.is_placed = true;
    }

    pub(crate) fn is_placed(&self) -> bool {
        self.is_placed
    }

    /// Draws the vertices that were placed, with their normals.
    pub(crate) fn draw_smooth(&self, pass: &mut wgpu::RenderPass<'_>, indices: u32) {
        pass.set_pipeline(&self.smooth);
        pass.set_bind_group(2, &self.evaluated, &[]);
        pass.set_bind_group(3, &self.placed, &[]);
        pass.draw_indexed(0..indices, 0, 0..1);
    }

    /// Evaluates the vertices of the frame that was sent while it draws their triangles, each with a normal
    /// of its own.
    pub(crate) fn draw_flat(&self, pass: &mut wgpu::RenderPass<'_>, indices: u32) {
        pass.set_pipeline(&self.flat);
        pass.set_bind_group(2, &self.evaluated, &[]);
        pass.draw_indexed(0..indices, 0, 0..1);
    }

    /// The vertices that were placed, V. Outside of browsers it waits within the first poll.
    ///
    /// # Errors
    /// [`Error::Device`].
    pub(crate) fn read_positions(&self) -> Result<impl Future<Output = Result<Vec<[f32; 3]>>> + use<>> {
        const DOING: &str = "reading positions";
        let buffer = crate::checked(&self.device, DOING, || {
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("positions"),
                size: bytes_of(&self.positions),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((WIDTH * bytes_of_texel(&self.positions)) as u32),
                rows_per_image: None,
            };
            let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
            encoder.copy_texture_to_buffer(self.positions.as_image_copy(), to, self.positions.size());
            self.queue.submit([encoder.finish()]);
            buffer
        })?;
        let (device, vertices) = (self.device.clone(), self.vertices);
        Ok(async move {
            let bytes = mapped(&device, &buffer, DOING).await?;
            let numbers: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
            Ok(numbers.iter().take(vertices).map(|&[x, y, z, _]| [x, y, z]).collect())
        })
    }
}

fn entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::VERTEX_FRAGMENT, ty, count: None }
}

fn of_texture(binding: u32, sample_type: wgpu::TextureSampleType) -> wgpu::BindGroupLayoutEntry {
    let view_dimension = wgpu::TextureViewDimension::D2;
    entry(binding, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false })
}

/// The sizes, the rig's words and a frame's floats.
fn evaluated_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let sizes = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: NonZeroU64::new(size_of::<Sizes>() as u64),
    };
    let words = 1..=EVALUATED.len() as u32;
    let floats = words.end() + 1..words.end() + 4;
    let mut entries = vec![entry(0, sizes)];
    entries.extend(words.map(|binding| of_texture(binding, wgpu::TextureSampleType::Uint)));
    let float = wgpu::TextureSampleType::Float { filterable: false };
    entries.extend(floats.map(|binding| of_texture(binding, float)));
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("rig"), entries: &entries })
}

/// The words of the fans, and the positions.
fn placed_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entries = [0, 1, 2].map(|binding| of_texture(binding, wgpu::TextureSampleType::Uint));
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("fans"), entries: &entries })
}

/// A buffer if there is one, and then textures, in the order of their bindings.
fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffer: Option<&wgpu::Buffer>,
    textures: &[&wgpu::Texture],
) -> wgpu::BindGroup {
    let views: Vec<wgpu::TextureView> =
        textures.iter().map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default())).collect();
    let resources = buffer.map(wgpu::Buffer::as_entire_binding);
    let resources = resources.into_iter().chain(views.iter().map(wgpu::BindingResource::TextureView));
    let entries: Vec<wgpu::BindGroupEntry<'_>> = resources
        .enumerate()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("rig"), layout, entries: &entries })
}

struct Pipelines {
    place: wgpu::RenderPipeline,
    flat: wgpu::RenderPipeline,
    smooth: wgpu::RenderPipeline,
}

fn pipelines(
    device: &wgpu::Device,
    view: &wgpu::BindGroupLayout,
    [evaluated, placed]: &[wgpu::BindGroupLayout; 2],
    target: Target,
) -> Pipelines {
    let source = concat!(include_str!("shader.wgsl"), include_str!("rig.wgsl"));
    let source = wgpu::ShaderSource::Wgsl(source.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("rig"), source });
    let pipeline = |[vertex, fragment]: [&str; 2],
                    groups: &[Option<&wgpu::BindGroupLayout>],
                    onto: wgpu::TextureFormat,
                    screen: Option<Target>| {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("rig"),
            bind_group_layouts: groups,
            immediate_size: 0,
        });
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(vertex),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: screen.map(|target| target.depth_test(true)),
            multisample: screen.map(Target::multisample).unwrap_or_default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(onto.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    };
    let to_screen = |names, groups: &[_]| pipeline(names, groups, target.color, Some(target));
    Pipelines {
        place: pipeline(["everywhere", "placed"], &[None, None, Some(evaluated)], POSITIONS, None),
        flat: to_screen(["evaluated_corner", "flat_skin"], &[Some(view), None, Some(evaluated)]),
        smooth: to_screen(
            ["placed_corner", "smooth_skin"],
            &[Some(view), None, Some(evaluated), Some(placed)],
        ),
    }
}
