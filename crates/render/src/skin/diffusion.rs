//! Light that spreads in the skin before it comes out: the heat equation on the mesh.

use super::compute;
use super::pieces::Pieces;
use super::profile::{Gaussian, Series};
use rhytid_core::Result;
use rhytid_geometry::laplacian::laplacian;

/// How long a series may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// The number of polynomials that are always allowed.
    pub always: usize,
    /// The largest number of polynomials.
    pub longest: usize,
    /// A part of the surface. If only this part needs more than `always` polynomials, they are not added for
    /// it.
    pub spared: f64,
}

/// Words of a step's uniforms.
const STEP_WORDS: usize = 12;

/// Spreads light over one mesh by a profile, along the surface at rest.
#[derive(Debug)]
pub(crate) struct Diffusion {
    pipeline: wgpu::ComputePipeline,
    steps: u32,
    /// Bytes from one step's uniforms to the next's.
    stride: u32,
    vertices: u32,
    /// Two bind groups that are used in turn: the buffers to read and to write are exchanged.
    groups: [wgpu::BindGroup; 2],
    /// V × 4: the light before spreading. Three of the four numbers are its colours.
    pub light: wgpu::Buffer,
    /// V × 4: the light after spreading.
    pub spread: wgpu::Buffer,
    /// The part of the surface on which light does not spread far enough. Its triangles are finer than the
    /// series resolves.
    pub too_fine: f64,
}

impl Diffusion {
    /// For V `rest` positions, whose unit is `millimetres` long, with at most this `effort`.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        rest: &[[f32; 3]],
        triangles: &[[u32; 3]],
        millimetres: f64,
        profile: &[Gaussian],
        effort: Effort,
    ) -> Result<Self> {
        let matrix = Matrix::new(rest, triangles, millimetres, profile, effort);
        let links = 8 * matrix.links.len().max(1) as u64;
        super::allowed(device, rest.len(), links)?;
        crate::checked(device, "preparing skin", || {
            let storage = |label, size: u64, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: size.max(16),
                    usage: wgpu::BufferUsages::STORAGE | usage,
                    mapped_at_creation: false,
                })
            };
            let (upload, read) = (wgpu::BufferUsages::COPY_DST, wgpu::BufferUsages::COPY_SRC);
            let offsets = storage("offsets of links", 4 * matrix.offsets.len() as u64, upload);
            queue.write_buffer(&offsets, 0, bytemuck::cast_slice(&matrix.offsets));
            let links = storage("links", links, upload);
            queue.write_buffer(&links, 0, bytemuck::cast_slice(&matrix.links));
            let of_vertices = |label, usage| storage(label, 16 * rest.len() as u64, usage);
            let light = of_vertices("light", upload);
            let last = of_vertices("a polynomial", wgpu::BufferUsages::empty());
            let spread = of_vertices("spread light", read);

            let stride =
                (4 * STEP_WORDS as u32).next_multiple_of(device.limits().min_uniform_buffer_offset_alignment);
            let steps = matrix.series.coefficients.len() - 1;
            let mut uniforms = vec![0_u8; stride as usize * steps];
            for (k, bytes) in uniforms.chunks_exact_mut(stride as usize).enumerate() {
                let part = |k: usize, w: f32| {
                    let [r, g, b] = matrix.series.coefficients[k].map(|x| x as f32);
                    [r, g, b, w]
                };
                let floats = [part(k + 1, if k == 0 { 0.0 } else { 1.0 }), part(0, 0.0)].concat();
                bytes[..32].copy_from_slice(bytemuck::cast_slice(&floats));
                bytes[32..36].copy_from_slice(&(rest.len() as u32).to_ne_bytes());
            }
            let params = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("steps"),
                size: uniforms.len() as u64,
                usage: wgpu::BufferUsages::UNIFORM | upload,
                mapped_at_creation: false,
            });
            queue.write_buffer(&params, 0, &uniforms);

            use compute::{Bind, read as input, write};
            let layout = compute::layout(
                device,
                &[
                    Bind::Uniform { words: STEP_WORDS, dynamic: true },
                    input(),
                    input(),
                    input(),
                    write(),
                    write(),
                ],
            );
            let group = |now: &wgpu::Buffer, last: &wgpu::Buffer| {
                let params = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &params,
                    offset: 0,
                    size: wgpu::BufferSize::new(4 * STEP_WORDS as u64),
                });
                let [offsets, links, now, last, spread] =
                    [&offsets, &links, now, last, &spread].map(|buffer| buffer.as_entire_binding());
                compute::group(device, &layout, [params, offsets, links, now, last, spread])
            };
            Self {
                pipeline: compute::pipeline(device, &layout, "diffuse", include_str!("diffusion.wgsl")),
                steps: steps as u32,
                stride,
                vertices: rest.len() as u32,
                groups: [group(&light, &last), group(&last, &light)],
                light,
                spread,
                too_fine: matrix.too_fine,
            }
        })
    }

    /// The number of pieces of its work.
    pub(crate) fn steps(&self) -> u32 {
        self.steps
    }

    /// Spreads the contents of `light`, which are lost. Each step is a piece of the work.
    ///
    /// # Errors
    /// As the pieces' `next`.
    pub(crate) fn run(&self, pieces: &mut Pieces<'_>) -> Result<()> {
        for step in 0..self.steps {
            let mut pass = pieces.encoder().begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.groups[step as usize % 2], &[step * self.stride]);
            compute::dispatch(&mut pass, self.vertices);
            drop(pass);
            pieces.next()?;
        }
        Ok(())
    }
}

