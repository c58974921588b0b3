//! The transform of a node.

use ::gltf::json::scene::Node;
use glam::{DMat4, DQuat, DVec3};

/// A node's transform to its parent's space, for column vectors: its matrix, else scale, then rotation, then
/// translation.
pub fn local_transform(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, default| v.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    // A quaternion of 32-bit floats has length 1 only to their precision.
    let rotation =
        node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)).normalize());
    DMat4::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
