//! The plan of what every GPU backend does with a rig: the buffers, their contents, and the kernels that run
//! on them. A backend adds only how its API makes a buffer and runs a kernel.
mod contents;
mod extent;
mod planned;
mod reach;

use crate::{
    BandWeights, BasisStorage, ClusteredBasis, DeviceErrorKind, Error, Result, Rig, Rotations, Stage,
    UploadOptions,
};
use extent::{Extent, extent};
pub use planned::{Dispatch, Input, PlannedBuffer, Role, Slice};
use reach::Limits;
use rhytid_kernels::large_scale::MOTION;
use rhytid_kernels::table::{Buffer, Each, FRAMES_AT_ONCE, Kernel, WORKGROUP_SIZE};
use rhytid_kernels::tile::TILE;
use rhytid_kernels::{
    bands, beyond, clusters, detail, differences, fine_scale, large_scale, normals, strain,
    vector_differences,
};
use std::ops::Range;

/// The smallest buffer: some APIs refuse empty ones, and a rig may have no strain edges.
const SMALLEST_BUFFER: u64 = 16;

/// The bytes of a row: a number for each vertex of a tile.
const ROW_BYTES: usize = TILE * 4;

/// Kernels count in 32 bits. So no array is larger than this, even if the device allows it.
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
/// If an array per vertex is larger than a binding, it is split into *parts*, ranges of vertices. If a
/// batch's results are larger than a binding, the batch is split into *slices*, ranges of frames. Most rigs
/// on most devices have one part and one slice.
#[derive(Debug, Clone)]
pub struct Plan {
    sizes: Sizes,
    storage: BasisStorage,
    /// Where the basis is in clusters.
    clusters: Option<Box<ClusteredBasis>>,
    /// The first row of each tile's basis and the first vector that it is multiplied by, and the end of the
    /// rows.
    basis_rows: Vec<u32>,
    /// Empty where the rig has no bands.
    band_weights: Box<BandWeights>,
    /// H×3.
    handle_rest: Vec<[f32; 3]>,
    /// `None` where the handles do not turn. It is in a box, since the handles of few rigs turn.
    rotations: Option<Box<Rotations>>,
    /// The vertex that they turn about. 0 where they do not turn.
    center: u32,
    /// Where a part of the basis is limited.
    limits: Option<Box<Limits>>,
    parts: Vec<Range<usize>>,
    /// The first row of each tile's fans, and the end of the last ones.
    fan_offsets: Vec<u32>,
    /// The first row of each tile's influences and of its anchors, and the end of the last ones.
    influence_offsets: Vec<u32>,
    /// Whether the rig is of the learned method: its wrinkles are zero at rest.
    zero_at_rest: bool,
    max_frames: usize,
    frames_per_slice: usize,
    buffers: Vec<PlannedBuffer>,
}

#[derive(Debug, Clone, Copy)]
struct Sizes {
    vertices: usize,
    handles: usize,
    /// The vectors of a frame that the basis is multiplied by: H, or R where it is in clusters.
    motions: usize,
    edges: usize,
    centers: usize,
    /// Whether a part of the basis is followed only up to the rig's reach.
    limits_basis: bool,
    /// Whether the rig has bands. `vector_wrinkles` tells whether the bands include the wrinkles.
    bands: bool,
    vector_wrinkles: bool,
    /// How many vectors of each handle the large scale reads in a frame.
    vectors: usize,
}

