//! The CPU backend: every core, whole batches, and the same bits as the kernels' `f32` twins.
#![forbid(unsafe_code)]

mod blocks;
mod detail;
mod device;
mod large_scale;
mod normals;
mod session;
mod simd;

pub use device::Cpu;
pub use session::CpuSession;
