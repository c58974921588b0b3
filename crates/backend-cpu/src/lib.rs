//! The CPU backend: every core, whole batches, and the same bits as the kernels' `f32` twins.
#![forbid(unsafe_code)]

mod blocks;
mod detail;
mod device;
mod group;
mod group_mesh;
mod lanes;
mod large_scale;
mod mesh;
mod one_frame;
mod prefetch;
mod resident;
mod rows;
mod session;
mod times;
mod vectors;

pub use device::Cpu;
pub use session::CpuSession;
