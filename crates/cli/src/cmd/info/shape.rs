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
    /// The names of those about whose look the file states nothing.
    default_looks: Vec<String>,
    textures: Vec<TextureInfo>,
    bounds: Option<Bounds>,
}

/// An image that materials name.
#[derive(Serialize)]
pub(super) struct TextureInfo {
    name: String,
    bytes: usize,
    /// Null where the image is damaged, as the next.
    width: Option<u32>,
    height: Option<u32>,
    /// The names of the materials that name it.
    materials: Vec<String>,
}

impl TextureInfo {
    fn text(&self) -> String {
        let size = match (self.width, self.height) {
            (Some(width), Some(height)) => format!("{width} × {height} pixels"),
            _ => "damaged".to_owned(),
        };
        format!(
            "{} ({size}, {}, of {})",
            self.name,
            human::bytes(self.bytes as u64),
            self.materials.join(", ")
        )
    }
}

#[derive(Serialize)]
pub(super) struct Bounds {
    min: [f64; 3],
    max: [f64; 3],
}

impl Shape {
    pub(super) fn from_mesh(mesh: &Mesh) -> Self {
        let list = mesh.materials.as_ref().map_or(&[][..], |materials| &materials.list);
        let mut textures: Vec<TextureInfo> = Vec::new();
        for texture in mesh.materials.iter().flat_map(|materials| &materials.textures) {
            let number = Some(textures.len() as u32);
            let of = list.iter().filter(|material| material.stated.texture == number);
            let [width, height] = texture.size().map_or([None; 2], |size| size.map(Some));
            textures.push(TextureInfo {
                name: texture.name.clone(),
                bytes: texture.bytes.len(),
                width,
                height,
                materials: of.map(|material| material.name.clone()).collect(),
            });
        }
        let by_default = list.iter().filter(|material| material.look().is_default);
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
            materials: list.iter().map(|material| material.name.clone()).collect(),
            default_looks: by_default.map(|material| material.name.clone()).collect(),
            textures,
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
        if !self.default_looks.is_empty() {
            rows.push(row("of default look", list(&self.default_looks)));
        }
        if !self.textures.is_empty() {
            let textures: Vec<String> = self.textures.iter().map(TextureInfo::text).collect();
            rows.push(row("textures", list(&textures)));
        }
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
