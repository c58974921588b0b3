//! Meshes in: OBJ, PLY and glTF, told apart by their file names. See docs/meshes.md.
//!
//! Polygons, vertex order, texture coordinates and the names of materials are kept as the file has them. No reader panics on any
//! bytes, and none allocates more than a small multiple of them.

mod check;
mod gltf;
mod like;
mod materials;
mod obj;
mod ply;
mod write_obj;

pub use check::check;
pub use like::read_like;
pub use write_obj::write_obj;

use rhytid_core::{Error, Mesh, Result, Uvs};
use std::path::Path;

/// The formats that [`read`] knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// PLY: ASCII, binary little endian or binary big endian.
    Ply,
    /// glTF 2.0: GLB or JSON, told apart by their first bytes.
    Gltf,
}

impl Format {
    /// The format that the extension of `path` stands for, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::Input`] lists the known extensions.
    pub fn of(path: &Path) -> Result<Self> {
        let extension =
            path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "glb" | "gltf" => Ok(Self::Gltf),
            _ => Err(Error::input(format!(
                "{}: a mesh's file name must end in .obj, .ply, .glb or .gltf, found {}; export the mesh in \
                 one of these formats",
                path.display(),
                if extension.is_empty() { "no extension".into() } else { format!(".{extension}") }
            ))),
        }
    }
}

/// Reads a mesh; polygons, vertex order and texture coordinates are kept.
///
/// # Errors
/// [`Error::Input`] if the extension is unknown or the file is not a valid mesh (see [`check`]); [`Error::Io`].
pub fn read(path: &Path) -> Result<Mesh> {
    let format = Format::of(path)?;
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    let name = path.display().to_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    decode_with(&bytes, format, &name, &|uri| gltf::read_beside(folder, uri, &name))
}

/// Reads a mesh from memory. `name` stands for the file in messages. A glTF document that keeps its numbers in
/// other files cannot be read this way.
///
/// # Errors
/// [`Error::Input`] if the bytes are not a valid mesh (see [`check`]).
pub fn decode(bytes: &[u8], format: Format, name: &str) -> Result<Mesh> {
    decode_with(bytes, format, name, &|uri| {
        Err(Error::input(format!(
            "{name}: keeps its numbers in the file {uri:?}, which cannot be reached from here; save it as GLB"
        )))
    })
}

/// `external` fetches what a glTF document refers to.
fn decode_with(bytes: &[u8], format: Format, name: &str, external: gltf::External<'_>) -> Result<Mesh> {
    let mesh = match format {
        Format::Obj => obj::decode(bytes, name),
        Format::Ply => ply::decode(bytes, name),
        Format::Gltf => gltf::decode(bytes, name, external),
    }?;
    check(&mesh, name)?;
    Ok(mesh)
}

/// `values` with one entry per corner in `corners`, in the simplest form: without `corners` where they say
/// nothing that the faces' `indices` do not say already.
fn uvs_from_corners(values: Vec<[f32; 2]>, corners: Vec<u32>, vertices: usize, indices: &[u32]) -> Uvs {
    let per_vertex = values.len() == vertices && corners == indices;
    Uvs { values, corners: (!per_vertex).then_some(corners) }
}

/// Says once that texture coordinates which only some corners have are dropped.
fn warn_partial_uvs(name: &str, without: usize, corners: usize) {
    log::warn!(
        "{name}: {without} of {corners} face corners have no texture coordinates; those of the others are \
         dropped, since they are kept only where every corner has them"
    );
}
