//! The one table that every language's kernels are checked against: `cargo xtask kernels --check`.
use crate::{detail, differences, fine_scale, large_scale, normals, strain};

/// Invocations in a workgroup, along x, of every kernel.
pub const WORKGROUP_SIZE: u32 = 64;

/// Vertices in a tile on a GPU. An array of n numbers per vertex that is *tiled* is stored as `[⌈V/16⌉][n][16]`, the
/// numbers past V being zero: neighbouring invocations read neighbouring words, at least 32 bytes of them, and a processor
/// behind a GPU's API, which computes one tile after the other, reads memory from its start to its end.
pub const TILE: usize = 16;

/// Frames that one invocation computes in a batch, where [`Kernel::batched`] says so: what it reads of the rig is read once
/// for all of them. Of a batch of one frame it computes one.
pub const FRAMES_AT_ONCE: u32 = 4;

/// A kernel in every language.
#[derive(Debug, PartialEq, Eq)]
pub struct Kernel {
    /// The entry point, and the stem of its files.
    pub name: &'static str,
    /// The fields of its parameter block, each a `u32`.
    pub params: &'static [&'static str],
    /// Its buffers, in the order of their bindings (Vulkan, WebGPU: set 0) and arguments (OpenCL). The parameter
    /// block comes after them: WebGPU has it at the next binding.
    pub bindings: &'static [Binding],
    /// What it computes, along x. In OpenCL the kernels of vertices have a macro `VERTICES`, which is `at_once`, or [`TILE`] where
    /// the device is a processor; a workgroup has as many vertices either way.
    pub each: Each,
    /// How many of them an invocation computes.
    pub at_once: u32,
    /// Whether an invocation computes several frames: then each language has a constant `FRAMES`, which is 1 or
    /// [`FRAMES_AT_ONCE`] (Vulkan: specialisation constant 0; WebGPU: `override`; OpenCL: a macro).
    pub batched: bool,
    /// GLSL, for Vulkan; `spirv` is made from it. Its entry point is renamed from `main`.
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
    /// Something of each vertex of a part.
    Vertex,
    /// Something of each strain edge.
    StrainEdge,
}

/// A buffer of a kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// Its name in every language.
    pub name: &'static str,
    /// What it is an array of.
    pub element: Element,
    /// What the kernel does with it.
    pub access: Access,
    /// Whether GPUs keep it tiled, and the vertices of one part alone (see [`Kernel`]'s `first_vertex`).
    pub tiled: bool,
}

/// The type of a buffer's elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element {
    /// `float`, `f32`.
    F32,
    /// `uint`, `u32`.
    U32,
    /// Two `u32`, to be read together: the basis, whose words are an `f32` or two halves. OpenCL has `uint`.
    U32x2,
    /// Four `f32`, to be read together. OpenCL has `float`.
    F32x4,
}

/// What a kernel does with a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// It reads.
    Read,
    /// It writes, each element at most once.
    Write,
}

const fn read(name: &'static str, element: Element) -> Binding {
    Binding { name, element, access: Access::Read, tiled: false }
}

const fn tiled(name: &'static str, element: Element) -> Binding {
    Binding { name, element, access: Access::Read, tiled: true }
}

const fn write(name: &'static str) -> Binding {
    Binding { name, element: F32, access: Access::Write, tiled: false }
}

macro_rules! kernel {
    ($name:ident, each: $each:expr, at_once: $at_once:expr, batched: $batched:expr, $($binding:expr),* $(,)?) => {
        Kernel {
            name: stringify!($name),
            params: $name::Params::FIELDS,
            bindings: &[$($binding),*],
            each: $each,
            at_once: $at_once,
            batched: $batched,
            glsl: include_str!(concat!(stringify!($name), "/", stringify!($name), ".comp")),
            spirv: include_bytes!(concat!(stringify!($name), "/", stringify!($name), ".spv")),
            opencl: include_str!(concat!(stringify!($name), "/", stringify!($name), ".cl")),
            wgsl: include_str!(concat!(stringify!($name), "/", stringify!($name), ".wgsl")),
        }
    };
}

use Each::{StrainEdge, Vertex};
use Element::{F32, F32x4, U32, U32x2};

/// Handle positions to features.
pub static STRAIN: Kernel = kernel!(
    strain,
    each: StrainEdge,
    at_once: 1,
    batched: false,
    read("handle_positions", F32),
    read("handle_rest", F32),
    read("strain_edges", U32),
    read("rest_lengths", F32),
    write("features"),
);

/// Displacements of the handles to smooth positions.
pub static LARGE_SCALE: Kernel = kernel!(
    large_scale,
    each: Vertex,
    at_once: 4,
    batched: true,
    read("rest", F32),
    tiled("basis", U32x2),
    read("displacements", F32x4),
    write("large_scale_positions"),
);

/// Positions to normals, large scale or final.
pub static NORMALS: Kernel = kernel!(
    normals,
    each: Vertex,
    at_once: 1,
    batched: false,
    read("positions", F32),
    read("fan_offsets", U32),
    read("fans", U32),
    write("vertex_normals"),
);

/// Features to what tells them from those of the centres.
pub static DIFFERENCES: Kernel = kernel!(
    differences,
    each: StrainEdge,
    at_once: 1,
    batched: false,
    read("features", F32),
    read("pose_features", F32),
    write("squared_differences"),
);

/// Differences of features to details in the local frames.
pub static DETAIL: Kernel = kernel!(
    detail,
    each: Vertex,
    at_once: 1,
    batched: true,
    read("squared_differences", F32x4),
    read("influence_offsets", U32),
    read("influence_edges", U32),
    read("influence_weights", F32),
    tiled("rbf_weights", F32),
    tiled("pivots", U32),
    write("local_detail"),
);

/// Smooth positions and details to positions.
pub static FINE_SCALE: Kernel = kernel!(
    fine_scale,
    each: Vertex,
    at_once: 1,
    batched: false,
    read("large_scale_positions", F32),
    read("large_scale_normals", F32),
    read("local_detail", F32),
    read("frame_neighbors", U32),
    write("positions"),
);

/// What a device builds: each kernel with each of its numbers of frames.
pub fn builds() -> impl Iterator<Item = (&'static Kernel, u32)> {
    let both =
        |kernel: &'static Kernel| [Some((kernel, 1)), kernel.batched.then_some((kernel, FRAMES_AT_ONCE))];
    KERNELS.into_iter().flat_map(both).flatten()
}

/// All kernels, in the order in which they first run.
pub static KERNELS: [&Kernel; 6] = [&STRAIN, &LARGE_SCALE, &NORMALS, &DIFFERENCES, &DETAIL, &FINE_SCALE];