impl Plan {
    /// Plans `rig` for a device with these limits; `device` names it in errors.
    ///
    /// # Errors
    /// [`Error::Device`], `Unsupported`, if one tile or one frame alone is larger than the device's limits.
    pub fn new(rig: &Rig, options: UploadOptions, limits: PlanLimits, device: &str) -> Result<Self> {
        let clusters = (options.basis == BasisStorage::Clustered).then(|| Box::new(ClusteredBasis::new(rig)));
        let sizes = Sizes {
            vertices: rig.vertices(),
            handles: rig.handles().len(),
            motions: clusters.as_ref().map_or(rig.handles().len(), |clusters| clusters.rows()),
            edges: rig.handles().strain_edges.len(),
            centers: rig.centers(),
            limits_basis: rig.limits_basis(),
            bands: rig.bands().is_some(),
            vector_wrinkles: rig.vector_wrinkles(),
            vectors: if rig.handles().rotations { MOTION } else { 1 },
        };
        let limit = limits.max_binding_bytes.min(LARGEST_BINDING) as usize;
        let unsupported = |what: &str, needs: usize, has: usize| Error::Device {
            kind: DeviceErrorKind::Unsupported,
            device: device.to_owned(),
            message: format!("the rig needs {needs} {what}, and this device has at most {has}"),
        };
        let workgroup = WORKGROUP_SIZE as usize;
        let most_vertices = (limits.max_workgroups as usize).saturating_mul(workgroup);
        let longest = if sizes.bands { sizes.features() } else { sizes.edges };
        if longest > most_vertices {
            return Err(unsupported("strain edges and handles", longest, most_vertices));
        }
        if clusters.is_some() && sizes.motions > most_vertices {
            return Err(unsupported("rows of clusters", sizes.motions, most_vertices));
        }

        let rank = clusters.as_ref().map_or(sizes.handles, |clusters| clusters.highest_rank());
        let basis_bytes = rank * entry_bytes(options.basis);
        let tile_bytes = TILE * basis_bytes.max(sizes.centers * 12);
        if tile_bytes > limit {
            return Err(unsupported("bytes of 16 vertices in one buffer binding", tile_bytes, limit));
        }
        let (fan_offsets, influence_offsets) = (contents::fan_offsets(rig), contents::influence_offsets(rig));
        let band_weights = Box::new(BandWeights::new(rig, options.basis));
        let most_tiles = (limit / tile_bytes).min(most_vertices / TILE).max(1);
        let bytes_of_rows = |part: &Range<usize>| {
            let [fans, influences] = [rows(&fan_offsets, part, 1), rows(&influence_offsets, part, 2)]
                .map(|rows| rows.len() * ROW_BYTES);
            [fans, influences, band_weights.bytes_of(&tiles_of(part))]
        };
        let parts = parts(sizes.vertices, |part| {
            part.len() <= most_tiles * TILE && bytes_of_rows(part).iter().all(|&bytes| bytes <= limit)
        });
        let frame_bytes = (sizes.vertices * 12)
            .max(sizes.vectors * sizes.handles.max(sizes.motions) * 16)
            .max(if sizes.limits_basis { sizes.features() * 16 } else { 0 })
            .max(sizes.table_len() * 4)
            .max(sizes.vector_table_len() * 4);
        let bytes_of_rows = parts.iter().flat_map(bytes_of_rows).max().unwrap_or(0);
        let of_bands = if sizes.bands { (sizes.centers - 1).max(2) * sizes.features() * 12 } else { 0 };
        let of_clusters = if clusters.is_some() { sizes.motions * sizes.handles * 4 } else { 0 };
        let whole = frame_bytes.max(bytes_of_rows).max(sizes.edges * 8).max(of_bands).max(of_clusters);
        if whole > limit {
            return Err(unsupported("bytes in one buffer binding", whole, limit));
        }
        // The kernel `clusters` has a row of workgroups for each vector of a handle in a frame.
        let of_frame = if clusters.is_some() { sizes.vectors } else { 1 };
        let most_frames = (limits.max_workgroups as usize / of_frame).max(1);
        let frames_per_slice = (limit / frame_bytes).min(most_frames).min(options.max_frames);

        let rotations = Rotations::new(rig.handles()).map(Box::new);
        let center = rotations
            .as_ref()
            .map_or(0, |rotations| rig.handles().points[rotations.center()].nearest_vertex().0);
        let mut plan = Self {
            sizes,
            storage: options.basis,
            basis_rows: basis_rows(&sizes, clusters.as_deref()),
            clusters,
            band_weights,
            handle_rest: rig.handles().rest.clone(),
            rotations,
            center,
            limits: rig.limits_basis().then(|| Box::new(Limits::new(rig))),
            parts,
            fan_offsets,
            influence_offsets,
            zero_at_rest: rig.learned().is_some(),
            max_frames: options.max_frames,
            frames_per_slice,
            buffers: Vec::new(),
        };
        plan.plan_buffers();
        Ok(plan)
    }

