//! Geometry of triangle meshes and point sets, each algorithm once, in float64.
//!
//! | module or item | what it is |
//! | --- | --- |
//! | [`mod@laplacian`] | cotangent Laplacian and mixed Voronoi areas |
//! | [`Topology`], [`components`] | one-rings; connected components |
//! | [`geodesic`], [`dijkstra`] | distances along edges, geodesic Voronoi cells |
//! | [`registration`] | rigid motions and similarities between point sets, robustly; points laid onto a surface |
//! | [`Surface`] | the closest point of a triangle mesh |
//! | [`StrainGauge`] | principal strains of a mesh that deforms |
//! | [`cholesky`] | sparse Cholesky factorisation for systems on meshes |
//! | [`Points`] | the vertices that are one point of the surface |
//! | [`triangulate`] | triangles of polygons |
//! | [`Axes`] | axes that are exchanged or point the other way |
//!
//! ```
//! use glam::{DQuat, DVec3};
//! use rhytid_geometry::registration::{Similarity, fit_robustly};
//!
//! let from = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.0], [1.0, 1.0, 1.0]].map(DVec3::from_array);
//! let motion = Similarity { scale: 1.0, rotation: DQuat::from_rotation_z(0.5), translation: DVec3::new(1.0, 2.0, 3.0) };
//! let mut to = from.map(|x| motion.apply(x));
//! // The last point moves by itself as well.
//! to[4] += DVec3::X;
//! let (found, _) = fit_robustly(&from, &to, false, 0.01).unwrap();
//! assert!(found.rotation.angle_between(motion.rotation) < 1e-3);
//! ```
#![forbid(unsafe_code)]

mod axes;
pub mod cholesky;
pub mod dijkstra;
pub mod geodesic;
pub mod laplacian;
mod points;
pub mod registration;
mod strain_gauge;
mod surface;
mod topology;
mod triangulate;

pub use axes::Axes;
pub use points::Points;
pub use strain_gauge::{PrincipalStrains, StrainGauge};
pub use surface::{Closest, Surface};
pub use topology::{Topology, components};
pub use triangulate::triangulate;
