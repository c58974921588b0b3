//! The choices of some formats.

/// The choices of those formats that have any. All others ignore them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// glTF: as few morph targets as the largest deviation that this allows, in mesh units. `None` writes a target
    /// for each frame.
    pub max_error: Option<f64>,
    /// glTF and USD: so many morph targets (blend shapes), or as few as all frames need, however far the frames are from them; how far is in [`super::Written::error`]
    /// and in the file. At least 1; instead of `max_error`.
    pub shapes: Option<usize>,
    /// glTF: integers of 8 and 16 bits (KHR_mesh_quantization).
    pub quantize: bool,
    /// glTF: compressed buffers (EXT_meshopt_compression).
    pub meshopt: bool,
    /// glTF: also more than 256 targets or 1 GiB.
    pub force: bool,
}
