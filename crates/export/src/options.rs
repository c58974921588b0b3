//! The choices that only some formats have.

use crate::{PrimPath, ShapeSet};

/// The choices of those formats that have any. All others ignore them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// glTF: the largest deviation in mesh units, for which as few morph targets as possible are found.
    /// `None` writes a target for each frame.
    pub max_error: Option<f64>,
    /// glTF and USD: the number of morph targets (blend shapes), at least 1; not together with `max_error`.
    /// Fewer are written if all frames need fewer. The deviation of the frames has no bound;
    /// [`super::Written::errors`] and the file state it.
    pub shapes: Option<usize>,
    /// glTF and USD: shapes that are there already; not together with `max_error` or `shapes`. Only their
    /// weights are found, each from 0 to 1. [`super::Written::errors`] and the file state the deviation.
    pub onto: Option<ShapeSet>,
    /// glTF: integers of 8 and 16 bits (KHR_mesh_quantization).
    pub quantize: bool,
    /// glTF: compressed buffers (EXT_meshopt_compression).
    pub meshopt: bool,
    /// glTF: the largest number of morph targets, at least 1; `None` for 256.
    pub most_targets: Option<usize>,
    /// glTF: allows more than 1 GiB, and more than 256 targets unless `most_targets` is given.
    pub force: bool,
    /// glTF: the attribute `_VERTEX_ID`, each vertex's number in the neutral.
    pub vertex_ids: bool,
    /// glTF: one primitive with one material, instead of one for each material.
    pub one_material: bool,
    /// The names of the clips, such as those of the takes. A clip without one has the mesh's name.
    pub clips: Vec<String>,
    /// What becomes of the textures of materials; `None` for what suits the format: [`TextureFiles::Embed`]
    /// in `.glb` and `.usdz`, else [`TextureFiles::Copy`].
    pub textures: Option<TextureFiles>,
    /// USD: the prim that has the face; `None` for one at the root with the mesh's name.
    pub prim_path: Option<PrimPath>,
    /// USD: the name of the mesh's prim below it, which has to be one that prims may have; `None` for that of
    /// the prim above with `_mesh`.
    pub mesh_name: Option<String>,
    /// USD: the samples alone, as a layer that goes over another with the mesh; not together with `shapes`.
    pub over: bool,
    /// USD: the metre as the unit of the layer, with a transform that scales the mesh to it. It is for
    /// programs that do not read units.
    pub metres: bool,
    /// USD: how programs are to subdivide the mesh.
    pub subdivision: Subdivision,
}

/// How programs subdivide a mesh of USD before they show it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Subdivision {
    /// Not at all: the vertices are shown where they are.
    #[default]
    None,
    /// After Catmull and Clark. The surface is smooth, and its points are near the vertices and not at them.
    CatmullClark,
}

/// What becomes of the textures of materials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextureFiles {
    /// Copies beside the file, with the hash of their content in their names; not in `.usdz`.
    Copy,
    /// Inside the file. Of USD's files, only `.usdz` has a place for them.
    Embed,
    /// The input's own files, by the paths that the input names; not in `.usdz`. A texture without a file of
    /// its own is embedded, or copied in USD, with a warning.
    Refer,
    /// No textures.
    None,
}
