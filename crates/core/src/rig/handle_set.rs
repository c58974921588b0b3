//! The handles of a rig: their labels, their rest positions, and what is measured from them in a frame.
use crate::{HandleId, Rotations, SurfacePoint, VertexId};
use rhytid_kernels::{Real, strain, vec3};
use std::collections::BTreeMap;

/// H handles and the F strain edges between them.
///
/// *Features* are the strain edges, counted from 0, and after them the handles by themselves: F + H in all.
#[derive(Debug, Clone, PartialEq)]
pub struct HandleSet<T: Real = f32> {
    /// H labels, distinct.
    pub labels: Vec<String>,
    /// H points of the surface.
    pub points: Vec<SurfacePoint>,
    /// H rest positions in mesh units: those of the points.
    pub rest: Vec<[T; 3]>,
    /// F pairs of handles (section 3).
    pub strain_edges: Vec<[HandleId; 2]>,
    /// Whether the large scale turns at each handle as the handles around it do ([`Rotations`]).
    pub rotations: bool,
}

/// What the kernel `large_scale` reads of frames × H handle positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Motions<T> {
    /// Frames × H displacements from rest or, where the handles turn, frames × 4 × H vectors of
    /// [`Rotations::motions`].
    pub vectors: Vec<[T; 3]>,
    /// The vertex that they turn about. `None` where they do not turn.
    pub center: Option<VertexId>,
}

impl<T: Real> HandleSet<T> {
    /// H.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is none. A [`Rig`](crate::Rig) has at least one.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Where the handles are on a mesh with these V positions, H in their unit.
    pub fn at(&self, positions: &[[T; 3]]) -> Vec<[T; 3]> {
        self.points.iter().map(|point| point.at(positions)).collect()
    }

    /// The vertices that the handles hold: one to three of each. Two handles may hold the same vertex.
    pub fn held(&self) -> impl Iterator<Item = VertexId> {
        self.points.iter().flat_map(|point| point.corners().map(|(vertex, _)| vertex))
    }

    /// Each corner of a handle inside a triangle, with the vertex whose influences it has. Handles that share
    /// a corner have one such vertex.
    ///
    /// What is added to the corners of a triangle is linear in numbers whose mean at the handle is 0, so the
    /// handle stays if all else is alike there.
    pub fn alike(&self) -> Vec<(VertexId, VertexId)> {
        let mut as_of: BTreeMap<VertexId, VertexId> = BTreeMap::new();
        for point in self.points.iter().filter(|point| point.vertex().is_none()) {
            let known: Vec<VertexId> = point.corners().filter_map(|(v, _)| as_of.get(&v).copied()).collect();
            let own = known.first().copied().unwrap_or(point.nearest_vertex());
            as_of.values_mut().filter(|v| known.contains(v)).for_each(|v| *v = own);
            as_of.extend(point.corners().map(|(v, _)| (v, own)));
        }
        as_of.into_iter().filter(|(corner, as_of)| corner != as_of).collect()
    }

    /// F + H: the number of features.
    pub fn features(&self) -> usize {
        self.strain_edges.len() + self.len()
    }

    /// The strain edges as kernels read them.
    pub fn edge_numbers(&self) -> &[[u32; 2]] {
        bytemuck::cast_slice(&self.strain_edges)
    }

    /// l: the F lengths of the strain edges at rest, in mesh units.
    pub fn rest_lengths(&self) -> Vec<T> {
        let at = |h: HandleId| self.rest[h.index()];
        self.strain_edges.iter().map(|&[a, b]| vec3::length(vec3::sub(at(a), at(b)))).collect()
    }

    /// f, frames × F strains (section 3) of frames × H handle positions.
    pub fn strains(&self, handle_positions: &[[T; 3]]) -> Vec<T> {
        let frames = handle_positions.len().checked_div(self.len()).unwrap_or(0);
        let params = strain::Params {
            frames: frames as u32,
            handles: self.len() as u32,
            strain_edges: self.strain_edges.len() as u32,
        };
        let mut features = vec![T::ZERO; frames * self.strain_edges.len()];
        let (edges, lengths) = (self.edge_numbers(), self.rest_lengths());
        strain::strain(params, handle_positions, &self.rest, edges, &lengths, &mut features);
        features
    }

    /// The lengths by which displacements are divided, F + H in mesh units. A strain edge has its rest length
    /// `l_e`. An anchor has `L`, the mean of all `l_e`. Without a strain edge, L is 1.
    pub fn feature_lengths(&self) -> Vec<f64> {
        let mut lengths = self.exact_rest_lengths();
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        let mean = if lengths.is_empty() { 1.0 } else { mean };
        lengths.extend(std::iter::repeat_n(mean, self.len()));
        lengths
    }

    /// The rest lengths in f64, for any precision.
    fn exact_rest_lengths(&self) -> Vec<f64> {
        let at = |h: HandleId| self.rest[h.index()].map(T::widen);
        let length = |&[a, b]: &[HandleId; 2]| {
            let (a, b) = (at(a), at(b));
            (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
        };
        self.strain_edges.iter().map(length).collect()
    }

    /// `D_e = (u_b − u_a) / l_e` of the strain edges and `D_h = u_h / L` of the handles, F + H, where the H
    /// handles are at `positions`.
    pub fn vector_strains(&self, positions: &[[T; 3]]) -> Vec<[f64; 3]> {
        let lengths = self.feature_lengths();
        let of_lengths = self.moved_features(positions).into_iter().zip(lengths);
        of_lengths.map(|(moved, length)| moved.map(|x| x / length)).collect()
    }

    /// `u_b − u_a` of the strain edges and `u_h` of the handles, F + H in mesh units, where the H handles are
    /// at `positions`.
    fn moved_features(&self, positions: &[[T; 3]]) -> Vec<[f64; 3]> {
        let u = self.displacements(positions);
        let of_edges = self.strain_edges.iter().map(|&[a, b]| vec3::sub(u[b.index()], u[a.index()]));
        of_edges.chain(u.iter().copied()).collect()
    }

    /// u, H in mesh units: the displacements from rest of handles at `positions`.
    pub fn displacements(&self, positions: &[[T; 3]]) -> Vec<[f64; 3]> {
        let pairs = positions.iter().zip(&self.rest);
        pairs.map(|(x, rest)| [0, 1, 2].map(|c| x[c].widen() - rest[c].widen())).collect()
    }

    /// What the kernel `large_scale` reads for handles at frames × H positions.
    pub fn motions(&self, handle_positions: &[[T; 3]]) -> Motions<T> {
        if let Some(rotations) = Rotations::new(self) {
            let center = Some(self.points[rotations.center()].nearest_vertex());
            return Motions { vectors: rotations.motions(handle_positions), center };
        }
        let pairs = handle_positions.iter().zip(self.rest.iter().cycle());
        Motions { vectors: pairs.map(|(p, rest)| vec3::sub(*p, *rest)).collect(), center: None }
    }

    /// `rest` has the V rest positions of the surface in the new precision.
    pub(super) fn cast<U: Real>(&self, rest: &[[U; 3]]) -> HandleSet<U> {
        HandleSet {
            labels: self.labels.clone(),
            points: self.points.clone(),
            rest: self.points.iter().map(|point| point.at(rest)).collect(),
            strain_edges: self.strain_edges.clone(),
            rotations: self.rotations,
        }
    }
}
