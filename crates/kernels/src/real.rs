//! Numbers that the references are evaluated in.
use crate::Number;
use std::fmt::{Debug, Display};

/// A floating-point type that the references can be evaluated in: `f32` or `f64`.
pub trait Real:
    Number
    + PartialOrd
    + bytemuck::Pod
    + std::ops::AddAssign
    + std::iter::Sum
    + Debug
    + Display
    + Default
    + Send
    + Sync
    + 'static
{
    /// 0.
    const ZERO: Self;

    /// Rounds to the nearest value of this type.
    fn round_from(value: f64) -> Self;
    /// Exact for both types.
    fn widen(self) -> f64;
}

impl Real for f32 {
    const ZERO: Self = 0.0;

    fn round_from(value: f64) -> Self {
        value as f32
    }
    fn widen(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;

    fn round_from(value: f64) -> Self {
        value
    }
    fn widen(self) -> f64 {
        self
    }
}
