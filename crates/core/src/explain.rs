//! Why a vertex is where it is in a frame: its influences, and the examples that its wrinkles come from.

use crate::{Error, HandleId, Result, Rig, StrainEdgeId};
use rhytid_kernels::vec3;
use rhytid_kernels::vector_differences::limited;

/// What drives one vertex in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The handles that its large scale follows, and the weights B_vh (1 for all of it). The largest weight
    /// comes first; handles with 0 are left out.
    pub handles: Vec<HandleShare>,
    /// The strain edges that influence it. The largest weight comes first; edges with 0 are left out.
    pub edges: Vec<EdgeShare>,
    /// The anchors that influence it, which are single handles, and their weights ν from 0 to 1. The largest
    /// weight comes first; anchors with 0 are left out.
    pub anchors: Vec<HandleShare>,
    /// How far the frame is from the rest pose, as the vertex sees it: a ratio, as a strain is.
    pub from_rest: f64,
    /// The rest pose's part of the wrinkles, as [`ExampleShare::wrinkle`]. It is 0 except with the chapter's
    /// method.
    pub wrinkle_of_rest: [f64; 3],
    /// All examples, in the rig's order.
    pub examples: Vec<ExampleShare>,
}

/// A handle that a vertex follows, or an anchor that influences it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandleShare {
    /// Which handle.
    pub handle: HandleId,
    /// How far.
    pub weight: f64,
}

/// A strain edge that influences a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeShare {
    /// Which strain edge.
    pub edge: StrainEdgeId,
    /// α, from 0 to 1.
    pub weight: f64,
    /// How much longer the edge is than at rest: 0.1 for a tenth.
    pub strain: f64,
}

/// What an example does to a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExampleShare {
    /// How far the frame is from the example, as the vertex sees it: a ratio, 0 where it is the example.
    pub distance: f64,
    /// This example's part of the wrinkles, in mesh units. It is along the mesh's axes, or in the tangent
    /// frame t, b, n where wrinkles are functions of strain lengths ([`Rig::vector_wrinkles`] says which).
    /// The sum over all examples and [`Explanation::wrinkle_of_rest`] is the vertex's detail.
    pub wrinkle: [f64; 3],
}

impl Explanation {
    /// The sum of all parts: the vertex's detail.
    pub fn wrinkle(&self) -> [f64; 3] {
        self.examples.iter().fold(self.wrinkle_of_rest, |sum, example| vec3::add(sum, example.wrinkle))
    }
}

