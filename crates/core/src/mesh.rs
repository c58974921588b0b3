//! The mesh: polygons and texture coordinates, as the input has them.
use crate::Materials;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Which axis points up in the mesh's own coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// Y up, as in Maya and glTF.
    #[default]
    Y,
    /// Z up, as in Blender and 3ds Max.
    Z,
}

/// The polygons of a mesh, as the input gave them.
///
/// Corner `c` of the mesh is `indices[c]`; face `f` owns the next `counts[f]` corners.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Faces {
    /// Corners of each face; each at least 3.
    pub counts: Vec<u32>,
    /// The vertex of each corner; as many as `counts` add up to.
    pub indices: Vec<u32>,
}

impl Faces {
    /// Adds one polygon.
    pub fn push(&mut self, corners: &[u32]) {
        self.counts.push(corners.len() as u32);
        self.indices.extend_from_slice(corners);
    }

    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.counts.len()
    }

    /// Whether there is no polygon.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// What is wrong with these as polygons over `vertices` vertices, as a phrase without its subject. `None`
    /// if nothing is wrong. Faces are numbered from 1, as in modelling programs.
    pub fn fault(&self, vertices: usize) -> Option<String> {
        if let Some(f) = self.counts.iter().position(|&n| n < 3) {
            let n = self.counts[f];
            let corners = if n == 1 { "corner" } else { "corners" };
            return Some(format!("face {} has {n} {corners}, expected at least 3", f + 1));
        }
        let corners: u64 = self.counts.iter().map(|&n| u64::from(n)).sum();
        if corners != self.indices.len() as u64 {
            return Some(format!("has {} corners, expected the {corners} of its faces", self.indices.len()));
        }
        let corner = self.indices.iter().position(|&v| v as usize >= vertices)?;
        Some(format!(
            "face {} refers to vertex {}, expected 0 to {}",
            self.of_corner(corner) + 1,
            self.indices[corner],
            vertices.saturating_sub(1)
        ))
    }

    /// The face that owns a corner.
    fn of_corner(&self, corner: usize) -> usize {
        let mut end = 0;
        let owns = |&n: &u32| {
            end += n as usize;
            corner < end
        };
        self.counts.iter().position(owns).unwrap_or(0)
    }

    /// The vertex indices of each polygon, in order.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = self.indices.as_slice();
        self.counts.iter().map(move |&n| {
            let (face, tail) = rest.split_at(n as usize);
            rest = tail;
            face
        })
    }
}

impl Faces {
    /// How many triangles `rhytid_geometry::triangulate` makes of these polygons.
    pub fn triangle_count(&self) -> usize {
        self.counts.iter().map(|&n| n as usize - 2).sum()
    }

    /// For triangles made by `rhytid_geometry::triangulate`, the corner (index into [`Faces::indices`]) of
    /// each of their vertices. `None` if `triangles` were not made from these polygons.
    pub fn triangle_corners(&self, triangles: &[[u32; 3]]) -> Option<Vec<[u32; 3]>> {
        if triangles.len() != self.triangle_count() {
            return None;
        }
        let mut out = Vec::with_capacity(triangles.len());
        let mut triangles = triangles.iter();
        let mut corner_of: HashMap<u32, u32> = HashMap::new();
        let mut first = 0;
        for face in self.iter() {
            // Most faces are small enough for a linear search. A polygon of thousands of corners is not.
            corner_of.clear();
            if face.len() > 32 {
                corner_of.extend(face.iter().copied().zip(0..));
            }
            for triangle in triangles.by_ref().take(face.len() - 2) {
                let mut corners = [0; 3];
                for (corner, v) in corners.iter_mut().zip(triangle) {
                    let found = match corner_of.is_empty() {
                        true => face.iter().zip(0..).find(|(w, _)| *w == v).map(|(_, corner)| corner),
                        false => corner_of.get(v).copied(),
                    };
                    *corner = first + found?;
                }
                out.push(corners);
            }
            first += face.len() as u32;
        }
        Some(out)
    }
}

/// Texture coordinates, with (0, 0) at the lower left as in OBJ and USD (glTF's origin is the upper left).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Uvs {
    /// The coordinates.
    pub values: Vec<[f32; 2]>,
    /// For each corner of [`Faces`], its entry in `values`; `None` where `values` has one entry per vertex.
    pub corners: Option<Vec<u32>>,
}

impl Uvs {
    /// What is wrong with these as texture coordinates of `faces` over `vertices` vertices, as a phrase
    /// without its subject; `None` if nothing is. Faces are numbered from 1.
    pub fn fault(&self, vertices: usize, faces: &Faces) -> Option<String> {
        let (values, corners) = (self.values.len(), faces.indices.len());
        if let Some(i) = self.values.iter().position(|uv| uv.iter().any(|c| !c.is_finite())) {
            return Some(format!(
                "texture coordinate {i} (counted from 0) is {:?}, expected finite numbers",
                self.values[i]
            ));
        }
        match &self.corners {
            None => (values != vertices).then(|| {
                format!("has {values} texture coordinates for {vertices} vertices, expected one for each")
            }),
            Some(named) if named.len() != corners => Some(format!(
                "has {} texture indices for {corners} face corners, expected one for each",
                named.len()
            )),
            Some(named) => named.iter().position(|&i| i as usize >= values).map(|corner| {
                format!(
                    "face {} refers to texture coordinate {}, expected one of its {values} (counted from 0)",
                    faces.of_corner(corner) + 1,
                    named[corner]
                )
            }),
        }
    }
}

/// A polygon mesh as it was read: vertex order, polygons and texture coordinates are kept.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// V positions in mesh units, finite.
    pub positions: Vec<[f64; 3]>,
    /// The polygons; every index below V.
    pub faces: Faces,
    /// Texture coordinates, if the input had any.
    pub uvs: Option<Uvs>,
    /// Materials, if the input names any.
    pub materials: Option<Materials>,
}

impl Mesh {
    /// Smallest and largest coordinates; `None` without vertices.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold([first, first], |[lo, hi], p| {
            [std::array::from_fn(|i| lo[i].min(p[i])), std::array::from_fn(|i| hi[i].max(p[i]))]
        }))
    }
}
