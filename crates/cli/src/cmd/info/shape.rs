//! The common part of meshes, rigs and projects, and rows of text.

use rhytid::core::human;
use rhytid::core::{Mesh, UpAxis, Uvs};
use serde::Serialize;
use std::collections::BTreeMap;

/// What meshes, rigs and projects have in common.
#[derive(Serialize)]
pub(super) struct Shape {
    vertices: usize,
    faces: usize,
    /// Number of faces by number of corners.
    faces_by_corners: BTreeMap<u32, usize>,
    triangles: usize,
    /// `none`, `vertex` or `corner`.
    uvs: &'static str,
    /// The names that faces refer to.
    materials: Vec<String>,
    bounds: Option<Bounds>,
}

#[derive(Serialize)]
pub(super) struct Bounds {
    min: [f64; 3],
    max: [f64; 3],
}

impl Shape {
    pub(super) fn from_mesh(mesh: &Mesh) -> Self {
        let mut faces_by_corners = BTreeMap::new();
        for &corners in &mesh.faces.counts {
            *faces_by_corners.entry(corners).or_insert(0) += 1;
        }
        Self {
            vertices: mesh.positions.len(),
            faces: mesh.faces.len(),
            faces_by_corners,
            triangles: mesh.faces.triangle_count(),
            uvs: match &mesh.uvs {
                None => "none",
                Some(Uvs { corners: None, .. }) => "vertex",
                Some(Uvs { corners: Some(_), .. }) => "corner",
            },
            materials: mesh
                .materials
                .as_ref()
                .map(|materials| materials.names().map(str::to_owned).collect())
                .unwrap_or_default(),
            bounds: mesh.bounds().map(Bounds::from),
        }
    }

    pub(super) fn rows(&self, unit: &str) -> Vec<[String; 2]> {
        let by_corners = self.faces_by_corners.iter().map(|(corners, &n)| match corners {
            3 => human::counted(n, "triangle"),
            4 => human::counted(n, "quad"),
            corners => format!("{} of {corners} corners", human::count(n)),
        });
        let by_corners = by_corners.collect::<Vec<_>>().join(", ");
        let uvs = match self.uvs {
            "none" => "none".to_owned(),
            per => format!("per {per}"),
        };
        let mut rows = vec![
            row("vertices", human::count(self.vertices)),
            row("faces", format!("{} ({by_corners})", human::count(self.faces))),
            row("texture coordinates", uvs),
            row("materials", list(&self.materials)),
        ];
        rows.extend(self.bounds.as_ref().map(|b| row("bounds", b.text(unit))));
        rows
    }
}

impl From<[[f64; 3]; 2]> for Bounds {
    fn from([min, max]: [[f64; 3]; 2]) -> Self {
        Self { min, max }
    }
}

impl Bounds {
    pub(super) fn text(&self, unit: &str) -> String {
        format!("{} {unit}", human::bounds([self.min, self.max])).trim_end().to_owned()
    }
}

pub(super) fn row(name: &str, value: String) -> [String; 2] {
    [name.to_owned(), value]
}

pub(super) fn up(axis: UpAxis) -> &'static str {
    match axis {
        UpAxis::Y => "Y",
        UpAxis::Z => "Z",
    }
}

/// Number and names: `3: a, b, c`.
pub(super) fn list(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        names => format!("{}: {}", human::count(names.len()), names.join(", ")),
    }
}
