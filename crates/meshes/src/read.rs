//! A mesh from a file of any format.

use super::check::check;
use super::shapes::Shapes;
use super::{gltf, obj, ply};
use rhytid_core::{Error, Mesh, Result, input_file};
use std::path::Path;

/// The formats that [`read`] knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// PLY: ASCII, binary little endian or binary big endian.
    Ply,
    /// glTF 2.0: GLB (also named `.vrm`) or JSON, told apart by their first bytes.
    Gltf,
}

impl Format {
    /// The format that the extension of `path` stands for, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::Input`] lists the known extensions.
    pub fn from_extension(path: &Path) -> Result<Self> {
        let extension =
            path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "glb" | "gltf" | "vrm" => Ok(Self::Gltf),
            _ => Err(Error::unsupported_format(format!(
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
/// [`Error::Input`] if the extension is unknown or the file is not a valid mesh (see [`check`]);
/// [`Error::Io`].
pub fn read(path: &Path) -> Result<Mesh> {
    let format = Format::from_extension(path)?;
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    let name = path.display().to_string();
    let folder = path.parent().unwrap_or(Path::new(""));
    decode_with(&bytes, format, &name, &|uri| gltf::read_beside(folder, uri, &name))
}

/// Reads a mesh from memory. `name` stands for the file in messages. A glTF document that keeps its numbers
/// in other files cannot be read this way.
///
/// # Errors
/// [`Error::Input`] if the bytes are not a valid mesh (see [`check`]).
pub fn decode(bytes: &[u8], format: Format, name: &str) -> Result<Mesh> {
    decode_with(bytes, format, name, &|uri| {
        Err(Error::unsupported_format(format!(
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

/// As [`decode_with`], for a glTF file with its shapes.
pub(super) fn decode_shapes_with(bytes: &[u8], name: &str, external: gltf::External<'_>) -> Result<Shapes> {
    let shapes = gltf::decode_shapes(bytes, name, external)?;
    check(&shapes.neutral, name)?;
    for shape in &shapes.shapes {
        if let Some((v, _)) = shape.moved.iter().find(|(_, by)| by.iter().any(|x| !x.is_finite())) {
            return Err(Error::malformed(format!(
                "{name}: the shape {:?} moves vertex {v} by what is not a number; export the mesh again",
                shape.name
            )));
        }
    }
    Ok(shapes)
}
