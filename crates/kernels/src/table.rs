//! The one table that every language's kernels are checked against: `cargo xtask kernels --check`.
use crate::{
    bands, beyond, clusters, detail, differences, fine_scale, large_scale, normals, strain,
    vector_differences,
};

/// Invocations in a workgroup, along x, of every kernel.
pub const WORKGROUP_SIZE: u32 = 64;

/// Frames that one invocation computes in a batch, where [`Entry::batched`] is true. The rig's data are then
/// read once for all of these frames. In a batch of one frame, an invocation computes one.
pub const FRAMES_AT_ONCE: u32 = 4;

/// A kernel's entry in the table. It is the same in every language.
#[derive(Debug, PartialEq, Eq)]
pub struct Entry {
    /// The entry point, and the stem of its files.
    pub name: &'static str,
    /// The fields of its parameter block, each a `u32`.
    pub params: &'static [&'static str],
    /// Its buffers, in the order of their bindings (Vulkan, WebGPU: set 0) and arguments (OpenCL). The
    /// parameter block comes after them: WebGPU has it at the next binding.
    pub bindings: &'static [Binding],
    /// What it computes, along x. In OpenCL the kernels of vertices have a macro `VERTICES`, which is the
    /// number of vertices of an invocation. It is `at_once`, or [`TILE`](crate::tile::TILE) where the device
    /// is a processor. The number of vertices of a workgroup is the same.
    pub each: Each,
    /// How many of these an invocation computes.
    pub at_once: u32,
    /// Whether an invocation computes several frames. If so, each language has a constant `FRAMES`, which is
    /// 1 or [`FRAMES_AT_ONCE`] (Vulkan: specialisation constant 0; WebGPU: `override`; OpenCL: a macro).
    pub batched: bool,
    /// GLSL, for Vulkan; `spirv` is made from it. Its entry point is renamed from `main`. In browsers it is
    /// empty, as SPIR-V and OpenCL C are.
    pub glsl: &'static str,
    /// SPIR-V 1.3 words in little-endian bytes, as `cargo xtask kernels` made them.
    pub spirv: &'static [u8],
    /// OpenCL C 1.2.
    pub opencl: &'static str,
    /// WGSL.
    pub wgsl: &'static str,
}

/// What a kernel computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Each {
    /// A result for each vertex of a part.
    Vertex,
    /// A result for each strain edge.
    StrainEdge,
    /// A result for each feature: for each strain edge, and for each handle as an anchor.
    Feature,
    /// A result for each row of the factors of all clusters.
    ClusterRow,
}

/// A buffer of a kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// Which buffer. The kernel [`Kernel::Normals`] runs on two pairs of buffers; the table has those of the
    /// last stage.
    pub buffer: Buffer,
    /// What it is an array of.
    pub element: Element,
    /// What the kernel does with it.
    pub access: Access,
    /// Whether GPUs keep it tiled, with only the vertices of one part (see the parameter `first_vertex`).
    pub tiled: bool,
}

/// The type of a buffer's elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element {
    /// `float`, `f32`.
    F32,
    /// `uint`, `u32`.
    U32,
    /// Two `u32` that are read together. The basis has them: a word is an `f32`, two fp16 numbers, or two
    /// integers of 16 bits. OpenCL has `uint`.
    U32x2,
    /// Four `f32` that are read together. OpenCL has `float`.
    F32x4,
}

/// What a kernel does with a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// It reads.
    Read,
    /// It writes, each element at most once.
    Write,
    /// It reads and writes, each element at most once and in one invocation.
    ReadWrite,
}

const fn read(buffer: Buffer, element: Element) -> Binding {
    Binding { buffer, element, access: Access::Read, tiled: false }
}

const fn tiled(buffer: Buffer, element: Element) -> Binding {
    Binding { buffer, element, access: Access::Read, tiled: true }
}

const fn write(buffer: Buffer) -> Binding {
    Binding { buffer, element: F32, access: Access::Write, tiled: false }
}

const fn change(buffer: Buffer) -> Binding {
    Binding { buffer, element: F32, access: Access::ReadWrite, tiled: false }
}

