//! The face: the data from which the solve makes a rig.
use crate::{HandleId, Mesh, SurfacePoint, UpAxis, VertexId};
use serde::Serialize;

/// The points of the neutral mesh that markers hold: H labels and points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Handles {
    /// H distinct labels, as in the take.
    pub labels: Vec<String>,
    /// H points. Each can be met whatever the others are: no two are at one vertex, and at most three are in
    /// one triangle.
    pub points: Vec<SurfacePoint>,
}

impl Handles {
    /// H.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Where the handles are on a mesh with these V positions, H.
    pub fn at(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.points.iter().map(|point| point.at(positions)).collect()
    }
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
    /// The standard deviation of a vertex's noise per axis, 0 or more, in millimetres. The learned method
    /// trusts a noisy scan less. `None` takes what the scan shows.
    pub noise: Option<f64>,
}

/// Expressions of other faces, in the place of scans that a face does not have.
///
/// What they leave of their shells is learned as a linear function of vector strains, and all of it goes into
/// the basis. The face's own examples are learned on top of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Prior {
    /// The expressions, each with V positions that move this face's neutral.
    pub expressions: Vec<Example>,
    /// How much of what they say is taken, 0 to 1. `None` takes the weight with which the face's own examples
    /// are predicted best if each of them is left out.
    pub weight: Option<f64>,
}

/// Which pairs of handles carry a strain edge.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum StrainEdges {
    /// The pairs whose geodesic Voronoi cells on the rest mesh touch. The learned method leaves out pairs
    /// that are much farther apart along the skin than most, as around the back of a head.
    #[default]
    Auto,
    /// These pairs.
    Given(Vec<[HandleId; 2]>),
}

/// What happens to a connected component that has no handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bind {
    /// With the learned method, the examples decide. A component that is rigid in all of them moves as a
    /// rigid part. Any other component follows the closest points of the driven surface, in part if
    /// that predicts left-out examples much better. With the chapter's method, components without a handle do
    /// not move.
    #[default]
    Auto,
    /// It does not move.
    Rigid,
    /// Each of its vertices follows the closest point of the driven surface.
    Nearest,
}

/// The vertices that stay where they are. They are handles that never move and that a take does not have.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pins {
    /// Whether to pin vertices that no example moves, where they would follow markers that some examples
    /// move. `None` means yes for the learned method, and no for the chapter's.
    pub auto: Option<bool>,
    /// Vertices that are pinned in any case. Examples are assumed to be at rest there. A handle among them
    /// stays a handle.
    pub vertices: Vec<VertexId>,
}

/// The strains that wrinkles are functions of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WrinkleStrains {
    /// Vector strains, as in the linear band. They tell more expressions apart, and one table serves both
    /// bands. Wrinkles are along the mesh's axes.
    #[default]
    Vectors,
    /// The lengths of the strain edges, as in the chapter. Wrinkles are in the chapter's tangent frames.
    Lengths,
}

/// How a rig is made from the examples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The residual between the shell and the examples is learned in two bands. The linear band is a linear
    /// function of how nearby handles move relative to each other. The wrinkles are a function of how far
    /// that motion is from each example.
    Learned(LearnedSettings),
    /// GPU Computing Gems Emerald, ch. 27: the whole residual is a function of the strains.
    Chapter,
}

impl Default for Method {
    fn default() -> Self {
        Self::Learned(LearnedSettings::default())
    }
}

/// The settings of the learned method. `docs/method.md` has the equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearnedSettings {
    /// s in 0..1: how independent the three axes of the linear band are. 0 lets x, y and z move together; 1
    /// lets each be learned by itself. `None` takes the value that predicts left-out examples best.
    pub share: Option<f64>,
    /// λ, above 0: the ridge of the linear band, relative to the size of the examples' data. A larger λ
    /// follows the examples less. `None` as for `share`.
    pub ridge: Option<f64>,
    /// μ, above 0: the ridge of the wrinkles.
    pub wrinkle_ridge: f64,
    /// The standard deviation of a marker's noise per axis, 0 or more, in millimetres.
    pub marker_noise: f64,
    /// How far a vector strain is followed, 1 or more: a multiple of its greatest length in the examples.
    /// Infinite: no limit. `None` as for `share`.
    pub reach: Option<f64>,
    /// Whether the linear band is faded to the shell where left-out examples are hardly better with it.
    pub fade: bool,
    /// The strains that wrinkles are functions of.
    pub wrinkle_strains: WrinkleStrains,
}

impl LearnedSettings {
    /// The largest ridge.
    pub const LARGEST_RIDGE: f64 = 1e6;
    /// The largest noise of a marker, in millimetres.
    pub const LARGEST_NOISE: f64 = 1e3;
}

impl Default for LearnedSettings {
    fn default() -> Self {
        Self {
            share: None,
            ridge: None,
            wrinkle_ridge: 1e-3,
            marker_noise: 0.05,
            reach: None,
            fade: true,
            wrinkle_strains: WrinkleStrains::Vectors,
        }
    }
}

/// The choices a user has in the solve.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Whether vertices on both sides of a cut are joined for the solve: those that are in one place in the
    /// neutral and in all examples, at open edges that fit together. glTF cuts the surface at texture seams.
    pub weld: bool,
    /// ℓ = √(k_b/k_s) in mesh units; `None` derives it from the handles' spacing
    /// (see `default_bending_length` of `rhytid-solve`).
    pub bending_length: Option<f64>,
    /// Whether the large scale turns with the handles. With it, bends keep lengths and areas; without it,
    /// they do not.
    pub rotations: bool,
    /// How a rig is made from the examples.
    pub method: Method,
    /// Components without a handle.
    pub bind: Bind,
    /// Whether to align examples that are not in the neutral's place with it. They are aligned at vertices
    /// that do not move: those that are pinned by name. Where none are, the data show which vertices do not
    /// move.
    pub align: bool,
    /// The vertices that stay where they are.
    pub pins: Pins,
    /// The strain edges.
    pub strain_edges: StrainEdges,
    /// K: influences kept per vertex, at least 1.
    pub max_influences: usize,
    /// What does not go into each other (learned method).
    pub contact: ContactSettings,
}

/// What does not go into each other, where it is recognised (`docs/method.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ContactSettings {
    /// Whether lids slide on eyeballs.
    pub eyes: bool,
    /// Whether lips and lids meet instead of going through each other.
    pub openings: bool,
}

impl Default for ContactSettings {
    fn default() -> Self {
        Self { eyes: true, openings: true }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            weld: false,
            bending_length: None,
            rotations: false,
            method: Method::default(),
            bind: Bind::default(),
            align: true,
            pins: Pins::default(),
            strain_edges: StrainEdges::default(),
            max_influences: 16,
            contact: ContactSettings::default(),
        }
    }
}

/// Everything that the solve needs to know about one face.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The name of the rig and of its exports.
    pub name: String,
    /// The neutral scan.
    pub neutral: Mesh,
    /// Metres in one mesh unit: 0.01 for centimetres.
    pub metres_per_unit: f64,
    /// The neutral's up axis.
    pub up_axis: UpAxis,
    /// The handles.
    pub handles: Handles,
    /// P expression scans. Without any, the rig has the large scale only.
    pub examples: Vec<Example>,
    /// What other faces do, for the learned method. `None`: nothing is known of other faces.
    pub prior: Option<Prior>,
    /// The choices.
    pub settings: Settings,
}
