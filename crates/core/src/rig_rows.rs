//! Some vertices of a rig, with all numbers that it has of them.

use crate::{Contact, FineScale, HandleSet, Influences, Learned, Rig, RigParts, Surface, Table, VertexId};
use rhytid_kernels::Real;
use std::collections::HashMap;

/// The vertices that are kept.
pub(crate) struct Rows<'a> {
    /// Distinct, in their new order.
    pub kept: &'a [VertexId],
    /// V: the new number of each vertex that is kept.
    places: Vec<Option<VertexId>>,
}

impl<'a> Rows<'a> {
    /// For a rig of V `vertices`.
    pub(crate) fn new(kept: &'a [VertexId], vertices: usize) -> Self {
        let mut places = vec![None; vertices];
        kept.iter().enumerate().for_each(|(i, v)| places[v.index()] = Some(VertexId::from_index(i)));
        Self { kept, places }
    }

    /// The new number of a vertex. `None` if it is not kept.
    pub(crate) fn place(&self, v: VertexId) -> Option<VertexId> {
        self.places[v.index()]
    }

    /// Of V numbers those of the vertices that are kept.
    pub(crate) fn of_each<E: Copy>(&self, numbers: &[E]) -> Vec<E> {
        self.kept.iter().map(|v| numbers[v.index()]).collect()
    }

    fn select<E: Clone>(&self, table: &Table<E>) -> Table<E> {
        table.chosen(self.kept.iter().map(|v| v.index()))
    }

    /// The first vertex of each vertex's point, among those that are kept.
    pub(crate) fn joined<T: Real>(&self, surface: &Surface<T>) -> Option<Vec<VertexId>> {
        surface.joined.as_ref()?;
        let mut first = HashMap::new();
        let of_vertex = |(own, v): (usize, &VertexId)| {
            *first.entry(surface.first(v.0)).or_insert(VertexId::from_index(own))
        };
        Some(self.kept.iter().enumerate().map(of_vertex).collect())
    }

    /// The parts of a rig on these vertices, which include those that handles hold. `surface` and `contact`
    /// are theirs.
    pub(crate) fn parts<T: Real>(
        &self,
        rig: &Rig<T>,
        surface: Surface<T>,
        contact: Contact<T>,
    ) -> RigParts<T> {
        let (handles, influences) = (rig.handles(), rig.influences());
        let renamed = |v: VertexId| self.place(v).unwrap_or(v);
        RigParts {
            surface,
            handles: HandleSet {
                points: handles.points.iter().map(|point| point.renamed(renamed)).collect(),
                ..handles.clone()
            },
            examples: rig.examples().clone(),
            bending_length: rig.bending_length(),
            basis: self.select(rig.basis()),
            influences: Influences {
                edges: self.select(&influences.edges),
                weights: self.select(&influences.weights),
                beta: influences.beta,
            },
            fine_scale: FineScale {
                pose_features: rig.fine_scale().pose_features.clone(),
                rbf_weights: self.select(&rig.fine_scale().rbf_weights),
            },
            learned: rig.learned().map(|learned| Learned {
                anchors: self.select(&learned.anchors),
                anchor_weights: self.select(&learned.anchor_weights),
                feature_gains: self.select(&learned.feature_gains),
                example_weights: self.select(&learned.example_weights),
                variances: self.of_each(&learned.variances),
                prior_lengths: learned.prior_lengths.clone(),
                contact,
                ..*learned
            }),
        }
    }
}
