//! The surface of a rig: the neutral mesh and the data for its export.
use super::number;
use crate::{Error, Faces, Materials, Result, UpAxis, Uvs, VertexId};
use rhytid_kernels::Real;
use rhytid_kernels::normals::{VertexTriangles, joined_triangles};
use std::borrow::Cow;

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
    /// V: the lowest of the vertices that are one point of the surface with this vertex, such as those on
    /// both sides of a texture seam. They have equal numbers everywhere in the rig. Handles and all lists of
    /// vertices name the lowest. `None` if each vertex is a point of its own.
    pub joined: Option<Vec<VertexId>>,
}

/// The most triangles around a point of several vertices. Devices have a list of them for each vertex.
pub const MOST_AROUND_JOINED: usize = 256;

impl<T: Real> Surface<T> {
    /// Where these vertices are at rest, in mesh units.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn at(&self, vertices: &[VertexId]) -> Vec<[T; 3]> {
        vertices.iter().map(|v| self.rest[v.index()]).collect()
    }

    /// The lowest vertex of the point of vertex `v`.
    pub fn first(&self, v: u32) -> u32 {
        self.joined.as_ref().map_or(v, |joined| joined[v as usize].0)
    }

    /// The triangles around the point of each vertex.
    pub fn vertex_triangles(&self) -> VertexTriangles {
        match &self.joined {
            Some(joined) => {
                VertexTriangles::joined(self.rest.len(), &self.triangles, VertexId::numbers(joined))
            }
            None => VertexTriangles::new(self.rest.len(), &self.triangles),
        }
    }

    /// The triangles between points. Each point is named by its lowest vertex, and its other vertices are in
    /// no triangle.
    pub fn joined_triangles(&self) -> Cow<'_, [[u32; 3]]> {
        match &self.joined {
            Some(joined) => Cow::Owned(joined_triangles(&self.triangles, VertexId::numbers(joined))),
            None => Cow::Borrowed(&self.triangles),
        }
    }

    /// The vertices of joined points that are not the lowest of theirs, each with the lowest. Ascending.
    pub fn copies(&self) -> impl Iterator<Item = (VertexId, VertexId)> {
        let joined = self.joined.iter().flatten();
        (0..).map(VertexId).zip(joined.copied()).filter(|(v, first)| v != first)
    }

    /// Gives each vertex the number of the lowest of its point, in V numbers.
    pub fn spread<E: Copy>(&self, numbers: &mut [E]) {
        self.copies().for_each(|(v, first)| numbers[v.index()] = numbers[first.index()]);
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
            joined: self.joined.clone(),
        }
    }
}