    fn plan_buffers(&mut self) {
        let mut planned = Vec::new();
        let mut add = |buffer, role: Role, bytes: usize| {
            let bytes = (bytes as u64).max(SMALLEST_BUFFER);
            planned.push(PlannedBuffer { buffer, bytes, role });
        };
        let bound: Vec<Buffer> = self
            .steps()
            .flat_map(|(stage, kernel)| {
                let bindings = kernel.entry().bindings.iter();
                bindings.map(move |binding| (stage, kernel, binding.buffer))
            })
            .map(|(stage, kernel, buffer)| self.buffer_for(stage, kernel, buffer))
            .collect();
        let is_planned = |buffer: &Buffer| bound.contains(buffer);
        let of = |all: Extent| {
            Buffer::ALL.into_iter().filter(is_planned).filter(move |&buffer| extent(buffer) == all)
        };
        for buffer in of(Extent::Rig) {
            add(buffer, Role::Constant { part: None }, self.bytes_of(buffer, &(0..self.sizes.vertices), 0));
        }
        for part in &self.parts {
            for buffer in of(Extent::Part) {
                add(buffer, Role::Constant { part: Some(part.clone()) }, self.bytes_of(buffer, part, 0));
            }
        }
        for slice in 0..self.max_frames.div_ceil(self.frames_per_slice) {
            let frames = self.frames_per_slice.min(self.max_frames - slice * self.frames_per_slice);
            for buffer in Buffer::ALL.into_iter().filter(is_planned) {
                let role = match extent(buffer) {
                    Extent::Rig | Extent::Part => continue,
                    Extent::Input => Role::Input { slice },
                    Extent::Scratch => Role::Scratch { slice },
                    Extent::Result(stage) => Role::Result { slice, stage },
                };
                add(buffer, role, self.bytes_of(buffer, &(0..self.sizes.vertices), frames));
            }
        }
        self.buffers = planned;
    }

    /// The bytes of a buffer for the vertices of a part and this many frames.
    fn bytes_of(&self, buffer: Buffer, part: &Range<usize>, frames: usize) -> usize {
        let Sizes { vertices, handles, edges, centers, .. } = self.sizes;
        let (tiles, tiled) = (part.len().div_ceil(TILE), part.len().next_multiple_of(TILE));
        match buffer {
            Buffer::Rest => vertices * 12,
            Buffer::HandleRest => handles * 12,
            Buffer::StrainEdges => edges * 8,
            Buffer::RestLengths => edges * 4,
            Buffer::PoseFeatures => centers * edges * 4,
            Buffer::TangentNeighbors => vertices * 4,
            Buffer::Basis => rows(&self.basis_rows, part, 2).len() * TILE * entry_bytes(self.storage),
            Buffer::BasisRows => (2 * tiles + 1) * 4,
            Buffer::ClusterBasis => self.sizes.motions * handles * 4,
            Buffer::ClusterMotions => frames * self.sizes.vectors * self.sizes.motions * 16,
            Buffer::InfluenceOffsets => (2 * tiles + 1) * 4,
            Buffer::FanOffsets => (tiles + 1) * 4,
            Buffer::Influences => rows(&self.influence_offsets, part, 2).len() * 4,
            Buffer::InfluenceWeights => {
                let bytes = if self.narrow() { ROW_BYTES / 2 } else { ROW_BYTES };
                rows(&self.influence_offsets, part, 2).len() * bytes
            }
            Buffer::FeatureGains => rows(&self.influence_offsets, part, 2).len() * ROW_BYTES,
            Buffer::RbfWeights => tiled * centers * 12,
            Buffer::Pivots => tiled * 4,
            Buffer::FeatureLengths | Buffer::FeatureLimits => self.sizes.features() * 4,
            Buffer::ExampleVectors => (centers - 1) * self.sizes.features() * 12,
            Buffer::BandWeights => self.band_weights.bytes_of(&tiles_of(part)),
            Buffer::SquaredVectorDifferences => frames * self.sizes.vector_table_len() * 4,
            Buffer::Fans => rows(&self.fan_offsets, part, 1).len() * ROW_BYTES,
            Buffer::HandlePositions => frames * handles * 12,
            Buffer::Displacements => frames * handles * 16,
            Buffer::VectorExcess => frames * self.sizes.features() * 16,
            Buffer::Motions => frames * MOTION * handles * 16,
            Buffer::SquaredDifferences => frames * self.sizes.table_len() * 4,
            Buffer::Features => frames * edges * 4,
            Buffer::BandOffsets
            | Buffer::LargeScalePositions
            | Buffer::LargeScaleNormals
            | Buffer::LocalDetail
            | Buffer::Positions
            | Buffer::VertexNormals => frames * vertices * 12,
        }
    }

