//! Frames that are refined one by one.

use rhytid_core::{Progress, Result, Rig};
use rhytid_kernels::normals::{self, VertexTriangles};
use rhytid_solve::Refine;

/// A rig's [`Refine`], and the buffer of the frame that it computes.
pub(crate) struct Refined<'a> {
    rig: &'a Rig,
    refine: Refine,
    vertex_triangles: &'a VertexTriangles,
    /// V.
    exact: Vec<[f64; 3]>,
}

impl<'a> Refined<'a> {
    /// As [`Refine::new`].
    pub(crate) fn new(
        rig: &'a Rig,
        vertex_triangles: &'a VertexTriangles,
        progress: &dyn Progress,
    ) -> Result<Self> {
        Ok(Self { rig, refine: Refine::new(&rig.widened(), progress)?, vertex_triangles, exact: Vec::new() })
    }

    /// Refines a frame's V positions from the positions of its H handles, and computes its normals again.
    ///
    /// `normals` is empty where no normals are wanted.
    pub(crate) fn frame(
        &mut self,
        handles: &[[f32; 3]],
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        let widened = |x: &[[f32; 3]]| x.iter().map(|x| x.map(f64::from)).collect();
        let handles: Vec<[f64; 3]> = widened(handles);
        self.exact = widened(positions);
        self.refine.frame(&handles, &mut self.exact);
        positions.iter_mut().zip(&self.exact).for_each(|(x, exact)| *x = exact.map(|x| x as f32));
        for (v, n) in normals.iter_mut().enumerate() {
            *n =
                normals::vertex_normal(positions, &self.rig.surface().triangles, self.vertex_triangles.at(v));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Playback, Selection};
    use rhytid_core::{NoProgress, Take, channel};
    use rhytid_devices::{Guard, choose_devices};
    use rhytid_formats::export::{Frame, Recipe};

    #[test]
    fn frames_are_what_refine_makes_of_them_and_normals_are_theirs() {
        let mut face = rhytid_demo::face(1_000);
        face.examples.clear();
        face.settings.rotations = true;
        let exact = rhytid_solve::solve(&face, &NoProgress).unwrap();
        let (rig, refine) = (exact.rounded().unwrap(), Refine::new(&exact, &NoProgress).unwrap());
        let bent = |x: [f64; 3]| [1.3 * x[0], x[1] + 0.3 * x[0], x[2] - 0.4 * x[0].abs()];
        let bent: Vec<[f64; 3]> = exact.handles().rest.iter().map(|x| bent(*x)).collect();
        let take = Take {
            labels: rig.handles().labels.clone(),
            times: vec![0.0, 0.1, 0.2],
            positions: [&bent[..], &bent[..], &bent[..]].concat(),
            confidence: None,
            head: None,
        };
        let handles = take.handle_positions(&rig.handles().labels).unwrap();
        let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
        let mut playback = Playback::new(&rig, &devices, 3).unwrap();
        let selection = Selection::all(take).unwrap();
        let frames = |playback: &mut Playback<'_>, refine| {
            let recipe = Recipe { refine, ..Recipe::default() };
            let mut frames: Vec<[Vec<f32>; 2]> = Vec::new();
            let each = |frame: &Frame<'_>| {
                let normals = frame.get(&channel::NORMALS).unwrap_or_default();
                frames.push([frame.positions().to_vec(), normals.to_vec()]);
                Ok(())
            };
            playback.play(&selection, &recipe, &NoProgress, each).unwrap();
            frames
        };
        let [before, after] = [false, true].map(|refine| frames(&mut playback, refine));
        let widened = |x: &[f32]| x.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect::<Vec<_>>();
        let vertex_triangles = rig.surface().vertex_triangles();
        for ((before, after), handles) in
            before.iter().zip(&after).zip(handles.chunks(3 * rig.handles().len()))
        {
            let mut expected = widened(&before[0]);
            refine.frame(&widened(handles), &mut expected);
            let [positions, normals] = after.each_ref().map(|x| x.as_chunks::<3>().0);
            let farthest = |a: &[[f64; 3]], b: &[[f64; 3]]| {
                let apart = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
                apart.fold(0.0, f64::max)
            };
            let found = widened(&after[0]);
            assert!(farthest(&found, &expected) < 1e-5);
            assert!(farthest(&found, &widened(&before[0])) > 1e-2, "it changes nothing");
            for (h, point) in rig.handles().points.iter().enumerate() {
                assert_eq!(point.at(positions), handles[3 * h..][..3]);
            }
            for (v, found) in normals.iter().enumerate() {
                let incident = vertex_triangles.at(v);
                assert_eq!(*found, normals::vertex_normal(positions, &rig.surface().triangles, incident));
            }
        }
    }
}
