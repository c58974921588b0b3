//! The wgpu backend: one set of kernels (WGSL) on Vulkan, Metal, Direct3D 12, OpenGL ES and, in browsers, WebGPU, within
//! WebGPU's default limits.
//!
//! A host application that renders with wgpu hands in its own device ([`Wgpu::from_device`]) and draws with the buffers
//! that the results are in ([`WgpuSession::results`]), without a copy. In a browser nothing can wait, so a device is opened
//! with [`Wgpu::request`] and results are read with [`WgpuSession::read_async`].
#![forbid(unsafe_code)]

mod device;
mod faults;
mod gpu;
mod session;
#[cfg(test)]
mod tests;

pub use device::Wgpu;
pub use session::WgpuSession;
