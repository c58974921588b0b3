//! The wgpu backend: one set of kernels (WGSL) on Vulkan, Metal, Direct3D 12, OpenGL ES and, in browsers, WebGPU, within
//! WebGPU's default limits.
//!
//! A host application that renders with wgpu hands in its own device ([`Wgpu::from_device`]) and draws with the buffers
//! that the results are in ([`WgpuSession::results`]), without a copy. In a browser nothing can wait, so a device is opened
//! with [`Wgpu::request`] and results are read with [`WgpuSession::read_async`].
//!
//! ```
//! use rhytid_backend_wgpu::Wgpu;
//! use rhytid_core::{Animator, Backend, Stage, UploadOptions};
//!
//! # use rhytid_core::{Faces, Rig, UpAxis};
//! # let rig = Rig {
//! #     name: "triangle".into(),
//! #     metres_per_unit: 0.01,
//! #     up_axis: UpAxis::Y,
//! #     labels: vec!["corner".into()],
//! #     example_names: vec![],
//! #     faces: Faces { counts: vec![3], indices: vec![0, 1, 2] },
//! #     uvs: None,
//! #     materials: None,
//! #     bending_length: 1.0,
//! #     beta: 0.0,
//! #     handles: vec![0],
//! #     triangles: vec![[0, 1, 2]],
//! #     rest: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]],
//! #     basis: vec![1.0, 0.5, 0.0],
//! #     strain_edges: vec![],
//! #     influence_edges: vec![],
//! #     influence_weights: vec![],
//! #     tangent_neighbors: vec![1, 2, 0],
//! #     pose_features: vec![],
//! #     rbf_weights: vec![[0.0; 3]; 3],
//! #     example_handles: vec![],
//! #     rotations: false,
//! #     learned: None,
//! # };
//! // `rig` is a triangle: its first vertex is a handle, the second follows it half the way, and the third stays.
//! for info in Wgpu::devices()? {
//!     println!("{}: {}", info.id(), info.name);
//! }
//! if let Some(info) = Wgpu::devices()?.into_iter().next() {
//!     let mut animator = Animator::new(&Wgpu::open(&info)?, &rig, UploadOptions::frames(1))?;
//!     animator.evaluate(&[0.0, 0.0, 2.0])?;
//!     let mut positions = Vec::new();
//!     animator.read(Stage::Positions, &mut positions)?;
//!     assert_eq!(positions, [0.0, 0.0, 2.0, 4.0, 0.0, 1.0, 0.0, 4.0, 0.0]);
//! }
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod device;
mod faults;
mod gpu;
mod session;
#[cfg(test)]
mod tests;

pub use device::Wgpu;
pub use session::WgpuSession;
