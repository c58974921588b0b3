//! `rhytid info` of a project file.

use super::shape::{Shape, list, row, up};
use rhytid::Face;
use rhytid::core::human;
use rhytid::core::{Bind, Method, StrainEdges, UpAxis};
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct ProjectInfo {
    pub name: String,
    metres_per_unit: f64,
    up: UpAxis,
    #[serde(flatten)]
    shape: Shape,
    handles: usize,
    labels: Vec<String>,
    examples: Vec<String>,
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
    pub(super) fn from_face(face: Face) -> Self {
        Self {
            name: face.name,
            metres_per_unit: face.metres_per_unit,
            up: face.up_axis,
            shape: Shape::from_mesh(&face.neutral),
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

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let unit = human::unit(self.metres_per_unit);
        let bending_length = match self.bending_length {
            Some(length) => format!("{} {unit}", human::number(length)),
            None => "derived from the spacing of the handles".to_owned(),
        };
        let mut rows = vec![row("units", format!("{unit}, {} up", up(self.up)))];
        rows.extend(self.shape.rows(&unit));
        rows.extend([
            row("handles", list(&self.labels)),
            row("examples", list(&self.examples)),
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
