//! The CPU backend: every core, whole batches, and the same bits as the kernels' `f32` twins.
//!
//! ```
//! use rhytid_backend_cpu::Cpu;
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
//! for info in Cpu::devices()? {
//!     println!("{}: {}", info.id(), info.name);
//! }
//! if let Some(info) = Cpu::devices()?.into_iter().next() {
//!     let mut animator = Animator::new(&Cpu::open(&info)?, &rig, UploadOptions::frames(1))?;
//!     animator.evaluate(&[0.0, 0.0, 2.0])?;
//!     let mut positions = Vec::new();
//!     animator.read(Stage::Positions, &mut positions)?;
//!     assert_eq!(positions, [0.0, 0.0, 2.0, 4.0, 0.0, 1.0, 0.0, 4.0, 0.0]);
//! }
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod bands;
mod blocks;
mod detail;
mod device;
mod group;
mod group_mesh;
mod lanes;
mod large_scale;
mod lines;
mod mesh;
mod one_frame;
mod prefetch;
mod session;
mod tile_weights;
mod times;
mod uploaded;
mod vectors;

pub use device::Cpu;
pub use session::CpuSession;
