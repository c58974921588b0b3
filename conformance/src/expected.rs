//! The expected value of one number of a device.

/// A number's correct value and its bound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Expected {
    /// The value.
    pub value: f64,
    /// The largest difference allowed from it.
    pub bound: f64,
}
