//! A face made in code: mesh, handles, six examples and a short performance.
//!
//! Everything is a continuous function of a flat domain (see `shape`), sampled at the vertices of a grid. So
//! the face is the same at every resolution.
//!
//! ```
//! let face = rhytid_demo::face(2_000);
//! let take = rhytid_demo::performance(&face);
//! // The take has every handle, near where the neutral has it.
//! let first = take.handle_positions(&face.handles.labels)?;
//! let rest = face.handles.points[0].at(&face.neutral.positions);
//! assert!((f64::from(first[0]) - rest[0]).abs() < 1.0);
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod curve;
mod expressions;
mod grid;
mod handles;
mod performance;
mod shape;
mod sized;
mod sized_learned;
mod skin;
mod wrinkles;

pub use performance::performance;
pub use sized::{Size, sized_rig};

use expressions::EXPRESSIONS;
use grid::Grid;
use rayon::prelude::*;
use rhytid_core::{Example, Face, Mesh, Settings, UpAxis};
use shape::Shape;
use skin::Skin;

/// Makes the demo face with about `vertices` vertices, at most 2 % off. A number outside 2,000 to 4,000,000
/// is clamped to this range. The neutral mesh is in centimetres, Y up, facing +Z, with texture coordinates.
/// The face has 89 handles, the same on both sides, and six expressions.
pub fn face(vertices: usize) -> Face {
    let shape = Shape::new();
    let grid = Grid::new(vertices.clamp(2_000, 4_000_000));
    // Pores smaller than a few cells would only be noise.
    let pores = curve::ramp(grid.spacing(), 0.05, 0.03);
    let skin: Vec<Skin> = grid.sites.par_iter().map(|&site| Skin::new(&shape, site)).collect();
    let positions: Vec<[f64; 3]> = skin
        .iter()
        .map(|s| if pores > 0.0 { s.p + s.n * (pores * shape::pores(s.site)) } else { s.p }.to_array())
        .collect();
    let examples = EXPRESSIONS
        .iter()
        .map(|expression| Example {
            mirror: false,
            name: expression.name.into(),
            positions: skin
                .par_iter()
                .zip(&positions)
                .map(|(s, p)| {
                    let d = expression.displacement(&shape, s);
                    [p[0] + d.x, p[1] + d.y, p[2] + d.z]
                })
                .collect(),
            noise: None,
        })
        .collect();
    Face {
        name: "demo".into(),
        handles: handles::handles(&grid),
        neutral: Mesh { positions, uvs: Some(grid.uvs()), faces: grid.faces, materials: None },
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        examples,
        prior: None,
        settings: Settings::default(),
    }
}
