//! Keeps parts of a face from going into each other: lids on eyeballs, lips and lids that meet.

mod eyes;
mod openings;
#[cfg(test)]
mod test_rig;

use crate::local_normals;
use eyes::EyeContact;
use openings::OpeningContact;
use rhytid_core::Rig;
use rhytid_kernels::normals::VertexTriangles;
use std::sync::Arc;

/// What touches in a rig in which anything does.
pub(crate) struct Contact<'a> {
    rig: &'a Rig,
    vertex_triangles: Arc<VertexTriangles>,
    openings: Option<OpeningContact<'a>>,
    eyes: Option<EyeContact<'a>>,
}

impl<'a> Contact<'a> {
    /// `None` for a rig in which nothing touches.
    pub(crate) fn new(rig: &'a Rig, vertex_triangles: Arc<VertexTriangles>) -> Option<Self> {
        Self::is_for(rig).then(|| Self {
            rig,
            openings: OpeningContact::new(rig, vertex_triangles.clone()),
            eyes: EyeContact::new(rig),
            vertex_triangles,
        })
    }

    /// Whether anything touches in the rig.
    pub(crate) fn is_for(rig: &Rig) -> bool {
        rig.learned().is_some_and(|learned| !learned.contact.is_empty())
    }

    /// Moves a frame's V positions and updates its normals, which are empty where no normals are wanted.
    /// Returns which of the V vertices moved. Eyes come last, so that lids that meet do not leave the
    /// eyeball.
    pub(crate) fn frame(&self, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) -> Vec<bool> {
        let mut moved = vec![false; self.rig.vertices()];
        if let Some(openings) = &self.openings {
            openings.frame(positions, &mut moved);
        }
        if let Some(eyes) = &self.eyes {
            eyes.frame(positions, &mut moved);
        }
        let vertices = (0..).zip(&moved).filter(|(_, moved)| **moved).map(|(v, _)| v);
        local_normals::update(self.rig, &self.vertex_triangles, vertices, positions, normals);
        moved
    }
}
