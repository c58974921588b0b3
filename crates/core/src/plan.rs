//! What every GPU backend does with a rig: which buffers it makes, what is in them, and which kernels it runs on them.
//! A backend adds how its API makes a buffer and runs a kernel, and nothing else.
use crate::{BasisStorage, DeviceErrorKind, Error, Result, Rig, Stage, UploadOptions};
use half::f16;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::table::{DETAIL, FINE_SCALE, Kernel, LARGE_SCALE, NORMALS, STRAIN, TILE, WORKGROUP_SIZE};
use rhytid_kernels::{detail, fine_scale, large_scale, normals, strain};
use std::borrow::Cow;
use std::ops::Range;

/// The smallest buffer: some APIs refuse empty ones, and a rig may have no strain edges.
const SMALLEST_BUFFER: u64 = 16;

/// Kernels count in 32 bits, so no array is larger than this whatever the device could do.
const LARGEST_BINDING: u64 = 1 << 31;

/// What a device can do at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanLimits {
    /// The largest buffer that a kernel can be given, in bytes.
    pub max_binding_bytes: u64,
    /// The most workgroups along one axis of a dispatch.
    pub max_workgroups: u32,
}

/// The buffers and dispatches that evaluate a rig.
///
/// Arrays per vertex that are larger than a binding are split into *parts*, ranges of vertices; batches whose results are
/// larger than a binding are split into *slices*, ranges of frames. Most rigs on most devices are one of each.
#[derive(Debug, Clone)]
pub struct Plan {
    sizes: Sizes,
    half_basis: bool,
    parts: Vec<Range<usize>>,
    max_frames: usize,
    frames_per_slice: usize,
    buffers: Vec<PlannedBuffer>,
}

#[derive(Debug, Clone, Copy)]
struct Sizes {
    vertices: usize,
    handles: usize,
    edges: usize,
    influences: usize,
    centers: usize,
}

/// A buffer to make.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlannedBuffer {
    /// Its name in the kernels, or, of a result, its stage's.
    pub name: &'static str,
    /// Its size: a multiple of 4, at least 16.
    pub bytes: u64,
    /// What it is for.
    pub role: Role,
}

/// What a buffer is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// Filled once, from [`Plan::contents`].
    Constant {
        /// The vertices it is about, where it is tiled; otherwise it is whole.
        part: Option<Range<usize>>,
    },
    /// Filled for each batch with the handle positions of a slice.
    Input {
        /// Which slice.
        slice: usize,
    },
    /// Written by a kernel.
    Result {
        /// Which slice.
        slice: usize,
        /// The stage that it holds.
        stage: Stage,
    },
}

/// Consecutive frames of a batch whose results share their buffers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slice {
    /// The frames, counted from the first of the batch.
    pub frames: Range<usize>,
    /// The index of the buffer that takes their handle positions.
    pub handle_positions: usize,
    /// The indices of the buffers of their results, in the order of [`Stage::ALL`].
    pub results: [usize; 6],
}

/// One run of a kernel.
#[derive(Debug, Clone, PartialEq)]
pub struct Dispatch {
    /// Which kernel.
    pub kernel: &'static Kernel,
    /// The stage that it computes, or a part of it. It needs the stages before it finished.
    pub stage: Stage,
    /// The indices of its buffers, in the order of its bindings.
    pub buffers: Vec<usize>,
    /// Its parameter block.
    pub params: Vec<u32>,
    /// Workgroups along x and y; z has one.
    pub workgroups: [u32; 2],
}

