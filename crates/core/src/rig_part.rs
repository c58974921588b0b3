//! A few vertices of a rig as a rig of their own.

use crate::{
    Contact, Faces, FineScale, HandleSet, Influences, Learned, Rig, RigParts, Surface, Table, VertexId,
};
use rhytid_kernels::Real;
use std::collections::HashMap;

const ABSENT: VertexId = VertexId(u32::MAX);

impl<T: Real> Rig<T> {
    /// The rig of `vertices` (distinct, in range) and of all handles. The chosen vertices come first, in
    /// their order; the vertices around them and those of the handles follow. With the same handle positions
    /// the chosen vertices have the same results as in the whole rig. Other vertices may differ, since some
    /// of their neighbours are missing.
    pub fn part(&self, vertices: &[VertexId]) -> Self {
        let (surface, handles, influences) = (self.surface(), self.handles(), self.influences());
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
        let rows = Rows { kept: &kept };
        let neighbors = kept.iter().enumerate().map(|(own, v)| {
            let neighbor = place[surface.tangent_neighbors[v.index()].index()];
            if neighbor == ABSENT { VertexId::from_index(own) } else { neighbor }
        });
        let mut first = HashMap::new();
        let of_part = |(own, v): (usize, &VertexId)| {
            *first.entry(surface.first(v.0)).or_insert(VertexId::from_index(own))
        };
        let joined =
            surface.joined.is_some().then(|| kept.iter().enumerate().map(of_part).collect::<Vec<_>>());
        // Each row comes from a sound rig, and each index is of a vertex that was kept.
        Self::of_sound(RigParts {
            surface: Surface {
                name: surface.name.clone(),
                metres_per_unit: surface.metres_per_unit,
                up_axis: surface.up_axis,
                faces,
                uvs: None,
                materials: None,
                triangles,
                rest: surface.at(&kept),
                tangent_neighbors: neighbors.collect(),
                joined,
            },
            handles: HandleSet {
                points: handles.points.iter().map(|point| point.renamed(|v| place[v.index()])).collect(),
                ..handles.clone()
            },
            examples: self.examples().clone(),
            bending_length: self.bending_length(),
            basis: rows.select(self.basis()),
            influences: Influences {
                edges: rows.select(&influences.edges),
                weights: rows.select(&influences.weights),
                beta: influences.beta,
            },
            fine_scale: FineScale {
                pose_features: self.fine_scale().pose_features.clone(),
                rbf_weights: rows.select(&self.fine_scale().rbf_weights),
            },
            learned: self.learned().map(|learned| rows.of_learned(learned)),
        })
    }
}

/// The vertices whose rows are taken.
struct Rows<'a> {
    kept: &'a [VertexId],
}

impl Rows<'_> {
    fn select<E: Clone>(&self, table: &Table<E>) -> Table<E> {
        table.chosen(self.kept.iter().map(|v| v.index()))
    }

    fn of_learned<T: Real>(&self, learned: &Learned<T>) -> Learned<T> {
        Learned {
            anchors: self.select(&learned.anchors),
            anchor_weights: self.select(&learned.anchor_weights),
            feature_gains: self.select(&learned.feature_gains),
            example_weights: self.select(&learned.example_weights),
            variances: self.kept.iter().map(|v| learned.variances[v.index()]).collect(),
            prior_lengths: learned.prior_lengths.clone(),
            // It needs whole eyeballs, and belongs to whole frames.
            contact: Contact::default(),
            ..*learned
        }
    }
}
