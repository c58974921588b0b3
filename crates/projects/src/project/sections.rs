//! The sections of a project file.

use crate::pattern::is_pattern;
use rhytid_core::{Bind, ContactSettings, LearnedSettings, UpAxis, WrinkleStrains};
use rhytid_geometry::Axes;
use rhytid_meshes::{Format, NormalMapConvention};
use serde::{Serialize, Serializer};
use std::fmt;
use std::path::PathBuf;

/// The content of a project file. Paths are relative to the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Project {
    /// The method that makes a rig of the examples: `method`, above all sections.
    pub method: Method,
    /// Whether examples that are not at the neutral's place are moved there: `align`, above all sections.
    #[serde(skip_serializing_if = "is_true")]
    pub align: bool,
    /// `[mesh]`.
    pub mesh: MeshSection,
    /// `[handles]`.
    pub handles: HandlesSection,
    /// Each `[[example]]`; names are distinct.
    #[serde(rename = "example")]
    pub examples: Vec<ExampleSection>,
    /// `[prior]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prior: Option<PriorSection>,
    /// `[pins]`.
    #[serde(skip_serializing_if = "PinsSection::is_default")]
    pub pins: PinsSection,
    /// `[large_scale]`.
    pub large_scale: LargeScaleSection,
    /// `[contact]`.
    #[serde(skip_serializing_if = "is_default")]
    pub contact: ContactSettings,
    /// `[strain]`.
    pub strain: StrainSection,
    /// `[fine_scale]`.
    pub fine_scale: FineScaleSection,
    /// `[learned]`.
    pub learned: LearnedSection,
}

/// `[mesh]`: the neutral scan and what its numbers mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshSection {
    /// Names the rig; `None` takes the stem of the project file's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The neutral scan: OBJ, PLY, glTF or USD.
    pub neutral: PathBuf,
    /// The meshes at this prim and below it; for a USD file alone. `None`: all that are shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prim: Option<String>,
    /// The unit of all coordinates. `None`: the one that the neutral's file states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// The axis that points up. `None`: the one that the neutral's file states, else Y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// Whether vertices on both sides of a cut are joined for the solve. `None`: for glTF, which cuts the
    /// surface at texture seams, and for no other format.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weld: Option<bool>,
    /// Whether the rig has the images of the neutral's materials. `None`: it has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub textures: Option<bool>,
}

impl MeshSection {
    /// Whether vertices are joined for the solve.
    pub fn welds(&self) -> bool {
        let is_gltf = matches!(Format::from_extension(&self.neutral), Ok(Format::Gltf));
        self.weld.unwrap_or(is_gltf)
    }
}

/// `[handles]`: the vertices that markers hold.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct HandlesSection {
    /// CSV with the header `label,vertex`.
    pub vertices: PathBuf,
}

/// `[[example]]`: an expression scan, or several that a pattern or one file has.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ExampleSection {
    /// Distinct and not empty. `None`: an example is called as its shape or its file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// A mesh with the neutral's vertices and faces. In a section without a name and shapes, the file's name
    /// may be a pattern: `#` is a digit, `*` is anything, and each file that it fits is an example.
    pub mesh: PathBuf,
    /// The meshes at this prim and below it; for a USD file alone. `None`: all that are shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prim: Option<String>,
    /// The pose at this time code; for a USD file alone. `None`: the pose without a time, else the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Shapes of the mesh, as of an expression. They are added to one another, and make one example.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shape: Vec<String>,
    /// Patterns of names of shapes. Each shape that one of them fits is an example.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<String>,
    /// What the displacements of shapes are multiplied by; 1 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// The unit of the mesh's coordinates. `None`: the one that its file states, else the neutral's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<Units>,
    /// What the mesh's coordinates are multiplied by besides; 1 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// What the neutral's axes are in the mesh. `None`: those that the formats of both say, else the same.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "as_text")]
    pub axes: Option<Axes>,
    /// Whether its mirror image is an example too.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub mirror: bool,
    /// The standard deviation of a vertex's noise per axis in millimetres; `None` takes what the scan shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// A take's CSV in the neutral's space. The mesh is a sculpted frame of this take, and its handles are
    /// where the take has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub take: Option<PathBuf>,
    /// The frame of the take; given with `take` alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<usize>,
    /// A displacement map over the neutral's texture coordinates, which displaces the mesh
    /// ([`rhytid_meshes::DisplacementMap`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<PathBuf>,
    /// How far the map moves a vertex where it is white; given with `displacement` alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub millimetres: Option<f64>,
    /// A tangent-space normal map over the neutral's texture coordinates, whose surface displaces the mesh
    /// ([`rhytid_meshes::NormalMap`]).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_map: Option<PathBuf>,
    /// The direction of its green; up by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub green: Option<NormalMapConvention>,
    /// The factor of its heights; 1 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strength: Option<f64>,
}