impl Plan {
    /// Plans `rig` for a device with these limits; `device` names it in errors.
    ///
    /// # Errors
    /// [`Error::Device`], `Unsupported`, if even one tile or one frame is more than the device can be given at once.
    pub fn new(rig: &Rig, options: UploadOptions, limits: PlanLimits, device: &str) -> Result<Self> {
        let sizes = Sizes {
            vertices: rig.vertices(),
            handles: rig.handles.len(),
            edges: rig.strain_edges.len(),
            influences: rig.influences(),
            centers: rig.centers(),
        };
        let half_basis = options.basis == BasisStorage::F16;
        let limit = limits.max_binding_bytes.min(LARGEST_BINDING) as usize;
        let unsupported = |what: &str, needs: usize, has: usize| Error::Device {
            kind: DeviceErrorKind::Unsupported,
            device: device.to_owned(),
            message: format!("{what} needs {needs}, and this device has {has} at the most"),
        };
        let workgroup = WORKGROUP_SIZE as usize;
        let most_vertices = (limits.max_workgroups as usize).saturating_mul(workgroup);
        if sizes.edges > most_vertices {
            return Err(unsupported("the number of strain edges", sizes.edges, most_vertices));
        }

        let basis_bytes = sizes.handles * if half_basis { 2 } else { 4 };
        let tile_bytes = TILE * basis_bytes.max(sizes.influences * 4).max(sizes.centers * 12);
        if tile_bytes > limit {
            return Err(unsupported("a binding of 64 vertices, in bytes,", tile_bytes, limit));
        }
        let per_part = (limit / tile_bytes).min(most_vertices / TILE).max(1) * TILE;
        let parts: Vec<Range<usize>> = (0..sizes.vertices)
            .step_by(per_part)
            .map(|first| first..(first + per_part).min(sizes.vertices))
            .collect();

        let frame_bytes = (sizes.vertices * 12).max(sizes.handles * 12).max(sizes.edges * 4);
        let topology_bytes = (rig.triangles.len() * 12).max((sizes.vertices + 1) * 4);
        let features_bytes = sizes.centers * sizes.edges * 4;
        let whole = frame_bytes.max(topology_bytes).max(features_bytes).max(sizes.edges * 8);
        if whole > limit {
            return Err(unsupported("a binding, in bytes,", whole, limit));
        }
        let frames_per_slice =
            (limit / frame_bytes).min(limits.max_workgroups as usize).min(options.max_frames);

        let mut plan = Self {
            sizes,
            half_basis,
            parts,
            max_frames: options.max_frames,
            frames_per_slice,
            buffers: Vec::new(),
        };
        plan.plan_buffers(rig.triangles.len());
        Ok(plan)
    }

