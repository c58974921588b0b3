//! Frames that are refined one by one.

use rhytid_core::{Progress, Result, Rig};
use rhytid_kernels::normals::{self, VertexTriangles};
use rhytid_solve::Refine;

/// A rig's [`Refine`], and the frame that it refined last.
pub(crate) struct Refined<'a> {
    rig: &'a Rig,
    refine: Refine,
    vertex_triangles: VertexTriangles,
    /// V, as they are computed, and as they are shown.
    exact: Vec<[f64; 3]>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl<'a> Refined<'a> {
    /// As [`Refine::new`].
    pub(crate) fn new(rig: &'a Rig, progress: &dyn Progress) -> Result<Self> {
        Ok(Self {
            rig,
            refine: Refine::new(&rig.cast(), progress)?,
            vertex_triangles: VertexTriangles::new(rig.vertices(), &rig.triangles),
            exact: Vec::new(),
            positions: Vec::new(),
            normals: Vec::new(),
        })
    }

    /// A frame's 3V positions and normals (empty where they are not wanted), refined, of those before and the 3H positions of its handles.
    pub(crate) fn frame(&mut self, handles: &[f32], [positions, normals]: [&[f32]; 2]) -> [&[f32]; 2] {
        let widened = |numbers: &[f32]| numbers.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect();
        let handles: Vec<[f64; 3]> = widened(handles);
        self.exact = widened(positions);
        self.refine.frame(&handles, &mut self.exact);
        self.positions.clear();
        self.positions.extend(self.exact.iter().map(|x| x.map(|x| x as f32)));
        self.normals.clear();
        if !normals.is_empty() {
            let of_vertex = |v| {
                let incident = self.vertex_triangles.at(v);
                normals::vertex_normal(&self.positions, &self.rig.triangles, incident)
            };
            self.normals.extend((0..self.rig.vertices()).map(of_vertex));
        }
        [self.positions.as_flattened(), self.normals.as_flattened()]
    }
}