impl ExampleSection {
    /// The name of its example: its own, else that of its shapes. `None` if it has an example for each file
    /// or shape.
    pub fn name_of_one(&self) -> Option<String> {
        let of_shapes = (!self.shape.is_empty()).then(|| self.shape.join("+"));
        self.name.clone().or(of_shapes)
    }

    /// Whether its examples are shapes of its file.
    pub fn has_shapes(&self) -> bool {
        !self.shape.is_empty() || !self.shapes.is_empty()
    }

    /// Whether its mesh is a pattern, which may fit many files.
    pub fn names_files(&self) -> bool {
        let is_pattern = self.mesh.file_name().is_some_and(|name| is_pattern(&name.to_string_lossy()));
        self.name.is_none() && !self.has_shapes() && is_pattern
    }
}

/// `[prior]`: expressions of another face.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PriorSection {
    /// A folder of meshes with the neutral's vertices and faces, a mesh with shapes (`.glb`, `.gltf`), or the
    /// rig of another face.
    pub from: PathBuf,
    /// The mesh at rest that the meshes of the folder are expressions of. `None`: the folder's own mesh
    /// called `neutral`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub neutral: Option<PathBuf>,
    /// CSV with pairs of labels of handles at the same place, those of the rig first. `None`: the labels
    /// that both have.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landmarks: Option<PathBuf>,
    /// How much of it is taken, 0 to 1. `None` is `"auto"`: as much as predicts the face's own examples best.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
}

/// `[pins]`: the vertices that stay where they are. The keys add up.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct PinsSection {
    /// Whether vertices that no example moves are pinned. `None`: only by the learned method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub auto: Option<bool>,
    /// CSV with the header `vertex`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices: Option<PathBuf>,
    /// `box`: the lowest and the highest corner of a box, in mesh units.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[[f64; 3]; 2]>,
    /// Names of groups of the neutral, which then is an OBJ file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<String>,
}

impl PinsSection {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// `[large_scale]`.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct LargeScaleSection {
    /// ℓ in mesh units, above 0; `None` derives it from the spacing of the handles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bending_length: Option<f64>,
    /// The treatment of components without a handle.
    #[serde(serialize_with = "serialize_bind")]
    pub bind: Bind,
    /// Whether the handles turn.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub rotations: bool,
}

/// Whether a section is as it is where it is left out.
fn is_default<S: Default + PartialEq>(section: &S) -> bool {
    *section == S::default()
}

/// `[strain]`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct StrainSection {
    /// Which pairs of handles carry a strain edge.
    pub edges: Edges,
}

/// `[fine_scale]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FineScaleSection {
    /// K: influences kept per vertex, at least 1; 16 by default.
    pub max_influences: usize,
}

impl Default for FineScaleSection {
    fn default() -> Self {
        Self { max_influences: rhytid_core::Settings::default().max_influences }
    }
}

