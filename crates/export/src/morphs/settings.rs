//! The goal of a compression.

/// The goal of a compression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The furthest any vertex may be from its place in any frame, in mesh units; positive and finite.
    pub max_error: f64,
    /// More targets than this are refused; `usize::MAX` for no limit.
    pub most_targets: usize,
    /// Whether positions are stored as small integers (`KHR_mesh_quantization`).
    pub quantize: bool,
}