/// Makes [`Buffer`]: each variant with its name in every language.
macro_rules! buffers {
    ($($(#[$doc:meta])* $variant:ident = $name:ident),* $(,)?) => {
        /// The buffers of the kernels. Shapes and units are in the kernels' READMEs.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Buffer {
            $($(#[$doc])* $variant),*
        }

        impl Buffer {
            /// Every buffer.
            pub const ALL: [Self; [$(Self::$variant),*].len()] = [$(Self::$variant),*];

            /// Its name in every language.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => stringify!($name)),*
                }
            }
        }
    };
}

/// A program for browsers leaves out the sources for other APIs.
const BROWSER: bool = cfg!(target_arch = "wasm32");

/// Makes [`Kernel`]: each variant with the folder of its sources and the facts that the sources do not state.
macro_rules! kernels {
    ($(
        $(#[$doc:meta])*
        $variant:ident = $name:ident {
            each: $each:expr, at_once: $at_once:expr, batched: $batched:expr, bindings: [$($binding:expr),* $(,)?] $(,)?
        }
    )*) => {
        /// The kernels, in the order in which they first run.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Kernel {
            $($(#[$doc])* $variant),*
        }

        impl Kernel {
            /// Every kernel.
            pub const ALL: [Self; [$(Self::$variant),*].len()] = [$(Self::$variant),*];

            /// Its entry in the table.
            pub const fn entry(self) -> &'static Entry {
                match self {
                    $(Self::$variant => {
                        const ENTRY: Entry = Entry {
                            name: stringify!($name),
                            params: $name::Params::FIELDS,
                            bindings: &[$($binding),*],
                            each: $each,
                            at_once: $at_once,
                            batched: $batched,
                            glsl: if BROWSER { "" } else { include_str!(concat!(stringify!($name), "/", stringify!($name), ".comp")) },
                            spirv: if BROWSER { &[] } else { include_bytes!(concat!(stringify!($name), "/", stringify!($name), ".spv")) },
                            opencl: if BROWSER { "" } else { include_str!(concat!(stringify!($name), "/", stringify!($name), ".cl")) },
                            wgsl: include_str!(concat!(stringify!($name), "/", stringify!($name), ".wgsl")),
                        };
                        &ENTRY
                    })*
                }
            }
        }
    };
}

impl Kernel {
    /// Its name in every language: [`Entry::name`].
    pub const fn name(self) -> &'static str {
        self.entry().name
    }
}

use Buffer::*;
use Each::{ClusterRow, Feature, StrainEdge, Vertex};
use Element::{F32, F32x4, U32, U32x2};

buffers! {
    /// Where the vertices are at rest.
    Rest = rest,
    /// Where the handles are at rest.
    HandleRest = handle_rest,
    /// The two handles of each strain edge.
    StrainEdges = strain_edges,
    /// The strain edges' lengths at rest.
    RestLengths = rest_lengths,
    /// The centres' features.
    PoseFeatures = pose_features,
    /// The neighbour that orients each vertex's tangent frame.
    TangentNeighbors = tangent_neighbors,
    /// B, in f32 or fp16; or U of its clusters, in integers of 16 bits.
    Basis = basis,
    /// The first row of each tile's basis, and the first vector that it is multiplied by.
    BasisRows = basis_rows,
    /// W of the basis' clusters.
    ClusterBasis = cluster_basis,
    /// The first row of each tile's influences, and of its anchors behind them.
    InfluenceOffsets = influence_offsets,
    /// The strain edges and the anchors that influence any of a tile's vertices.
    Influences = influences,
    /// The weight of each of them for each of the tile's vertices.
    InfluenceWeights = influence_weights,
    /// The weights of the centres' distances.
    RbfWeights = rbf_weights,
    /// Each vertex's pivot: the centre whose distance is subtracted from the distances of the others.
    Pivots = pivots,
    /// The lengths that displacements are divided by: the strain edges', and their mean for the anchors.
    FeatureLengths = feature_lengths,
    /// The vector strains of the examples.
    ExampleVectors = example_vectors,
    /// The lengths up to which vector strains are followed.
    FeatureLimits = feature_limits,
    /// g: what each vector strain does to each vertex by way of the basis.
    FeatureGains = feature_gains,
    /// a and b, what is added to each vertex in every frame; then half of c and w, what each example does to
    /// it.
    BandWeights = band_weights,
    /// Where each tile's fans begin.
    FanOffsets = fan_offsets,
    /// The vertices around each of a tile's vertices.
    Fans = fans,
    /// Where the handles are in each frame.
    HandlePositions = handle_positions,
    /// How far they are from rest.
    Displacements = displacements,
    /// How much farther each frame's vector strains go than they are followed.
    VectorExcess = vector_excess,
    /// How the handles move the surface where they turn. It is bound in the place of the displacements.
    Motions = motions,
    /// W of the basis' clusters times the displacements, or times the motions. It is bound in their place.
    ClusterMotions = cluster_motions,
    /// How far each frame's features are from the centres', squared.
    SquaredDifferences = squared_differences,
    /// The strains.
    Features = features,
    /// How far each frame's vector strains are from the centres', squared.
    SquaredVectorDifferences = squared_vector_differences,
    /// What the linear band adds to the smooth positions that the basis gives.
    BandOffsets = band_offsets,
    /// The smooth positions.
    LargeScalePositions = large_scale_positions,
    /// Their normals.
    LargeScaleNormals = large_scale_normals,
    /// The detail in the tangent frames.
    LocalDetail = local_detail,
    /// The positions.
    Positions = positions,
    /// Their normals.
    VertexNormals = vertex_normals,
}

kernels! {
    /// Handle positions to features.
    Strain = strain {
        each: StrainEdge,
        at_once: 1,
        batched: false,
        bindings: [
            read(HandlePositions, F32),
            read(HandleRest, F32),
            read(StrainEdges, U32),
            read(RestLengths, F32),
            write(Features),
        ],
    }
    /// Displacements of the handles to squared differences of their vector strains from those of the centres.
    VectorDifferences = vector_differences {
        each: Feature,
        at_once: 1,
        batched: false,
        bindings: [
            read(Displacements, F32x4),
            read(StrainEdges, U32),
            read(FeatureLengths, F32),
            read(ExampleVectors, F32),
            read(FeatureLimits, F32),
            write(SquaredVectorDifferences),
        ],
    }
    /// Differences of vector strains to the fine detail: the linear band and the wrinkles.
    Bands = bands {
        each: Vertex,
        at_once: 1,
        batched: true,
        bindings: [
            read(SquaredVectorDifferences, F32x4),
            read(InfluenceOffsets, U32),
            read(Influences, U32),
            read(InfluenceWeights, U32),
            read(BandWeights, U32),
            write(BandOffsets),
            write(LocalDetail),
        ],
    }
    /// Takes back what the basis does beyond the rig's reach.
    Beyond = beyond {
        each: Vertex,
        at_once: 1,
        batched: false,
        bindings: [
            read(VectorExcess, F32x4),
            read(InfluenceOffsets, U32),
            read(Influences, U32),
            read(FeatureGains, F32),
            change(BandOffsets),
        ],
    }
    /// Displacements of the handles to what they do to each cluster of the basis.
    Clusters = clusters {
        each: ClusterRow,
        at_once: 1,
        batched: false,
        bindings: [
            read(ClusterBasis, F32),
            read(Displacements, F32x4),
            write(ClusterMotions),
        ],
    }
    /// Displacements of the handles to smooth positions.
    LargeScale = large_scale {
        each: Vertex,
        at_once: 4,
        batched: true,
        bindings: [
            read(Rest, F32),
            tiled(Basis, U32x2),
            read(BasisRows, U32),
            read(Displacements, F32x4),
            read(BandOffsets, F32),
            write(LargeScalePositions),
        ],
    }
    /// Positions to normals, large scale or final.
    Normals = normals {
        each: Vertex,
        at_once: 1,
        batched: false,
        bindings: [
            read(Positions, F32),
            read(FanOffsets, U32),
            read(Fans, U32),
            write(VertexNormals),
        ],
    }
    /// Features to their squared differences from those of the centres.
    Differences = differences {
        each: StrainEdge,
        at_once: 1,
        batched: false,
        bindings: [
            read(Features, F32),
            read(PoseFeatures, F32),
            write(SquaredDifferences),
        ],
    }
    /// Differences of features to details in the tangent frames.
    Detail = detail {
        each: Vertex,
        at_once: 1,
        batched: true,
        bindings: [
            read(SquaredDifferences, F32x4),
            read(InfluenceOffsets, U32),
            read(Influences, U32),
            read(InfluenceWeights, F32),
            tiled(RbfWeights, F32),
            tiled(Pivots, U32),
            write(LocalDetail),
        ],
    }
    /// Smooth positions and details to positions.
    FineScale = fine_scale {
        each: Vertex,
        at_once: 1,
        batched: false,
        bindings: [
            read(LargeScalePositions, F32),
            read(LargeScaleNormals, F32),
            read(LocalDetail, F32),
            read(TangentNeighbors, U32),
            write(Positions),
        ],
    }
}

/// What a device builds: each kernel, once for each of its values of `FRAMES`.
pub fn builds() -> impl Iterator<Item = (Kernel, u32)> {
    let both =
        |kernel: Kernel| [Some((kernel, 1)), kernel.entry().batched.then_some((kernel, FRAMES_AT_ONCE))];
    Kernel::ALL.into_iter().flat_map(both).flatten()
}