impl Rig {
    /// What drives `vertex` where the H handles are at these positions, in mesh units and head space, in the
    /// order of [`HandleSet::labels`](crate::HandleSet::labels).
    ///
    /// # Errors
    /// [`Error::Input`] if there is no such vertex, or not H positions.
    pub fn explain(&self, vertex: usize, handle_positions: &[[f32; 3]]) -> Result<Explanation> {
        if vertex >= self.vertices() {
            let last = self.vertices() - 1;
            return Err(Error::out_of_range(format!("vertex {vertex}: the rig's vertices are 0 to {last}")));
        }
        let h = self.handles().len();
        if handle_positions.len() != h {
            let found = handle_positions.len();
            return Err(Error::mismatch(format!("{found} handle positions, expected those of {h} handles")));
        }
        let strains = self.handles().strains(handle_positions);
        let edges = self.influences().at(vertex).map(|(edge, weight)| EdgeShare {
            edge,
            weight: weight.into(),
            strain: strains[edge.index()].into(),
        });
        let mut edges: Vec<EdgeShare> = edges.filter(|edge| edge.weight > 0.0).collect();
        edges.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.edge.cmp(&b.edge)));
        let share = |(handle, weight): (HandleId, f32)| HandleShare { handle, weight: weight.into() };
        let anchors = self.learned().into_iter().flat_map(|learned| learned.anchors_of(vertex)).map(share);
        let basis = self.basis().row(vertex).iter().enumerate();
        let basis = basis.map(|(h, b)| share((HandleId::from_index(h), *b)));
        let (from_rest, examples) = match self.vector_wrinkles() {
            true => self.shares_of_vectors(vertex, handle_positions),
            false => self.shares_of_lengths(vertex, &strains),
        };
        let of_rest = self.fine_scale().rbf_weights.row(vertex).first().filter(|_| self.learned().is_none());
        let wrinkle_of_rest = of_rest.map_or([0.0; 3], |w| w.map(|w| f64::from(w) * from_rest));
        Ok(Explanation {
            handles: the_most_first(basis),
            edges,
            anchors: the_most_first(anchors),
            from_rest,
            wrinkle_of_rest,
            examples,
        })
    }

    /// Wrinkles of vector strains: `Σ_p w_p (d_p − d_0 − ‖p‖)`, with the distances that the kernels
    /// `vector_differences` and `bands` make.
    fn shares_of_vectors(&self, vertex: usize, handles: &[[f32; 3]]) -> (f64, Vec<ExampleShare>) {
        let features = self.handles().features();
        let vectors = self.handles().vector_strains(handles).into_iter().zip(self.feature_limits());
        let frame: Vec<[f64; 3]> = vectors.map(|(d, limit)| limited(d, limit.into())).collect();
        let rest = vec![[0.0; 3]; features];
        let apart = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            let square = |e: usize| {
                let off = vec3::sub(a[e], b[e]);
                vec3::dot(off, off)
            };
            self.influences_of(vertex).map(|(e, weight)| weight * square(e)).sum::<f64>().max(0.0).sqrt()
        };
        let from_rest = apart(&frame, &rest);
        let examples = self.examples().handles.rows().zip(self.wrinkle_row(vertex));
        let share = |(example, weight): (&[[f32; 3]], [f64; 3])| {
            let example = self.handles().vector_strains(example);
            let distance = apart(&frame, &example);
            let wrinkle = weight.map(|w| w * (distance - from_rest - apart(&example, &rest)));
            ExampleShare { distance, wrinkle }
        };
        (from_rest, examples.map(share).collect())
    }

    /// Wrinkles of strain lengths: the same sum or, with the chapter's method, `Σ_j w_j d_j`.
    fn shares_of_lengths(&self, vertex: usize, strains: &[f32]) -> (f64, Vec<ExampleShare>) {
        let apart = |a: &[f32], b: &[f32]| {
            let square = |(e, alpha): (StrainEdgeId, f32)| {
                let e = e.index();
                f64::from(alpha) * (f64::from(a[e]) - f64::from(b[e])).powi(2)
            };
            self.influences().at(vertex).map(square).sum::<f64>().sqrt()
        };
        let mut centers = self.fine_scale().pose_features.rows();
        let rest = centers.next().unwrap_or_default();
        let from_rest = apart(strains, rest);
        let is_learned = self.learned().is_some();
        let share = |(center, weight): (&[f32], [f64; 3])| {
            let distance = apart(strains, center);
            let beyond_rest = if is_learned { distance - from_rest - apart(center, rest) } else { distance };
            ExampleShare { distance, wrinkle: weight.map(|w| w * beyond_rest) }
        };
        (from_rest, centers.zip(self.wrinkle_row(vertex)).map(share).collect())
    }

    /// The weights of a vertex's wrinkles for each example.
    fn wrinkle_row(&self, vertex: usize) -> impl Iterator<Item = [f64; 3]> {
        self.fine_scale().rbf_weights.row(vertex).iter().skip(1).map(|w| w.map(f64::from))
    }
}

fn the_most_first(shares: impl Iterator<Item = HandleShare>) -> Vec<HandleShare> {
    let mut shares: Vec<HandleShare> = shares.filter(|share| share.weight != 0.0).collect();
    shares.sort_by(|a, b| b.weight.abs().total_cmp(&a.weight.abs()).then(a.handle.cmp(&b.handle)));
    shares
}
