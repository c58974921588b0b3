//! A mesh from a file of any format.

use super::check::check;
use super::shapes::{Shapes, Space};
use super::{gltf, obj, ply, recognise, usd};
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
    /// USD: text, binary or a package, told apart by their first bytes.
    Usd,
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
            "usd" | "usda" | "usdc" | "usdz" => Ok(Self::Usd),
            other if let Some(said) = recognise::of_extension(other) => {
                Err(Error::unsupported_format(format!("{}: {said}", path.display())))
            }
            _ => Err(Error::unsupported_format(format!(
                "{}: a mesh's file name must end in .obj, .ply, .glb, .gltf or .usd, found {}; export the mesh in \
                 one of these formats",
                path.display(),
                if extension.is_empty() { "no extension".into() } else { format!(".{extension}") }
            ))),
        }
    }
}

/// What of a file is meant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Selection {
    /// The path of a prim: of a USD file, the meshes at this prim and below it. `None`: all that are shown.
    pub prim: Option<String>,
    /// A time code: of a USD file, the pose at this time. `None`: the pose without a time, else the first.
    pub time: Option<f64>,
}

impl Selection {
    /// Checks that a file of this format can have what is meant.
    fn check(&self, format: Format, name: &str) -> Result<()> {
        if format == Format::Usd || *self == Self::default() {
            return Ok(());
        }
        let what = if self.prim.is_some() { "prim" } else { "time" };
        Err(Error::conflict(format!(
            "{name}: a {what} is given, which only USD files have; leave it out, or export the mesh as USD"
        )))
    }
}

/// Reads a mesh; polygons, vertex order and texture coordinates are kept.
///
/// # Errors
/// [`Error::Input`] if the extension is unknown or the file is not a valid mesh (see [`check`]);
/// [`Error::Io`].
pub fn read(path: &Path) -> Result<Mesh> {
    Ok(read_file(path, &Selection::default(), false)?.neutral)
}

/// Reads what is meant of a file, with the space that the file states. Shapes are read if `with_shapes`.
///
/// # Errors
/// As [`read()`]. [`Error::Input`] if the file has no such prim or time.
pub fn read_file(path: &Path, selection: &Selection, with_shapes: bool) -> Result<Shapes> {
    let format = Format::from_extension(path)?;
    let name = path.display().to_string();
    selection.check(format, &name)?;
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let from = Source {
        name: &name,
        selection,
        with_shapes,
        external: &|uri| gltf::read_beside(folder, uri, &name),
    };
    from.decode(bytes, format)
}

/// Reads a mesh from memory. `name` stands for the file in messages. A glTF document that keeps its numbers
/// in other files cannot be read this way.
///
/// # Errors
/// [`Error::Input`] if the bytes are not a valid mesh (see [`check`]).
pub fn decode(bytes: &[u8], format: Format, name: &str) -> Result<Mesh> {
    let external: gltf::External<'_> = &|uri| {
        Err(Error::unsupported_format(format!(
            "{name}: keeps its numbers in the file {uri:?}, which cannot be reached from here; save it as GLB"
        )))
    };
    let from = Source { name, selection: &Selection::default(), with_shapes: false, external };
    Ok(from.decode(bytes.to_vec(), format)?.neutral)
}

/// Where bytes come from, and what of them is wanted.
struct Source<'a> {
    name: &'a str,
    selection: &'a Selection,
    with_shapes: bool,
    /// Fetches what a glTF document refers to.
    external: gltf::External<'a>,
}

impl Source<'_> {
    fn decode(&self, bytes: Vec<u8>, format: Format) -> Result<Shapes> {
        let name = self.name;
        recognise::expect(format, &bytes, name)?;
        let alone =
            |neutral| Shapes { neutral, shapes: Vec::new(), parts: Vec::new(), space: Space::default() };
        let mut read = match format {
            Format::Obj => obj::decode(&bytes, name).map(alone),
            Format::Ply => ply::decode(&bytes, name).map(alone),
            Format::Gltf => gltf::decode(&bytes, name, self.external, self.with_shapes),
            Format::Usd => usd::read(bytes, name, self.selection),
        }?;
        check(&read.neutral, name)?;
        if !self.with_shapes {
            read.shapes.clear();
        }
        for shape in &read.shapes {
            if let Some((v, _)) = shape.moved.iter().find(|(_, by)| by.iter().any(|x| !x.is_finite())) {
                return Err(Error::malformed(format!(
                    "{name}: the shape {:?} moves vertex {v} by what is not a number; export the mesh again",
                    shape.name
                )));
            }
        }
        Ok(read)
    }
}