/// The Laplacian of a mesh, scaled for its series.
struct Matrix {
    /// V + 1: the index of each vertex's first link.
    offsets: Vec<u32>,
    /// A neighbour, and the bits of 2 w / Λ M.
    links: Vec<[u32; 2]>,
    series: Series,
    too_fine: f64,
}

impl Matrix {
    fn new(
        rest: &[[f32; 3]],
        triangles: &[[u32; 3]],
        millimetres: f64,
        profile: &[Gaussian],
        effort: Effort,
    ) -> Self {
        let positions: Vec<[f64; 3]> = rest.iter().map(|p| p.map(|x| millimetres * f64::from(x))).collect();
        let mut laplacian = laplacian(&positions, triangles);
        // Where the two angles opposite to an edge sum to more than 180°, its weight is negative. Such an
        // edge would carry light from dark to bright vertices.
        laplacian.edges.retain(|(_, _, w)| *w > 0.0);
        // By Gershgorin's circles, twice the sum of a vertex's weights bounds the eigenvalues.
        let mut leaves = vec![0.0; rest.len()];
        let mut offsets = vec![0_u32; rest.len() + 1];
        for &(a, b, w) in &laplacian.edges {
            for v in [a, b] {
                leaves[v as usize] += 2.0 * w;
                offsets[v as usize + 1] += 1;
            }
        }
        (0..rest.len()).for_each(|v| offsets[v + 1] += offsets[v]);
        let mut rates: Vec<(f64, f64)> = (laplacian.mass.iter().zip(&leaves))
            .filter(|(mass, _)| **mass > 0.0)
            .map(|(mass, leaves)| (leaves / mass, *mass))
            .collect();
        rates.sort_by(|a, b| b.0.total_cmp(&a.0));
        let most = rates.first().map_or(0.0, |rate| rate.0);
        let mut spared = effort.spared * laplacian.mass.iter().sum::<f64>();
        let mut finer = rates.iter().skip_while(|(_, mass)| {
            spared -= mass;
            spared > 0.0
        });
        let usual = finer.next().map_or(most, |rate| rate.0);
        let mut series = Series::new(profile, usual, effort.longest);
        if series.coefficients.len() < effort.always {
            series = Series::new(profile, most, effort.always);
        }
        // Some vertices lose their light faster than the series resolves. Their mass is increased, so the
        // light leaves more slowly and none is lost.
        let (mut area, mut fine) = (0.0, 0.0);
        let masses: Vec<f64> = laplacian
            .mass
            .iter()
            .zip(&leaves)
            .map(|(mass, leaves)| {
                area += mass;
                if series.most < most && leaves / series.most > *mass {
                    fine += mass;
                }
                mass.max(leaves / series.most)
            })
            .collect();
        let mut links = vec![[0; 2]; 2 * laplacian.edges.len()];
        let mut next = offsets.clone();
        for &(a, b, w) in &laplacian.edges {
            for (v, other) in [(a, b), (b, a)] {
                let factor = match masses[v as usize] > 0.0 {
                    true => 2.0 * w / (series.most * masses[v as usize]),
                    false => 0.0,
                };
                links[next[v as usize] as usize] = [other, (factor as f32).to_bits()];
                next[v as usize] += 1;
            }
        }
        Self { offsets, links, series, too_fine: if area > 0.0 { fine / area } else { 0.0 } }
    }
}
