//! Mixtures of a face's examples that are fitted to the markers: what other methods make of the same scans.

use crate::blendshapes::{Blendshapes, Weights};
use rayon::prelude::*;
use rhytid_core::{Face, HandleSet, Result, Rig};
use rhytid_kernels::vec3;

/// The examples of a face as shapes that are mixed.
pub(crate) struct Mixtures<'a> {
    face: &'a Face,
    /// V×3 in mesh units.
    rest: &'a [[f64; 3]],
    handles: &'a HandleSet<f64>,
    shapes: Blendshapes,
}

impl<'a> Mixtures<'a> {
    /// `rig` is the solved face.
    pub(crate) fn new(face: &'a Face, rig: &'a Rig<f64>) -> Self {
        let (rest, handles) = (&*rig.surface().rest, rig.handles());
        let at_markers = face
            .examples
            .iter()
            .map(|example| handles.displacements(&handles.at(&example.positions)).into_flattened());
        Self { face, rest, handles, shapes: Blendshapes::new(at_markers.collect()) }
    }

    /// The weights of the P examples in each of the frames, whose markers are frames × H positions.
    ///
    /// # Errors
    /// As [`Blendshapes::fit`].
    pub(crate) fn fit(&self, markers: &[[f32; 3]], weights: Weights) -> Result<Vec<Vec<f64>>> {
        let of_frame = |frame: &[[f32; 3]]| {
            let moved = frame.iter().zip(&self.handles.rest);
            let moved = moved.flat_map(|(x, rest)| vec3::sub(x.map(f64::from), *rest));
            self.shapes.fit(&moved.collect::<Vec<f64>>(), weights)
        };
        markers.chunks(self.handles.len()).map(of_frame).collect()
    }

    /// How far a mixture moves vertex `v` from rest.
    pub(crate) fn displacement(&self, weights: &[f64], v: usize) -> [f64; 3] {
        let mut moved = [0.0; 3];
        for (w, example) in weights.iter().zip(&self.face.examples) {
            moved = vec3::add(moved, vec3::sub(example.positions[v], self.rest[v]).map(|x| w * x));
        }
        moved
    }

    /// The 3V positions of a mixture.
    pub(crate) fn positions(&self, weights: &[f64]) -> Vec<f32> {
        let of_vertex = |(v, rest): (usize, &[f64; 3])| vec3::add(*rest, self.displacement(weights, v));
        let positions: Vec<[f64; 3]> = self.rest.par_iter().enumerate().map(of_vertex).collect();
        positions.as_flattened().iter().map(|x| *x as f32).collect()
    }

    /// The markers less what the mixtures of their frames do to them: the positions of handles that the
    /// shell spreads over the face.
    pub(crate) fn left(&self, markers: &[[f32; 3]], fits: &[Vec<f64>]) -> Vec<f32> {
        let of_frame = |(frame, weights): (&[[f32; 3]], &Vec<f64>)| {
            let left = frame.iter().zip(&self.handles.points);
            let left = left.flat_map(|(x, point)| {
                let moved = point.mean(|v| self.displacement(weights, v.index()));
                vec3::sub(x.map(f64::from), moved).map(|x| x as f32)
            });
            left.collect::<Vec<f32>>()
        };
        markers.chunks(self.handles.len()).zip(fits).flat_map(of_frame).collect()
    }
}
