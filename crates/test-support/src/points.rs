//! Handles inside triangles.
use rhytid_core::{Mesh, SurfacePoint, VertexId};

/// Points with these weights in a face at each of `points`: of the vertex itself, the next corner and the one
/// before.
///
/// # Panics
/// If a vertex has no face.
pub fn beside(mesh: &Mesh, points: &[SurfacePoint], weights: [f64; 3]) -> Vec<SurfacePoint> {
    let beside = |vertex: VertexId| {
        let around = mesh.faces.iter().find(|face| face.contains(&vertex.0)).expect("a face at each handle");
        let i = around.iter().position(|v| *v == vertex.0).expect("a corner of that face");
        let corners = [0, 1, around.len() - 1].map(|step| VertexId(around[(i + step) % around.len()]));
        SurfacePoint::new(corners, weights).expect("weights of a point")
    };
    points.iter().map(SurfacePoint::nearest_vertex).map(beside).collect()
}
