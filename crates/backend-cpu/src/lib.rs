//! The CPU backend: every core, whole batches, and the same bits as the kernels' `f32` twins.
#![forbid(unsafe_code)]

mod device;
mod session;

pub use device::Cpu;
pub use session::CpuSession;
