//! A few vertices of a rig as a rig of their own.

use crate::rig_rows::Rows;
use crate::{Contact, Faces, Rig, Surface, VertexId};
use rhytid_kernels::Real;

const ABSENT: VertexId = VertexId(u32::MAX);

impl<T: Real> Rig<T> {
    /// The rig of `vertices` (distinct, in range) and of all handles. The chosen vertices come first, in
    /// their order; the vertices around them and those of the handles follow. With the same handle positions
    /// the chosen vertices have the same results as in the whole rig. Other vertices may differ, since some
    /// of their neighbours are missing.
    pub fn part(&self, vertices: &[VertexId]) -> Self {
        let (surface, handles) = (self.surface(), self.handles());
        let mut place = vec![ABSENT; self.vertices()];
        let mut kept: Vec<VertexId> = Vec::new();
        let mut keep = |v: VertexId| {
            let place = &mut place[v.index()];
            if *place == ABSENT {
                *place = VertexId::from_index(kept.len());
                kept.push(v);
            }
        };
        vertices.iter().for_each(|&v| keep(v));
        handles.held().for_each(&mut keep);
        vertices.iter().for_each(|&v| keep(surface.tangent_neighbors[v.index()]));
        let mut wanted = vec![false; self.vertices()];
        vertices.iter().for_each(|&v| wanted[surface.first(v.0) as usize] = true);
        let is_wanted = |&v: &u32| wanted[surface.first(v) as usize];
        let around = surface.triangles.iter().filter(|triangle| triangle.iter().any(is_wanted));
        let mut around: Vec<&[u32; 3]> = around.collect();
        if around.is_empty() {
            // A rig has at least one triangle.
            around.extend(surface.triangles.first());
        }
        around.iter().copied().flatten().for_each(|&v| keep(VertexId(v)));
        let triangles: Vec<[u32; 3]> = around.into_iter().map(|t| t.map(|v| place[v as usize].0)).collect();

        let mut faces = Faces::default();
        triangles.iter().for_each(|triangle| faces.push(triangle));
        let rows = Rows::new(&kept, self.vertices());
        let neighbors = kept.iter().enumerate().map(|(own, v)| {
            rows.place(surface.tangent_neighbors[v.index()]).unwrap_or(VertexId::from_index(own))
        });
        let surface = Surface {
            name: surface.name.clone(),
            metres_per_unit: surface.metres_per_unit,
            up_axis: surface.up_axis,
            faces,
            uvs: None,
            materials: None,
            triangles,
            rest: surface.at(&kept),
            tangent_neighbors: neighbors.collect(),
            joined: rows.joined(surface),
        };
        // Each row comes from a sound rig, and each index is of a vertex that was kept. What touches needs
        // whole eyeballs, and belongs to whole frames.
        Self::of_sound(rows.parts(self, surface, Contact::default()))
    }
}