    fn plan_buffers(&mut self, triangles: usize) {
        let Sizes { vertices, handles, edges, influences, centers } = self.sizes;
        let mut add = |name: &'static str, bytes: usize, role: Role| {
            let bytes = (bytes as u64).max(SMALLEST_BUFFER);
            self.buffers.push(PlannedBuffer { name, bytes, role });
        };
        for (name, bytes) in [
            ("rest", vertices * 12),
            ("handle_rest", handles * 12),
            ("strain_edges", edges * 8),
            ("rest_lengths", edges * 4),
            ("triangles", triangles * 12),
            ("triangle_offsets", (vertices + 1) * 4),
            ("vertex_triangles", triangles * 12),
            ("pose_features", centers * edges * 4),
            ("frame_neighbors", vertices * 4),
        ] {
            add(name, bytes, Role::Constant { part: None });
        }
        let basis_bytes = if self.half_basis { 2 } else { 4 };
        for part in &self.parts {
            let tiled = part.len().next_multiple_of(TILE);
            for (name, bytes) in [
                ("basis", tiled * handles * basis_bytes),
                ("influence_edges", tiled * influences * 4),
                ("influence_weights", tiled * influences * 4),
                ("rbf_weights", tiled * centers * 12),
                ("pivots", tiled * 4),
            ] {
                add(name, bytes, Role::Constant { part: Some(part.clone()) });
            }
        }
        for slice in 0..self.max_frames.div_ceil(self.frames_per_slice) {
            let frames = self.frames_per_slice.min(self.max_frames - slice * self.frames_per_slice);
            add("handle_positions", frames * handles * 12, Role::Input { slice });
            for stage in Stage::ALL {
                let values = if stage == Stage::Strain { edges } else { vertices * 3 };
                add(result_name(stage), frames * values * 4, Role::Result { slice, stage });
            }
        }
    }

    /// The buffers to make; a buffer's index here is its name everywhere else.
    pub fn buffers(&self) -> &[PlannedBuffer] {
        &self.buffers
    }

    /// The size of all buffers together.
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes).sum()
    }

    /// What a constant buffer starts with; what is behind that is never read. Empty for the other buffers.
    ///
    /// `rig` is the one that the plan was made for.
    pub fn contents<'a>(&self, rig: &'a Rig, buffer: usize) -> Cow<'a, [u8]> {
        let Role::Constant { part } = &self.buffers[buffer].role else { return Cow::Borrowed(&[]) };
        let part = part.clone().unwrap_or_default();
        let Sizes { handles, influences, centers, .. } = self.sizes;
        let of_part = |per_vertex: usize| part.start * per_vertex..part.end * per_vertex;
        match self.buffers[buffer].name {
            "rest" => Cow::Borrowed(bytemuck::cast_slice(&rig.rest)),
            "handle_rest" => {
                owned(&rig.handles.iter().map(|&v| rig.rest[v as usize]).collect::<Vec<[f32; 3]>>())
            }
            "strain_edges" => Cow::Borrowed(bytemuck::cast_slice(&rig.strain_edges)),
            "rest_lengths" => owned(&strain::rest_lengths(&rig.rest, &rig.handles, &rig.strain_edges)),
            "triangles" => Cow::Borrowed(bytemuck::cast_slice(&rig.triangles)),
            "triangle_offsets" => owned(&VertexTriangles::new(rig.vertices(), &rig.triangles).offsets),
            "vertex_triangles" => owned(&VertexTriangles::new(rig.vertices(), &rig.triangles).triangles),
            "pose_features" => Cow::Borrowed(bytemuck::cast_slice(&rig.pose_features)),
            "frame_neighbors" => Cow::Borrowed(bytemuck::cast_slice(&rig.frame_neighbors)),
            "basis" if self.half_basis => {
                let halves: Vec<u16> =
                    rig.basis[of_part(handles)].iter().map(|&b| f16::from_f32(b).to_bits()).collect();
                owned(&tiled(&halves, handles))
            }
            "basis" => owned(&tiled(&rig.basis[of_part(handles)], handles)),
            "influence_edges" => owned(&tiled(&rig.influence_edges[of_part(influences)], influences)),
            "influence_weights" => owned(&tiled(&rig.influence_weights[of_part(influences)], influences)),
            "rbf_weights" => {
                let (weights, _) = detail::pivoted(&rig.rbf_weights[of_part(centers)], centers);
                owned(&tiled(weights.as_flattened(), centers * 3))
            }
            "pivots" => owned(&tiled(&detail::pivoted(&rig.rbf_weights[of_part(centers)], centers).1, 1)),
            name => unreachable!("no constant is called {name}"),
        }
    }

    /// The slices of a batch of `frames` frames, at most as many as there is room for.
    pub fn slices(&self, frames: usize) -> impl Iterator<Item = Slice> {
        (0..frames.div_ceil(self.frames_per_slice)).map(move |slice| {
            let first = slice * self.frames_per_slice;
            Slice {
                frames: first..(first + self.frames_per_slice).min(frames),
                handle_positions: self.find("handle_positions", None, slice),
                results: Stage::ALL.map(|stage| self.find(result_name(stage), None, slice)),
            }
        })
    }

    /// The bytes of one frame of a stage's result.
    pub fn frame_bytes(&self, stage: Stage) -> usize {
        4 * if stage == Stage::Strain { self.sizes.edges } else { self.sizes.vertices * 3 }
    }

    /// The bytes of one frame of handle positions.
    pub fn handle_positions_bytes(&self) -> usize {
        self.sizes.handles * 12
    }

    /// What to run for a batch of `frames` frames, in this order. The dispatches of a smaller batch are the first ones
    /// of a larger one, but for their parameters and workgroups: kernels and buffers are the same.
    pub fn dispatches(&self, frames: usize) -> Vec<Dispatch> {
        let mut dispatches = Vec::new();
        for (slice, Slice { frames, .. }) in self.slices(frames).enumerate() {
            let frames = frames.len() as u32;
            for stage in Stage::ALL {
                // Strain is of edges, not of vertices, and never split.
                let edges = 0..self.sizes.edges;
                let parts =
                    if stage == Stage::Strain { std::slice::from_ref(&edges) } else { &self.parts[..] };
                for part in parts.iter().filter(|part| !part.is_empty()) {
                    let (kernel, params) = self.kernel(stage, frames, part);
                    let buffers = kernel.bindings.iter();
                    let buffers = buffers.map(|b| self.find(bound_name(stage, b.name), Some(part), slice));
                    dispatches.push(Dispatch {
                        kernel,
                        stage,
                        buffers: buffers.collect(),
                        params,
                        workgroups: [(part.len() as u32).div_ceil(WORKGROUP_SIZE), frames],
                    });
                }
            }
        }
        dispatches
    }

    /// The kernel that computes `stage`, and its parameters for `part`.
    fn kernel(&self, stage: Stage, frames: u32, part: &Range<usize>) -> (&'static Kernel, Vec<u32>) {
        let Sizes { vertices, handles, edges, influences, centers } = self.sizes;
        let [vertices, handles, strain_edges, influences, centers] =
            [vertices, handles, edges, influences, centers].map(|n| n as u32);
        let (first_vertex, part_vertices) = (part.start as u32, part.len() as u32);
        match stage {
            Stage::Strain => (&STRAIN, words(&strain::Params { frames, handles, strain_edges })),
            Stage::LargeScale => {
                let half_basis = u32::from(self.half_basis);
                let params = large_scale::Params {
                    frames,
                    vertices,
                    first_vertex,
                    part_vertices,
                    handles,
                    half_basis,
                };
                (&LARGE_SCALE, words(&params))
            }
            Stage::LargeScaleNormals | Stage::Normals => {
                (&NORMALS, words(&normals::Params { frames, vertices, first_vertex, part_vertices }))
            }
            Stage::Detail => {
                let params = detail::Params {
                    frames,
                    vertices,
                    first_vertex,
                    part_vertices,
                    strain_edges,
                    influences,
                    centers,
                };
                (&DETAIL, words(&params))
            }
            Stage::Positions => {
                (&FINE_SCALE, words(&fine_scale::Params { frames, vertices, first_vertex, part_vertices }))
            }
        }
    }

    /// The buffer of this name; `part` and `slice` are heeded where there is one for each.
    fn find(&self, name: &str, part: Option<&Range<usize>>, slice: usize) -> usize {
        let found = self.buffers.iter().position(|buffer| {
            buffer.name == name
                && match &buffer.role {
                    Role::Constant { part: None } => true,
                    Role::Constant { part: of } => of.as_ref() == part,
                    Role::Input { slice: of } | Role::Result { slice: of, .. } => *of == slice,
                }
        });
        found.unwrap_or_else(|| unreachable!("every buffer of a kernel is planned, {name} too"))
    }
}

