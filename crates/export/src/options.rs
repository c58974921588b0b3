//! The choices that only some formats have.

/// The choices of those formats that have any. All others ignore them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// glTF: the largest deviation in mesh units, for which as few morph targets as possible are found.
    /// `None` writes a target for each frame.
    pub max_error: Option<f64>,
    /// glTF and USD: the number of morph targets (blend shapes), at least 1; not together with `max_error`.
    /// Fewer are written if all frames need fewer. The deviation of the frames has no bound;
    /// [`super::Written::error`] and the file state it.
    pub shapes: Option<usize>,
    /// glTF: integers of 8 and 16 bits (KHR_mesh_quantization).
    pub quantize: bool,
    /// glTF: compressed buffers (EXT_meshopt_compression).
    pub meshopt: bool,
    /// glTF: allows more than 256 targets or 1 GiB.
    pub force: bool,
}
