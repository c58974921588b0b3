//! What every GPU backend does with a rig: which buffers it makes, what is in them, and which kernels it runs on them.
//! A backend adds how its API makes a buffer and runs a kernel, and nothing else.
mod contents;

use crate::{BasisStorage, DeviceErrorKind, Error, Result, Rig, Stage, UploadOptions};
use rhytid_kernels::table::{
    DETAIL, DIFFERENCES, Each, FINE_SCALE, FRAMES_AT_ONCE, Kernel, LARGE_SCALE, NORMALS, STRAIN, TILE,
    WORKGROUP_SIZE,
};
use rhytid_kernels::{detail, differences, fine_scale, large_scale, normals, strain};
use std::borrow::Cow;
use std::ops::Range;

/// The smallest buffer: some APIs refuse empty ones, and a rig may have no strain edges.
const SMALLEST_BUFFER: u64 = 16;

/// The bytes of a row of a tile: a number for each of its vertices.
const ROW: usize = TILE * 4;

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
    /// H×3.
    handle_rest: Vec<[f32; 3]>,
    parts: Vec<Range<usize>>,
    /// Where the rows of each tile's fans begin, and where the last ones end.
    fan_offsets: Vec<u32>,
    /// The same of its influences.
    influence_offsets: Vec<u32>,
    max_frames: usize,
    frames_per_slice: usize,
    buffers: Vec<PlannedBuffer>,
}

#[derive(Debug, Clone, Copy)]
struct Sizes {
    vertices: usize,
    handles: usize,
    edges: usize,
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
    /// Filled for each batch, from [`Plan::inputs`].
    Input {
        /// Which slice.
        slice: usize,
    },
    /// Written by a kernel for another, and not for the host.
    Scratch {
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
    /// The indices of the buffers of their results, in the order of [`Stage::ALL`].
    pub results: [usize; 6],
}

/// What a buffer is filled with for a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Input<'a> {
    /// The index of the buffer.
    pub buffer: usize,
    /// What it starts with from now on.
    pub numbers: Cow<'a, [f32]>,
}

/// One run of a kernel.
#[derive(Debug, Clone, PartialEq)]
pub struct Dispatch {
    /// Which kernel.
    pub kernel: &'static Kernel,
    /// Frames of an invocation, the kernel's constant `FRAMES`: 1 where it has none.
    pub frames_at_once: u32,
    /// The stage that it computes, or a part of it. It needs the stages before it finished, and of its own stage the
    /// dispatches of another kernel before it.
    pub stage: Stage,
    /// The indices of its buffers, in the order of its bindings.
    pub buffers: Vec<usize>,
    /// Its parameter block.
    pub params: Vec<u32>,
    /// Workgroups along x and y; z has one.
    pub workgroups: [u32; 2],
}

impl Dispatch {
    /// Whether this needs `before`, the dispatch before it, finished.
    pub fn follows(&self, before: &Self) -> bool {
        (self.stage, self.kernel.name) != (before.stage, before.kernel.name)
    }
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
        let tile_bytes = TILE * basis_bytes.max(sizes.centers * 12);
        if tile_bytes > limit {
            return Err(unsupported("a binding of 16 vertices, in bytes,", tile_bytes, limit));
        }
        let (fan_offsets, influence_offsets) = (contents::fan_offsets(rig), contents::influence_offsets(rig));
        let most_tiles = (limit / tile_bytes).min(most_vertices / TILE).max(1);
        let bytes_of_rows = |part: &Range<usize>| {
            [&fan_offsets, &influence_offsets].map(|offsets| rows(offsets, part).len() * ROW)
        };
        let parts = parts(sizes.vertices, |part| {
            part.len() <= most_tiles * TILE && bytes_of_rows(part).iter().all(|&bytes| bytes <= limit)
        });
        let frame_bytes = (sizes.vertices * 12).max(sizes.handles * 16).max(sizes.table_len() * 4);
        let row_bytes = parts.iter().flat_map(bytes_of_rows).max().unwrap_or(0);
        let whole = frame_bytes.max(row_bytes).max(sizes.edges * 8);
        if whole > limit {
            return Err(unsupported("a binding, in bytes,", whole, limit));
        }
        let frames_per_slice =
            (limit / frame_bytes).min(limits.max_workgroups as usize).min(options.max_frames);

