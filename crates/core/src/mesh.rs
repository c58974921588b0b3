use serde::{Deserialize, Serialize};

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

/// Texture coordinates, with (0, 0) at the lower left as in OBJ and USD (glTF's origin is the upper left).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Uvs {
    /// The coordinates.
    pub values: Vec<[f32; 2]>,
    /// For each corner of [`Faces`], its entry in `values`; `None` where `values` has one entry per vertex.
    pub corners: Option<Vec<u32>>,
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
