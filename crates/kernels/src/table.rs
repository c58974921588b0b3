//! The one table that every language's kernels are checked against: `cargo xtask kernels --check`.
use crate::{detail, fine_scale, large_scale, normals, strain};

/// Invocations in a workgroup, along x, of every kernel.
pub const WORKGROUP_SIZE: u32 = 64;

/// Vertices in a tile. An array of n numbers per vertex that is *tiled* is stored as `[⌈V/64⌉][n][64]`, the numbers
/// past V being zero, so that neighbouring invocations read neighbouring words.
pub const TILE: usize = 64;

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
    /// GLSL, for Vulkan; `spirv` is made from it. Its entry point is renamed from `main`.
    pub glsl: &'static str,
    /// SPIR-V 1.3 words in little-endian bytes, as `cargo xtask kernels` made them.
    pub spirv: &'static [u8],
    /// OpenCL C 1.2.
    pub opencl: &'static str,
    /// WGSL.
    pub wgsl: &'static str,
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
    /// `uint`, `u32`; the basis too, whose words are an `f32` or two halves.
    U32,
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
    ($name:ident, $($binding:expr),* $(,)?) => {
        Kernel {
            name: stringify!($name),
            params: $name::Params::FIELDS,
            bindings: &[$($binding),*],
            glsl: include_str!(concat!(stringify!($name), "/", stringify!($name), ".comp")),
            spirv: include_bytes!(concat!(stringify!($name), "/", stringify!($name), ".spv")),
            opencl: include_str!(concat!(stringify!($name), "/", stringify!($name), ".cl")),
            wgsl: include_str!(concat!(stringify!($name), "/", stringify!($name), ".wgsl")),
        }
    };
}

use Element::{F32, U32};

/// Handle positions to features.
pub static STRAIN: Kernel = kernel!(
    strain,
    read("handle_positions", F32),
    read("handle_rest", F32),
    read("strain_edges", U32),
    read("rest_lengths", F32),
    write("features"),
);

/// Handle positions to smooth positions.
pub static LARGE_SCALE: Kernel = kernel!(
    large_scale,
    read("rest", F32),
    tiled("basis", U32),
    read("handle_rest", F32),
    read("handle_positions", F32),
    write("large_scale_positions"),
);

/// Positions to normals, large scale or final.
pub static NORMALS: Kernel = kernel!(
    normals,
    read("positions", F32),
    read("triangles", U32),
    read("triangle_offsets", U32),
    read("vertex_triangles", U32),
    write("vertex_normals"),
);

/// Features to details in the local frames.
pub static DETAIL: Kernel = kernel!(
    detail,
    read("features", F32),
    tiled("influence_edges", U32),
    tiled("influence_weights", F32),
    read("pose_features", F32),
    tiled("rbf_weights", F32),
    tiled("pivots", U32),
    write("local_detail"),
);

/// Smooth positions and details to positions.
pub static FINE_SCALE: Kernel = kernel!(
    fine_scale,
    read("large_scale_positions", F32),
    read("large_scale_normals", F32),
    read("local_detail", F32),
    read("frame_neighbors", U32),
    write("positions"),
);

/// All kernels, in the order in which they first run.
pub static KERNELS: [&Kernel; 5] = [&STRAIN, &LARGE_SCALE, &NORMALS, &DETAIL, &FINE_SCALE];