        let mut plan = Self {
            sizes,
            half_basis,
            handle_rest: rig.handles.iter().map(|&v| rig.rest[v as usize]).collect(),
            parts,
            fan_offsets,
            influence_offsets,
            max_frames: options.max_frames,
            frames_per_slice,
            buffers: Vec::new(),
        };
        plan.plan_buffers();
        Ok(plan)
    }

    fn plan_buffers(&mut self) {
        let Sizes { vertices, handles, edges, centers } = self.sizes;
        let table_len = self.sizes.table_len();
        let mut add = |name: &'static str, bytes: usize, role: Role| {
            let bytes = (bytes as u64).max(SMALLEST_BUFFER);
            self.buffers.push(PlannedBuffer { name, bytes, role });
        };
        for (name, bytes) in [
            ("rest", vertices * 12),
            ("handle_rest", handles * 12),
            ("strain_edges", edges * 8),
            ("rest_lengths", edges * 4),
            ("pose_features", centers * edges * 4),
            ("frame_neighbors", vertices * 4),
        ] {
            add(name, bytes, Role::Constant { part: None });
        }
        let basis_bytes = if self.half_basis { 2 } else { 4 };
        for part in &self.parts {
            let tiled = part.len().next_multiple_of(TILE);
            let offsets = part.len().div_ceil(TILE) + 1;
            let influences = rows(&self.influence_offsets, part).len();
            for (name, bytes) in [
                ("basis", tiled * handles * basis_bytes),
                ("influence_offsets", offsets * 4),
                ("influence_edges", influences * 4),
                ("influence_weights", influences * ROW),
                ("rbf_weights", tiled * centers * 12),
                ("pivots", tiled * 4),
                ("fan_offsets", offsets * 4),
                ("fans", rows(&self.fan_offsets, part).len() * ROW),
            ] {
                add(name, bytes, Role::Constant { part: Some(part.clone()) });
            }
        }
        for slice in 0..self.max_frames.div_ceil(self.frames_per_slice) {
            let frames = self.frames_per_slice.min(self.max_frames - slice * self.frames_per_slice);
            add("handle_positions", frames * handles * 12, Role::Input { slice });
            add("displacements", frames * handles * 16, Role::Input { slice });
            add("squared_differences", frames * table_len * 4, Role::Scratch { slice });
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

    /// The slices of a batch of `frames` frames, at most as many as there is room for.
    pub fn slices(&self, frames: usize) -> impl Iterator<Item = Slice> {
        (0..frames.div_ceil(self.frames_per_slice)).map(move |slice| {
            let first = slice * self.frames_per_slice;
            Slice {
                frames: first..(first + self.frames_per_slice).min(frames),
                results: Stage::ALL.map(|stage| self.find(result_name(stage), None, slice)),
            }
        })
    }

    /// The bytes of one frame of a stage's result.
    pub fn frame_bytes(&self, stage: Stage) -> usize {
        4 * if stage == Stage::Strain { self.sizes.edges } else { self.sizes.vertices * 3 }
    }

    /// The numbers of one frame's handle positions.
    pub fn values_per_frame(&self) -> usize {
        self.sizes.handles * 3
    }

    /// The bytes of all inputs of a frame.
    pub fn input_bytes(&self) -> usize {
        self.sizes.handles * (12 + 16)
    }

    /// What to run for a batch of `frames` frames, in this order. The dispatches of a smaller batch are the first ones
    /// of a larger one, but for their parameters, frames at once and workgroups: kernels and buffers are the same.
    pub fn dispatches(&self, frames: usize) -> Vec<Dispatch> {
        let mut dispatches = Vec::new();
        for (slice, Slice { frames, .. }) in self.slices(frames).enumerate() {
            let frames = frames.len() as u32;
            let frames_of = |kernel: &Kernel| if kernel.batched && frames > 1 { FRAMES_AT_ONCE } else { 1 };
            for (stage, kernel) in STEPS {
                // These are never split.
                let edges = 0..self.sizes.edges;
                let parts = match kernel.each {
                    Each::StrainEdge => std::slice::from_ref(&edges),
                    Each::Vertex => &self.parts[..],
                };
                let frames_at_once = frames_of(kernel);
                for part in parts.iter().filter(|part| !part.is_empty()) {
                    let buffers = kernel.bindings.iter();
                    let buffers = buffers.map(|b| self.find(bound_name(stage, b.name), Some(part), slice));
                    let in_workgroup = WORKGROUP_SIZE * kernel.at_once;
                    dispatches.push(Dispatch {
                        kernel,
                        frames_at_once,
                        stage,
                        buffers: buffers.collect(),
                        params: self.params(kernel, frames, part),
                        workgroups: [
                            (part.len() as u32).div_ceil(in_workgroup),
                            frames.div_ceil(frames_at_once),
                        ],
                    });
                }
            }
        }
        dispatches
    }

    /// The parameters of `kernel` for `part`.
    fn params(&self, kernel: &Kernel, frames: u32, part: &Range<usize>) -> Vec<u32> {
        let Sizes { vertices, handles, edges, centers } = self.sizes;
        let [vertices, handles, strain_edges, centers] =
            [vertices, handles, edges, centers].map(|n| n as u32);
        let (first_vertex, part_vertices) = (part.start as u32, part.len() as u32);
        match kernel.name {
            "strain" => words(&strain::Params { frames, handles, strain_edges }),
            "large_scale" => words(&large_scale::Params {
                frames,
                vertices,
                first_vertex,
                part_vertices,
                handles,
                half_basis: u32::from(self.half_basis),
            }),
            "normals" => words(&normals::Params { frames, vertices, first_vertex, part_vertices }),
            "differences" => words(&differences::Params { frames, strain_edges, centers }),
            "detail" => words(&detail::Params {
                frames,
                vertices,
                first_vertex,
                part_vertices,
                strain_edges,
                centers,
            }),
            "fine_scale" => words(&fine_scale::Params { frames, vertices, first_vertex, part_vertices }),
            name => unreachable!("no kernel is called {name}"),
        }
    }

    /// The buffer of this name; `part` and `slice` are heeded where there is one for each.
    fn find(&self, name: &str, part: Option<&Range<usize>>, slice: usize) -> usize {
        let found = self.buffers.iter().position(|buffer| {
            buffer.name == name
                && match &buffer.role {
                    Role::Constant { part: None } => true,
                    Role::Constant { part: of } => of.as_ref() == part,
                    Role::Input { slice: of }
                    | Role::Scratch { slice: of }
                    | Role::Result { slice: of, .. } => *of == slice,
                }
        });
        found.unwrap_or_else(|| unreachable!("every buffer of a kernel is planned, {name} too"))
    }
}

