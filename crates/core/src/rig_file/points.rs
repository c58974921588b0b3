//! The file with where a level of detail has each vertex of the whole rig.
use super::{Tensor, safetensors_file};
use crate::{Error, Result, SurfacePoint, VertexId};

/// The bytes of a safetensors file with points of a level's surface, one for each vertex of the whole rig.
/// It has two arrays of three columns: `vertices`, those of the level, and their `weights`, whose sum is 1.
///
/// # Errors
/// [`Error::Internal`] if the libraries that write it fail.
pub fn encode_points(points: &[SurfacePoint]) -> Result<Vec<u8>> {
    let corners: Vec<VertexId> = points.iter().flat_map(SurfacePoint::triangle).collect();
    let weights: Vec<f32> = points.iter().flat_map(|point| point.weights().map(|w| w as f32)).collect();
    let tensors = [
        Tensor::u32s("vertices", VertexId::numbers(&corners), vec![points.len(), 3]),
        Tensor::f32s("weights", &weights, vec![points.len(), 3]),
    ];
    safetensors_file(tensors.iter().map(Tensor::view), None)
        .map_err(|e| Error::Internal(format!("the points cannot be written: {e}")))
}
