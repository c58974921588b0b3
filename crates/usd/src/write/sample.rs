//! Values that change over time.

/// The value of an attribute at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sample<'a> {
    /// `float3[]` and its roles, such as `point3f[]`
    Float3s(&'a [[f32; 3]]),
    /// `float2[]` and its roles
    Float2s(&'a [[f32; 2]]),
    /// `float[]`
    Floats(&'a [f32]),
    /// `matrix4d`, row by row as [`crate::layer::Value::Matrix4d`]
    Matrix4d(&'a [[f64; 4]; 4]),
}
