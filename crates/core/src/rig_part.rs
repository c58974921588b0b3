//! A few vertices of a rig as a rig of their own.

use crate::{Faces, Learned, Rig};
use rhytid_kernels::Real;

const ABSENT: u32 = u32::MAX;

impl<T: Real> Rig<T> {
    /// The rig of `vertices` (distinct, in range), which come first and in their order, of all handles, and of the vertices around
    /// each of the former. With the same handle positions these vertices come to where they are in the whole; others need not, since
    /// what is around them is missing.
    pub fn part(&self, vertices: &[u32]) -> Self {
        let mut place = vec![ABSENT; self.vertices()];
        let mut kept: Vec<u32> = Vec::new();
        let mut keep = |v: u32| {
            let place = &mut place[v as usize];
            if *place == ABSENT {
                *place = kept.len() as u32;
                kept.push(v);
            }
        };
        vertices.iter().for_each(|&v| keep(v));
        self.handles.iter().for_each(|&v| keep(v));
        vertices.iter().for_each(|&v| keep(self.tangent_neighbors[v as usize]));
        let mut wanted = vec![false; self.vertices()];
        vertices.iter().for_each(|&v| wanted[v as usize] = true);
        let around = self.triangles.iter().filter(|triangle| triangle.iter().any(|&v| wanted[v as usize]));
        let mut around: Vec<&[u32; 3]> = around.collect();
        if around.is_empty() {
            // A rig has one.
            around.extend(self.triangles.first());
        }
        around.iter().copied().flatten().for_each(|&v| keep(v));
        let triangles: Vec<[u32; 3]> = around.into_iter().map(|t| t.map(|v| place[v as usize])).collect();

        let mut faces = Faces::default();
        triangles.iter().for_each(|triangle| faces.push(triangle));
        let rows = Rows { kept: &kept };
        let n = self.centers();
        let neighbors = kept.iter().zip(0..).map(|(&v, own)| {
            let neighbor = place[self.tangent_neighbors[v as usize] as usize];
            if neighbor == ABSENT { own } else { neighbor }
        });
        Self {
            name: self.name.clone(),
            metres_per_unit: self.metres_per_unit,
            up_axis: self.up_axis,
            labels: self.labels.clone(),
            example_names: self.example_names.clone(),
            faces,
            uvs: None,
            materials: None,
            bending_length: self.bending_length,
            beta: self.beta,
            handles: self.handles.iter().map(|&v| place[v as usize]).collect(),
            triangles,
            rest: rows.of(&self.rest, 1),
            basis: rows.of(&self.basis, self.handles.len()),
            strain_edges: self.strain_edges.clone(),
            influence_edges: rows.of(&self.influence_edges, self.influences()),
            influence_weights: rows.of(&self.influence_weights, self.influences()),
            tangent_neighbors: neighbors.collect(),
            pose_features: self.pose_features.clone(),
            rbf_weights: rows.of(&self.rbf_weights, n),
            example_handles: self.example_handles.clone(),
            rotations: self.rotations,
            learned: self.learned.as_ref().map(|learned| rows.of_learned(learned, self.influences())),
        }
    }
}

/// The vertices whose rows are taken.
struct Rows<'a> {
    kept: &'a [u32],
}

impl Rows<'_> {
    /// Of an array of `width` elements each.
    fn of<E: Copy>(&self, array: &[E], width: usize) -> Vec<E> {
        let mut rows = Vec::with_capacity(self.kept.len() * width);
        self.kept.iter().for_each(|&v| rows.extend_from_slice(&array[v as usize * width..][..width]));
        rows
    }

    fn of_learned<T: Real>(&self, learned: &Learned<T>, influences: usize) -> Learned<T> {
        let anchors = learned.anchors_per_vertex();
        let examples = learned.example_weights.len().checked_div(learned.variances.len()).unwrap_or(0);
        Learned {
            anchors: self.of(&learned.anchors, anchors),
            anchor_weights: self.of(&learned.anchor_weights, anchors),
            feature_gains: self.of(&learned.feature_gains, influences + anchors),
            example_weights: self.of(&learned.example_weights, examples),
            variances: self.of(&learned.variances, 1),
            ..*learned
        }
    }
}
