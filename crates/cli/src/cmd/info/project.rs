//! `rhytid info` of a project file.

use super::shape::{Shape, list, row, up};
use rhytid::core::human;
use rhytid::core::{Bind, Method, StrainEdges, UpAxis};
use rhytid::formats::{Reach, project};
use rhytid::solve::points;
use rhytid::{Face, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The expressions of another face.
#[derive(Serialize)]
struct PriorInfo {
    from: PathBuf,
    /// Null for a rig.
    expressions: Option<usize>,
    /// Null where the solve chooses it.
    weight: Option<f64>,
}

impl PriorInfo {
    fn text(&self) -> String {
        let expressions = match self.expressions {
            Some(expressions) => format!(", {}", human::counted(expressions, "expression")),
            None => ", a rig".to_owned(),
        };
        let weight = self.weight.map_or_else(|| "auto".to_owned(), human::number);
        format!("{}{expressions}, weight {weight}", self.from.display())
    }
}

#[derive(Serialize)]
pub(super) struct ProjectInfo {
    pub name: String,
    metres_per_unit: f64,
    up: UpAxis,
    #[serde(flatten)]
    shape: Shape,
    /// Whether vertices on both sides of a cut are joined for the solve.
    weld: bool,
    /// The points of the surface. As many as vertices if none are joined.
    points: usize,
    handles: usize,
    labels: Vec<String>,
    examples: Vec<String>,
    /// Null without a prior.
    prior: Option<PriorInfo>,
    method: &'static str,
    /// Null where it is derived from the spacing of the handles.
    bending_length: Option<f64>,
    bind: &'static str,
    rotations: bool,
    /// Null where the solve finds them.
    strain_edges: Option<usize>,
    max_influences: usize,
}

impl ProjectInfo {
    /// Of a project file and all that it names. A prior that is a rig is named alone.
    ///
    /// # Errors
    /// As reading it.
    pub(super) fn read(path: &Path, reach: Reach) -> Result<Self> {
        let project = project::read_project(path)?;
        let face = project::load(&project, path, reach)?;
        let prior = project.prior.map(|prior| PriorInfo {
            from: prior.from,
            expressions: face.prior.as_ref().map(|prior| prior.expressions.len()),
            weight: prior.weight,
        });
        Ok(Self::new(face, prior))
    }

    fn new(face: Face, prior: Option<PriorInfo>) -> Self {
        let points = points(&face).map_or(face.neutral.positions.len(), |points| points.len());
        Self {
            prior,
            name: face.name,
            metres_per_unit: face.metres_per_unit,
            up: face.up_axis,
            shape: Shape::from_mesh(&face.neutral),
            weld: face.settings.weld,
            points,
            handles: face.handles.labels.len(),
            labels: face.handles.labels,
            examples: face.examples.into_iter().map(|example| example.name).collect(),
            method: match face.settings.method {
                Method::Learned(_) => "learned",
                Method::Chapter => "chapter",
            },
            bending_length: face.settings.bending_length,
            bind: match face.settings.bind {
                Bind::Auto => "auto",
                Bind::Rigid => "rigid",
                Bind::Nearest => "nearest",
            },
            rotations: face.settings.rotations,
            strain_edges: match face.settings.strain_edges {
                StrainEdges::Auto => None,
                StrainEdges::Given(edges) => Some(edges.len()),
            },
            max_influences: face.settings.max_influences,
        }
    }

    fn joined(&self) -> String {
        match self.weld {
            true => format!("yes, to {}", human::counted(self.points, "point")),
            false => "no".to_owned(),
        }
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let unit = human::unit(self.metres_per_unit);
        let bending_length = match self.bending_length {
            Some(length) => format!("{} {unit}", human::number(length)),
            None => "derived from the spacing of the handles".to_owned(),
        };
        let mut rows = vec![row("units", format!("{unit}, {} up", up(self.up)))];
        rows.extend(self.shape.rows(&unit));
        rows.push(row("joined", self.joined()));
        rows.extend([
            row("handles", list(&self.labels)),
            row("examples", list(&self.examples)),
            row("prior", self.prior.as_ref().map_or_else(|| "none".to_owned(), PriorInfo::text)),
            row("method", self.method.to_owned()),
            row("bending length", bending_length),
            row("without a handle", self.bind.to_owned()),
            row("rotations", if self.rotations { "yes" } else { "no" }.to_owned()),
            row("strain edges", self.strain_edges.map_or_else(|| "auto".to_owned(), human::count)),
            row("influences", format!("at most {} per vertex", self.max_influences)),
        ]);
        rows
    }
}
