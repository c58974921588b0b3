//! The face: what the solve makes a rig of.
use crate::{HandleId, Mesh, UpAxis, VertexId};

/// The vertices that markers hold: H labels and vertex indices of the neutral mesh.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Handles {
    /// H distinct labels, as in the take.
    pub labels: Vec<String>,
    /// H distinct vertices.
    pub vertices: Vec<VertexId>,
}

/// One expression scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// The name in the project file.
    pub name: String,
    /// V positions, in the neutral's vertex order and unit.
    pub positions: Vec<[f64; 3]>,
    /// Whether its mirror image, left and right exchanged, is an example too.
    pub mirror: bool,
}

/// Which pairs of handles carry a strain edge.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum StrainEdges {
    /// The pairs whose geodesic Voronoi cells on the rest mesh touch; by the learned method but those that are much farther along the skin
    /// than most, as around the back of a head.
    #[default]
    Auto,
    /// These pairs.
    Given(Vec<[HandleId; 2]>),
}

/// What happens to a connected component that has no handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bind {
    /// By the learned method, what the examples show: one that is rigid in all of them moves as a solid, another follows the
    /// closest point of the driven surface. By the chapter's, it does not move.
    #[default]
    Auto,
    /// It does not move.
    Rigid,
    /// Each of its vertices follows the closest point of the driven surface.
    Nearest,
}

/// The vertices that stay where they are, as handles that never move and that no take knows.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pins {
    /// Whether what no example moves is pinned, where markers that it would follow are moved by some; `None`: by the learned method.
    pub auto: Option<bool>,
    /// Vertices that are pinned in any case; examples are taken to be at rest there. A handle among them stays a handle.
    pub vertices: Vec<VertexId>,
}

/// The strains that folds are functions of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FoldStrains {
    /// Vector strains, as the linear band's: they tell more expressions apart, and one table serves both. Folds are along the mesh's
    /// axes.
    #[default]
    Vectors,
    /// The lengths of the strain edges, as in the chapter, and along its tangent frames.
    Lengths,
}

/// How a rig is made of the examples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// What the shell leaves of the examples is learned in two bands: its smooth part as a linear function of what the handles
    /// nearby do relative to each other, its folds from how far that is from each example.
    Learned(LearnedSettings),
    /// GPU Computing Gems Emerald, ch. 27: all that the shell leaves, from the strains.
    Chapter,
}

impl Default for Method {
    fn default() -> Self {
        Self::Learned(LearnedSettings::default())
    }
}

/// What a user may say of the learned method; `docs/method.md` has the equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearnedSettings {
    /// s in 0..1, the part of the linear band in which the three axes do as they like; `None` takes what predicts left-out
    /// examples best.
    pub share: Option<f64>,
    /// λ, above 0: how little the examples are believed, as a part of what they say; `None` as for `share`.
    pub ridge: Option<f64>,
    /// μ, above 0: the same of the folds.
    pub fold_ridge: f64,
    /// The standard deviation of a marker's noise per axis, 0 or more, in millimetres.
    pub marker_noise: f64,
    /// How far the linear band follows a vector strain, 1 or more: so many times what the examples show of it, each component for
    /// itself and to each side. Infinite: however far it goes.
    pub reach: f64,
    /// The strains that folds are functions of.
    pub fold_strains: FoldStrains,
}

impl Default for LearnedSettings {
    fn default() -> Self {
        Self {
            share: None,
            ridge: None,
            fold_ridge: 1e-3,
            marker_noise: 0.05,
            reach: 1.0,
            fold_strains: FoldStrains::Vectors,
        }
    }
}

/// The choices a user has in the solve.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// ℓ = √(k_b/k_s) in mesh units; `None` derives it from the handles' spacing
    /// (see `default_bending_length` of `rhytid-solve`).
    pub bending_length: Option<f64>,
    /// Whether the large scale turns with the handles: bends keep lengths and areas that a shell without does not.
    pub rotations: bool,
    /// How the examples are learned from.
    pub method: Method,
    /// Components without a handle.
    pub bind: Bind,
    /// Whether examples that are not in the neutral's place are put there, at what does not move: what is pinned by name or, where
    /// nothing is, what the data show.
    pub align: bool,
    /// What stays.
    pub pins: Pins,
    /// The strain edges.
    pub strain_edges: StrainEdges,
    /// K: influences kept per vertex, at least 1.
    pub max_influences: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            bending_length: None,
            rotations: false,
            method: Method::default(),
            bind: Bind::default(),
            align: true,
            pins: Pins::default(),
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
