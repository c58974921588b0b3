//! The shapes that a file has beside its mesh, as of expressions.

use super::read::{Format, Selection, read_file};
use rhytid_core::{Error, Mesh, Result, UpAxis};
use std::ops::Range;
use std::path::Path;

/// A mesh and its shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct Shapes {
    /// The mesh without any shape.
    pub neutral: Mesh,
    /// In the order of the file.
    pub shapes: Vec<Shape>,
    /// The objects of the file that have a name, in their order. A file of one object has none.
    pub parts: Vec<MeshPart>,
    /// The space of all coordinates, as far as the file states it.
    pub space: Space,
}

/// An object of a file, such as a node of glTF or a prim of USD.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshPart {
    /// Its name in the file.
    pub name: String,
    /// Its vertices.
    pub vertices: Range<u32>,
}

/// The space of a file's coordinates. OBJ and PLY state none. glTF is in metres with y up. A USD file may
/// state both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Space {
    /// The length of one unit in metres, above 0.
    pub metres_per_unit: Option<f64>,
    /// The axis that points up.
    pub up: Option<UpAxis>,
}

/// What a shape does to a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its name, or `shape` and its number from 1 on where the file has none. No two shapes have the same.
    pub name: String,
    /// Vertices of the mesh and their displacements in mesh units. Each vertex is there at most once.
    pub moved: Vec<(u32, [f64; 3])>,
}

impl Shape {
    /// The V positions of a mesh in this shape.
    ///
    /// ```
    /// # use rhytid_meshes::Shape;
    /// let smile = Shape { name: "smile".into(), moved: vec![(1, [0.0, 0.5, 0.0])] };
    /// let moved = smile.on(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    /// assert_eq!(moved, [[0.0; 3], [1.0, 0.5, 0.0]]);
    /// ```
    pub fn on(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut positions = positions.to_vec();
        for (v, by) in &self.moved {
            positions[*v as usize].iter_mut().zip(by).for_each(|(x, by)| *x += by);
        }
        positions
    }
}

/// Whether a file with this name may have shapes, by its extension.
pub fn has_shapes(path: &Path) -> bool {
    matches!(Format::from_extension(path), Ok(Format::Gltf | Format::Usd))
}

/// Reads a mesh with its shapes: the morph targets of a glTF file, the blend shapes of a USD file.
///
/// Shapes of several meshes that have the same name are one shape: an expression moves the teeth too.
///
/// # Errors
/// As [`super::read()`]. [`Error::Input`] where the format has no shapes.
pub fn read_shapes(path: &Path) -> Result<Shapes> {
    if !has_shapes(path) {
        Format::from_extension(path)?;
        return Err(Error::unsupported_format(format!(
            "{}: a file of this format has one mesh and no shapes beside it; give a glTF file (.glb) with morph \
             targets or a USD file with blend shapes",
            path.display()
        )));
    }
    read_file(path, &Selection::default(), true)
}