    /// The buffers to make. Everywhere else a buffer is named by its index in this list.
    pub fn buffers(&self) -> &[PlannedBuffer] {
        &self.buffers
    }

    /// Where the handles turn, the vertex whose rest position they turn about. 0 elsewhere.
    pub fn center(&self) -> u32 {
        self.center
    }

    /// The size of all buffers together.
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes).sum()
    }

    /// The slices of a batch of `frames` frames, at most [`UploadOptions::max_frames`].
    pub fn slices(&self, frames: usize) -> impl Iterator<Item = Slice> {
        (0..frames.div_ceil(self.frames_per_slice)).map(move |slice| {
            let first = slice * self.frames_per_slice;
            Slice {
                frames: first..(first + self.frames_per_slice).min(frames),
                results: Stage::ALL
                    .map(|stage| self.find(|planned| planned.role == Role::Result { slice, stage })),
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
        let Sizes { handles, bands, vectors, limits_basis, .. } = self.sizes;
        // Where the handles turn, the bands alone read displacements.
        let of_bands = usize::from(bands && self.rotations.is_some());
        let excess = if limits_basis { self.sizes.features() } else { 0 };
        handles * (12 + 16 * (vectors + of_bands)) + 16 * excess
    }

    /// What to run for a batch of `frames` frames, in this order. Dispatches of a stage [on
    /// demand](Plan::is_on_demand) run when that stage is read. The dispatches of a smaller batch are the
    /// first ones of a larger batch, with the same kernels and buffers. Only their parameters, frames at once
    /// and workgroups differ.
    pub fn dispatches(&self, frames: usize) -> Vec<Dispatch> {
        let mut dispatches = Vec::new();
        for (slice, Slice { frames, .. }) in self.slices(frames).enumerate() {
            let frames = frames.len() as u32;
            for (stage, kernel) in self.steps() {
                let entry = kernel.entry();
                // These are never split.
                let (edges, features) = (0..self.sizes.edges, 0..self.sizes.features());
                let rows = 0..self.sizes.motions;
                let parts = match entry.each {
                    Each::StrainEdge => std::slice::from_ref(&edges),
                    Each::Feature => std::slice::from_ref(&features),
                    Each::ClusterRow => std::slice::from_ref(&rows),
                    Each::Vertex => &self.parts[..],
                };
                // Where the handles turn, the code that sums four frames sums the four vectors of one frame.
                let of_frame = match kernel {
                    Kernel::LargeScale | Kernel::Clusters => self.sizes.vectors as u32,
                    _ => 1,
                };
                let frames_at_once = if entry.batched && of_frame * frames > 1 { FRAMES_AT_ONCE } else { 1 };
                for part in parts.iter().filter(|part| !part.is_empty()) {
                    let buffers = entry.bindings.iter();
                    let buffers =
                        buffers.map(|b| self.bound(self.buffer_for(stage, kernel, b.buffer), part, slice));
                    let in_workgroup = WORKGROUP_SIZE * entry.at_once;
                    dispatches.push(Dispatch {
                        kernel,
                        frames_at_once,
                        stage,
                        buffers: buffers.collect(),
                        params: self.params(kernel, frames, part),
                        workgroups: [
                            (part.len() as u32).div_ceil(in_workgroup),
                            (of_frame * frames).div_ceil(frames_at_once),
                        ],
                    });
                }
            }
        }
        dispatches
    }

    /// Whether a batch leaves this stage out. [`crate::Session::read`] then runs its dispatches. This holds
    /// for the normals of the large scale where wrinkles are along the mesh's axes: no kernel reads them
    /// then.
    pub fn is_on_demand(&self, stage: Stage) -> bool {
        stage == Stage::LargeScaleNormals && self.sizes.vector_wrinkles
    }

    /// Whether the weights of influences have 16 bits.
    fn narrow(&self) -> bool {
        self.storage.has_narrow_weights(self.sizes.vector_wrinkles)
    }

    /// The parameters of `kernel` for `part`.
    fn params(&self, kernel: Kernel, frames: u32, part: &Range<usize>) -> Vec<u32> {
        let Sizes { vertices, handles, motions, edges, centers, bands, vector_wrinkles, vectors, .. } =
            self.sizes;
        let [vertices, handles, motions, strain_edges, centers, features] =
            [vertices, handles, motions, edges, centers, self.sizes.features()].map(|n| n as u32);
        let (first_vertex, part_vertices) = (part.start as u32, part.len() as u32);
        match kernel {
            Kernel::Strain => words(&strain::Params { frames, handles, strain_edges }),
            Kernel::VectorDifferences => {
                words(&vector_differences::Params { frames, handles, strain_edges, centers })
            }
            Kernel::Bands => words(&bands::Params {
                frames,
                vertices,
                first_vertex,
                part_vertices,
                features,
                centers,
                narrow: u32::from(self.narrow()),
                wrinkles: u32::from(vector_wrinkles),
            }),
            Kernel::Beyond => {
                words(&beyond::Params { frames, vertices, first_vertex, part_vertices, features })
            }
            Kernel::Clusters => {
                words(&clusters::Params { frames: frames * vectors as u32, handles, cluster_rows: motions })
            }
            Kernel::LargeScale => words(&large_scale::Params {
                frames,
                vertices,
                first_vertex,
                part_vertices,
                motions,
                basis_format: match self.storage {
                    BasisStorage::F32 => 0,
                    BasisStorage::F16 => 1,
                    BasisStorage::Clustered => 2,
                },
                banded: u32::from(bands),
                rotating: u32::from(vectors == MOTION),
                center: self.center,
            }),
            Kernel::Normals => words(&normals::Params { frames, vertices, first_vertex, part_vertices }),
            Kernel::Differences => words(&differences::Params { frames, strain_edges, centers }),
            Kernel::Detail => words(&detail::Params {
                frames,
                vertices,
                first_vertex,
                part_vertices,
                strain_edges,
                centers,
                zero_at_rest: u32::from(self.zero_at_rest),
            }),
            Kernel::FineScale => words(&fine_scale::Params {
                frames,
                vertices,
                first_vertex,
                part_vertices,
                mesh_axes: u32::from(vector_wrinkles),
            }),
        }
    }

    /// The index of the planned `buffer`. `part` and `slice` select among several.
    fn bound(&self, buffer: Buffer, part: &Range<usize>, slice: usize) -> usize {
        self.find(|planned| {
            planned.buffer == buffer
                && match &planned.role {
                    Role::Constant { part: of } => of.as_ref().is_none_or(|of| of == part),
                    Role::Input { slice: of }
                    | Role::Scratch { slice: of }
                    | Role::Result { slice: of, .. } => *of == slice,
                }
        })
    }

    /// What runs, one after the other.
    fn steps(&self) -> impl Iterator<Item = (Stage, Kernel)> {
        let Sizes { bands, vector_wrinkles, limits_basis, .. } = self.sizes;
        STEPS.into_iter().filter(move |(_, kernel)| match kernel {
            Kernel::Beyond => limits_basis,
            Kernel::Clusters => self.clusters.is_some(),
            Kernel::VectorDifferences | Kernel::Bands => bands,
            Kernel::Differences | Kernel::Detail => !vector_wrinkles,
            _ => true,
        })
    }

    /// The buffer that is bound in the place of `buffer`. The kernel `normals` runs on two pairs of buffers.
    /// Without bands, the kernel `large_scale` does not read their offsets, and another buffer is bound.
    /// Where the handles turn, it reads motions in place of displacements. Where the basis is in clusters, it
    /// reads their motions.
    fn buffer_for(&self, stage: Stage, kernel: Kernel, buffer: Buffer) -> Buffer {
        match (stage, buffer) {
            (Stage::LargeScaleNormals, Buffer::Positions) => Buffer::LargeScalePositions,
            (Stage::LargeScaleNormals, Buffer::VertexNormals) => Buffer::LargeScaleNormals,
            (_, Buffer::BandOffsets) if kernel == Kernel::LargeScale && !self.sizes.bands => {
                Buffer::HandleRest
            }
            (_, Buffer::Displacements) if kernel == Kernel::LargeScale && self.clusters.is_some() => {
                Buffer::ClusterMotions
            }
            (_, Buffer::Displacements)
                if matches!(kernel, Kernel::LargeScale | Kernel::Clusters) && self.rotations.is_some() =>
            {
                Buffer::Motions
            }
            _ => buffer,
        }
    }

    fn find(&self, is: impl Fn(&PlannedBuffer) -> bool) -> usize {
        let found = self.buffers.iter().position(is);
        found.unwrap_or_else(|| unreachable!("every buffer of a kernel is planned"))
    }
}

impl Sizes {
    /// The numbers of a frame's `squared_differences`.
    fn table_len(&self) -> usize {
        differences::table_len(self.edges, self.centers)
    }

    /// F + H.
    fn features(&self) -> usize {
        self.edges + self.handles
    }

    /// The numbers of a frame's `squared_vector_differences`; 0 where there are no bands.
    fn vector_table_len(&self) -> usize {
        if self.bands { differences::table_len(self.features(), self.centers) } else { 0 }
    }
}

/// What can run, one after the other.
const STEPS: [(Stage, Kernel); 11] = [
    (Stage::Strain, Kernel::Strain),
    (Stage::LargeScale, Kernel::VectorDifferences),
    (Stage::LargeScale, Kernel::Bands),
    (Stage::LargeScale, Kernel::Beyond),
    (Stage::LargeScale, Kernel::Clusters),
    (Stage::LargeScale, Kernel::LargeScale),
    (Stage::LargeScaleNormals, Kernel::Normals),
    (Stage::Detail, Kernel::Differences),
    (Stage::Detail, Kernel::Detail),
    (Stage::Positions, Kernel::FineScale),
    (Stage::Normals, Kernel::Normals),
];

/// The tiles of a part.
fn tiles_of(part: &Range<usize>) -> Range<usize> {
    part.start / TILE..part.end.div_ceil(TILE)
}

/// Cuts the vertices into parts of whole tiles. Each part has as many tiles as fit.
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

/// The bytes of a number of the basis.
fn entry_bytes(storage: BasisStorage) -> usize {
    match storage {
        BasisStorage::F32 => 4,
        BasisStorage::F16 | BasisStorage::Clustered => 2,
    }
}

/// The first row of each tile's basis and the first vector that it is multiplied by, and the end of the rows.
fn basis_rows(sizes: &Sizes, clusters: Option<&ClusteredBasis>) -> Vec<u32> {
    let mut rows = Vec::new();
    let mut end = 0;
    for tile in 0..sizes.vertices.div_ceil(TILE) {
        let of_tile = clusters
            .map_or(0..sizes.handles, |clusters| clusters.rows_of(tile * TILE / ClusteredBasis::VERTICES));
        rows.extend([end, of_tile.start as u32]);
        end += of_tile.len() as u32;
    }
    rows.push(end);
    rows
}

/// The rows of a part's tiles. `offsets` has the first row of each tile for each of the `lists`.
fn rows(offsets: &[u32], part: &Range<usize>, lists: usize) -> Range<usize> {
    let tiles = tiles_of(part);
    offsets[lists * tiles.start] as usize..offsets[lists * tiles.end] as usize
}

fn words<T: bytemuck::NoUninit>(params: &T) -> Vec<u32> {
    bytemuck::cast_slice(std::slice::from_ref(params)).to_vec()
}
