//! The rig: a solved face as plain data.
use crate::{Error, Faces, Learned, Materials, Result, UpAxis, Uvs};
use rayon::prelude::*;
use rhytid_kernels::{Real, strain};

/// A solved face: immutable plain data, the same for every backend.
///
/// Shapes use V vertices, H handles, F strain edges, N = P + 1 RBF centres (centre 0 is the rest pose) and K
/// influences per vertex. All arrays are row-major. `Rig<f64>` is what the solve returns and the twin
/// evaluates; `Rig<f32>` is what is stored and uploaded. References are to `docs/method.md`.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig<T: Real = f32> {
    /// Names what is exported.
    pub name: String,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// The mesh's up axis.
    pub up_axis: UpAxis,
    /// H handle labels, distinct.
    pub labels: Vec<String>,
    /// P names of the examples.
    pub example_names: Vec<String>,
    /// The polygons of the neutral mesh, for export.
    pub faces: Faces,
    /// The texture coordinates of the neutral mesh, for export.
    pub uvs: Option<Uvs>,
    /// The materials that the neutral mesh names, for export.
    pub materials: Option<Materials>,
    /// ℓ in mesh units, as solved with (section 2).
    pub bending_length: f64,
    /// β in 1/mesh unit (section 4); 0 where F ≤ K, and by the learned method, where each vertex has its own.
    pub beta: f64,

    /// H vertex indices, distinct.
    pub handles: Vec<u32>,
    /// Triangles of the computation.
    pub triangles: Vec<[u32; 3]>,
    /// V×3 rest positions in mesh units.
    pub rest: Vec<[T; 3]>,
    /// B, V×H (section 2), with ΔB of the learned method in it: identity rows at handles, zero rows at vertices that do not
    /// move.
    pub basis: Vec<T>,
    /// F pairs of handles (section 3), as indices into `handles`.
    pub strain_edges: Vec<[u32; 2]>,
    /// V×K indices of strain edges (section 4), ascending; K = `influences()`.
    pub influence_edges: Vec<u32>,
    /// α, V×K in [0, 1] (section 4).
    pub influence_weights: Vec<T>,
    /// V one-ring neighbours that orient the tangent frames (section 5); a vertex without any names itself.
    pub tangent_neighbors: Vec<u32>,
    /// f_j, N×F strains of the centres (section 6); row 0 is zero.
    pub pose_features: Vec<T>,
    /// w, V×N×3 (section 7), in mesh units; by the learned method the first of each vertex, the rest pose's, is b instead.
    pub rbf_weights: Vec<[T; 3]>,
    /// P×H positions of the handles in the examples, in mesh units: evaluated, they give the examples back.
    pub example_handles: Vec<[T; 3]>,
    /// Whether the large scale turns at each handle as the handles around it do ([`Rotations`](crate::Rotations)).
    pub rotations: bool,
    /// What the learned method adds; `None` for the chapter's.
    pub learned: Option<Learned<T>>,
}

impl<T: Real> Rig<T> {
    /// V.
    pub fn vertices(&self) -> usize {
        self.rest.len()
    }

    /// K: influences stored per vertex.
    pub fn influences(&self) -> usize {
        self.influence_edges.len().checked_div(self.vertices()).unwrap_or(0)
    }

    /// N: RBF centres, the rest pose included.
    pub fn centers(&self) -> usize {
        self.example_names.len() + 1
    }

    /// H positions of the handles at rest, in mesh units, in the order of [`Rig::labels`].
    pub fn handles_at_rest(&self) -> Vec<[T; 3]> {
        self.handles.iter().map(|&v| self.rest[v as usize]).collect()
    }

    /// f, frames × F strains (section 3) of frames × H handle positions in the order of [`Rig::labels`].
    pub fn strains(&self, handle_positions: &[[T; 3]]) -> Vec<T> {
        let frames = handle_positions.len().checked_div(self.handles.len()).unwrap_or(0);
        let handle_rest: Vec<[T; 3]> = self.handles.iter().map(|&v| self.rest[v as usize]).collect();
        let params = strain::Params {
            frames: frames as u32,
            handles: self.handles.len() as u32,
            strain_edges: self.strain_edges.len() as u32,
        };
        let mut features = vec![T::ZERO; frames * self.strain_edges.len()];
        strain::strain(
            params,
            handle_positions,
            &handle_rest,
            &self.strain_edges,
            &self.rest_lengths(),
            &mut features,
        );
        features
    }

    /// l: the F lengths of the strain edges at rest, in mesh units.
    pub fn rest_lengths(&self) -> Vec<T> {
        strain::rest_lengths(&self.rest, &self.handles, &self.strain_edges)
    }

    /// For each triangle the corner (index into [`Faces::indices`]) at which each of its vertices stands: what formats need that
    /// have triangles alone.
    ///
    /// # Errors
    /// [`Error::Internal`] if the triangles are not made from the faces, which [`Rig::check`] makes sure of.
    pub fn triangle_corners(&self) -> Result<Vec<[u32; 3]>> {
        let corners = self.faces.triangle_corners(&self.triangles);
        corners.ok_or_else(|| Error::Internal("the rig has other triangles than faces".into()))
    }

    /// The same rig in another precision; to `f32` it rounds to nearest.
    pub fn cast<U: Real>(&self) -> Rig<U> {
        let number = |x: &T| U::round_from(x.widen());
        let vector = |x: &[T; 3]| x.map(|c| U::round_from(c.widen()));
        Rig {
            name: self.name.clone(),
            metres_per_unit: self.metres_per_unit,
            up_axis: self.up_axis,
            labels: self.labels.clone(),
            example_names: self.example_names.clone(),
            faces: self.faces.clone(),
            uvs: self.uvs.clone(),
            materials: self.materials.clone(),
            bending_length: self.bending_length,
            beta: self.beta,
            handles: self.handles.clone(),
            triangles: self.triangles.clone(),
            rest: self.rest.iter().map(vector).collect(),
            basis: self.basis.par_iter().map(number).collect(),
            strain_edges: self.strain_edges.clone(),
            influence_edges: self.influence_edges.clone(),
            influence_weights: self.influence_weights.iter().map(number).collect(),
            tangent_neighbors: self.tangent_neighbors.clone(),
            pose_features: self.pose_features.iter().map(number).collect(),
            rbf_weights: self.rbf_weights.iter().map(vector).collect(),
            example_handles: self.example_handles.iter().map(vector).collect(),
            rotations: self.rotations,
            learned: self.learned.as_ref().map(Learned::cast),
        }
    }
}
