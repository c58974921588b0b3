//! Small rigs, and rigs with one change.
use rhytid_core::{
    Examples, Faces, FineScale, HandleSet, Influences, Result, Rig, RigParts, Surface, Table, UpAxis,
    VertexId,
};
use rhytid_kernels::Real;

/// The rig with its parts changed.
///
/// # Errors
/// As [`Rig::new`].
pub fn changed<T: Real>(rig: &Rig<T>, change: impl FnOnce(&mut RigParts<T>)) -> Result<Rig<T>> {
    let mut parts = rig.clone().into_parts();
    change(&mut parts);
    Rig::new(parts)
}

/// A triangle. Its first vertex is a handle, the second follows it half the way, and the third stays.
pub fn triangle() -> Rig {
    let rest = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let parts = RigParts {
        handles: HandleSet {
            labels: vec!["corner".into()],
            points: vec![VertexId(0).into()],
            rest: vec![rest[0]],
            strain_edges: Vec::new(),
            rotations: false,
        },
        surface: Surface {
            name: "triangle".into(),
            metres_per_unit: 0.01,
            up_axis: UpAxis::Y,
            faces: Faces { counts: vec![3], indices: vec![0, 1, 2] },
            uvs: None,
            materials: None,
            triangles: vec![[0, 1, 2]],
            rest,
            tangent_neighbors: [1, 2, 0].map(VertexId).to_vec(),
            joined: None,
        },
        examples: Examples { names: Vec::new(), handles: Table::filled(0, 1, [0.0; 3]) },
        bending_length: 1.0,
        basis: Table::new(3, 1, vec![1.0, 0.5, 0.0]),
        influences: Influences {
            edges: Table::without_columns(3),
            weights: Table::without_columns(3),
            beta: 0.0,
        },
        fine_scale: FineScale {
            pose_features: Table::without_columns(1),
            rbf_weights: Table::filled(3, 1, [0.0; 3]),
        },
        learned: None,
    };
    Rig::new(parts).expect("a sound rig")
}
