//! The surface of a rig: the neutral mesh and the data for its export.
use super::number;
use crate::{Error, Faces, Materials, Result, UpAxis, Uvs, VertexId};
use rhytid_kernels::Real;

/// The neutral mesh of V vertices, and the data for its export.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface<T: Real = f32> {
    /// The name of exports.
    pub name: String,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// The mesh's up axis.
    pub up_axis: UpAxis,
    /// The polygons of the neutral mesh, for export.
    pub faces: Faces,
    /// The texture coordinates of the neutral mesh, for export.
    pub uvs: Option<Uvs>,
    /// The materials that the neutral mesh names, for export.
    pub materials: Option<Materials>,
    /// Triangles of the computation.
    pub triangles: Vec<[u32; 3]>,
    /// V×3 rest positions in mesh units.
    pub rest: Vec<[T; 3]>,
    /// V one-ring neighbours that orient the tangent frames (section 5); a vertex without any names itself.
    pub tangent_neighbors: Vec<VertexId>,
}

impl<T: Real> Surface<T> {
    /// Where these vertices are at rest, in mesh units.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn at(&self, vertices: &[VertexId]) -> Vec<[T; 3]> {
        vertices.iter().map(|v| self.rest[v.index()]).collect()
    }

    /// For each triangle, the corner (index into [`Faces::indices`]) of each of its vertices. Formats that
    /// have only triangles need it.
    ///
    /// # Errors
    /// [`Error::Internal`] if the triangles are not made from the faces. Those of a [`Rig`](crate::Rig) are.
    pub fn triangle_corners(&self) -> Result<Vec<[u32; 3]>> {
        let corners = self.faces.triangle_corners(&self.triangles);
        corners.ok_or_else(|| Error::Internal("the rig has other triangles than faces".into()))
    }

    pub(super) fn cast<U: Real>(&self) -> Surface<U> {
        Surface {
            name: self.name.clone(),
            metres_per_unit: self.metres_per_unit,
            up_axis: self.up_axis,
            faces: self.faces.clone(),
            uvs: self.uvs.clone(),
            materials: self.materials.clone(),
            triangles: self.triangles.clone(),
            rest: self.rest.iter().map(|x| x.map(number)).collect(),
            tangent_neighbors: self.tangent_neighbors.clone(),
        }
    }
}