/// `[learned]`: absent values are chosen by the solve.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct LearnedSection {
    /// s, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// λ, above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ridge: Option<f64>,
    /// μ, above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrinkle_ridge: Option<f64>,
    /// The standard deviation of a marker's noise per axis in millimetres, 0 or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub marker_noise: Option<f64>,
    /// How far a vector strain is followed, as a multiple of its greatest length in any example: 1 or more,
    /// and infinite for no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reach: Option<f64>,
    /// Whether the linear band is faded to the shell where left-out examples are hardly better with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fade: Option<bool>,
    /// The strains that drive the wrinkles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrinkle_strains: Option<WrinkleStrains>,
}

impl LearnedSection {
    /// The settings of the solve.
    pub fn settings(self) -> LearnedSettings {
        let default = LearnedSettings::default();
        LearnedSettings {
            share: self.share,
            ridge: self.ridge,
            wrinkle_ridge: self.wrinkle_ridge.unwrap_or(default.wrinkle_ridge),
            marker_noise: self.marker_noise.unwrap_or(default.marker_noise),
            reach: self.reach.or(default.reach),
            fade: self.fade.unwrap_or(default.fade),
            wrinkle_strains: self.wrinkle_strains.unwrap_or(default.wrinkle_strains),
        }
    }
}

/// The length of one mesh unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Units {
    /// `"m"`.
    Metres,
    /// `"cm"`.
    Centimetres,
    /// `"mm"`.
    Millimetres,
    /// `"in"`.
    Inches,
    /// A number: so many metres per unit, above 0.
    MetresPerUnit(f64),
}

impl Units {
    /// The unit of a name that project files have.
    pub fn named(name: &str) -> Option<Self> {
        let all = [Units::Metres, Units::Centimetres, Units::Millimetres, Units::Inches];
        all.into_iter().find(|unit| unit.name() == Some(name))
    }

    /// Its name; `None` for a number.
    fn name(self) -> Option<&'static str> {
        match self {
            Units::Metres => Some("m"),
            Units::Centimetres => Some("cm"),
            Units::Millimetres => Some("mm"),
            Units::Inches => Some("in"),
            Units::MetresPerUnit(_) => None,
        }
    }

    /// Metres in one unit.
    pub fn metres_per_unit(self) -> f64 {
        match self {
            Units::Metres => 1.0,
            Units::Centimetres => 0.01,
            Units::Millimetres => 0.001,
            Units::Inches => 0.0254,
            Units::MetresPerUnit(metres) => metres,
        }
    }
}

/// The name, or the number of metres.
impl fmt::Display for Units {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(name),
            None => self.metres_per_unit().fmt(f),
        }
    }
}

/// Writes a value as a project file names it.
fn as_text<S: Serializer>(value: &Option<Axes>, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Some(axes) => serializer.collect_str(axes),
        None => serializer.serialize_none(),
    }
}

impl Serialize for Units {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.name() {
            Some(name) => serializer.serialize_str(name),
            None => serializer.serialize_f64(self.metres_per_unit()),
        }
    }
}

/// Where the strain edges come from.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Edges {
    /// `"auto"`: [`rhytid_core::StrainEdges::Auto`].
    #[default]
    Auto,
    /// CSV with the header `a,b`: pairs of labels.
    File(PathBuf),
}

impl Serialize for Edges {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Edges::Auto => serializer.serialize_str("auto"),
            Edges::File(path) => path.serialize(serializer),
        }
    }
}

/// How a rig is made of the examples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// `"learned"`: the learned method of `docs/method.md`.
    #[default]
    Learned,
    /// `"chapter"`: its sections 4 to 7.
    Chapter,
}

fn serialize_bind<S: Serializer>(bind: &Bind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(match bind {
        Bind::Auto => "auto",
        Bind::Rigid => "rigid",
        Bind::Nearest => "nearest",
    })
}

fn is_true(truth: &bool) -> bool {
    *truth
}
