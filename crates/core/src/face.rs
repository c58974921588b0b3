//! The face: what the solve makes a rig of.
use crate::{Mesh, UpAxis};

/// The vertices that markers hold: H labels and vertex indices of the neutral mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Handles {
    /// H distinct labels, as in the take.
    pub labels: Vec<String>,
    /// H distinct vertex indices.
    pub vertices: Vec<u32>,
}

/// One expression scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// The name in the project file.
    pub name: String,
    /// V positions, in the neutral's vertex order and unit.
    pub positions: Vec<[f64; 3]>,
}

/// Which pairs of handles carry a strain edge.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum StrainEdges {
    /// The pairs whose geodesic Voronoi cells on the rest mesh touch.
    #[default]
    Auto,
    /// These pairs, as indices into [`Handles`].
    Given(Vec<[u32; 2]>),
}

/// What happens to a connected component that has no handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bind {
    /// It does not move.
    #[default]
    Rigid,
    /// Each of its vertices follows the closest point of the driven surface.
    Nearest,
}

/// The choices a user has in the solve.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// ℓ = √(k_b/k_s) in mesh units; `None` derives it from the handles' spacing
    /// (see `default_bending_length` of `rhytid-solve`]).
    pub bending_length: Option<f64>,
    /// Components without a handle.
    pub bind: Bind,
    /// The strain edges.
    pub strain_edges: StrainEdges,
    /// K: influences kept per vertex, at least 1.
    pub max_influences: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            bending_length: None,
            bind: Bind::default(),
            strain_edges: StrainEdges::default(),
            max_influences: 16,
        }
    }
}

/// Everything the solve needs to know of one face.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Names the rig and what is exported from it.
    pub name: String,
    /// The neutral scan.
    pub neutral: Mesh,
    /// Metres in one mesh unit: 0.01 for centimetres.
    pub metres_per_unit: f64,
    /// The neutral's up axis.
    pub up_axis: UpAxis,
    /// The handles.
    pub handles: Handles,
    /// P expression scans; none gives a rig with the large scale only.
    pub examples: Vec<Example>,
    /// The choices.
    pub settings: Settings,
}