/// The name of the buffer that a stage's result is in.
fn result_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Strain => "features",
        Stage::LargeScale => "large_scale_positions",
        Stage::LargeScaleNormals => "large_scale_normals",
        Stage::Detail => "local_detail",
        Stage::Positions => "positions",
        Stage::Normals => "normals",
    }
}

/// The name of the buffer that is bound as `binding` for `stage`: the kernel `normals` runs on two.
fn bound_name(stage: Stage, binding: &'static str) -> &'static str {
    match (stage, binding) {
        (Stage::LargeScaleNormals, "positions") => result_name(Stage::LargeScale),
        (Stage::LargeScaleNormals | Stage::Normals, "vertex_normals") => result_name(stage),
        _ => binding,
    }
}

fn words<T: bytemuck::NoUninit>(params: &T) -> Vec<u32> {
    bytemuck::cast_slice(std::slice::from_ref(params)).to_vec()
}

fn owned<T: bytemuck::NoUninit>(numbers: &[T]) -> Cow<'static, [u8]> {
    Cow::Owned(bytemuck::cast_slice(numbers).to_vec())
}

/// From n numbers for each vertex to `[⌈V/64⌉][n][64]`; what is past V is zero.
fn tiled<T: Copy + Default>(numbers: &[T], n: usize) -> Vec<T> {
    if n == 0 {
        return Vec::new();
    }
    let vertices = numbers.len() / n;
    let mut tiles = vec![T::default(); vertices.next_multiple_of(TILE) * n];
    for (v, of_vertex) in numbers.chunks_exact(n).enumerate() {
        let tile = &mut tiles[v / TILE * TILE * n..];
        for (i, &number) in of_vertex.iter().enumerate() {
            tile[i * TILE + v % TILE] = number;
        }
    }
    tiles
}