impl Sizes {
    /// The numbers of a frame's `squared_differences`.
    fn table_len(&self) -> usize {
        differences::table_len(self.edges, self.centers)
    }
}

/// What runs, one after the other.
const STEPS: [(Stage, &Kernel); 7] = [
    (Stage::Strain, &STRAIN),
    (Stage::LargeScale, &LARGE_SCALE),
    (Stage::LargeScaleNormals, &NORMALS),
    (Stage::Detail, &DIFFERENCES),
    (Stage::Detail, &DETAIL),
    (Stage::Positions, &FINE_SCALE),
    (Stage::Normals, &NORMALS),
];

/// Cuts the vertices into parts of whole tiles, as long as they fit.
fn parts(vertices: usize, fits: impl Fn(&Range<usize>) -> bool) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    for first in (0..vertices).step_by(TILE) {
        let end = (first + TILE).min(vertices);
        match parts.last_mut() {
            Some(part) if fits(&(part.start..end)) => part.end = end,
            _ => parts.push(first..end),
        }
    }
    parts
}

/// The rows of a part's tiles, given where each tile's begin.
fn rows(offsets: &[u32], part: &Range<usize>) -> Range<usize> {
    offsets[part.start / TILE] as usize..offsets[part.end.div_ceil(TILE)] as usize
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
