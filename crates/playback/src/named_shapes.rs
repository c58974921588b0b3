//! Shapes with names, as displacements of a rig's handles.

use crate::shape_space::{OnMesh, ShapeSpace, difference, rest};
use rhytid_core::{Error, Mesh, Reach, Result, Rig, SurfacePoint, rig_file};
use rhytid_formats::mesh::{self, Selection, Shapes, Space};
use rhytid_formats::{FileKind, project};
use std::path::{Path, PathBuf};

/// Displacements that shapes of these names give to a rig's handles.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct NamedShapes {
    /// Where they are from, for messages.
    pub of: String,
    /// N names.
    pub names: Vec<String>,
    /// N × H displacements in the rig's unit and axes.
    pub at_handles: Vec<Vec<[f64; 3]>>,
}

/// The rig's own examples; `None` if it has none.
pub(crate) fn of_examples(rig: &Rig) -> Option<NamedShapes> {
    let examples = rig.examples();
    if examples.is_empty() {
        return None;
    }
    let rest = &rig.handles().rest;
    let of_example = |row: &[[f32; 3]]| {
        row.iter().zip(rest).map(|(at, rest)| difference(at.map(f64::from), rest.map(f64::from))).collect()
    };
    let rows = examples.handles.as_slice().chunks_exact(rest.len());
    Some(NamedShapes {
        of: "the rig".into(),
        names: examples.names.clone(),
        at_handles: rows.map(of_example).collect(),
    })
}

impl NamedShapes {
    /// Reads shapes of the rig's mesh. These are blend shapes of a glTF or USD file, or the examples of a
    /// project file or of a rig. They can also be all meshes of a folder, or those whose names fit a pattern
    /// such as `poses/*.obj`. Meshes are named after their files.
    ///
    /// # Errors
    /// [`Error::Input`] if there are no shapes, or if they are of another mesh or in another place.
    /// [`Error::Io`].
    pub(crate) fn read(path: &Path, rig: &Rig) -> Result<Self> {
        let name = path.display().to_string();
        let found = match FileKind::detect(path) {
            Some(FileKind::Rig) => of_rig(path, rig)?,
            Some(FileKind::Project) => of_project(path, rig)?,
            _ if mesh::has_shapes(path) && (path.is_file() || !name.contains(['*', '#'])) => {
                of_file(path, rig)?
            }
            _ => of_meshes(path, rig)?,
        };
        if found.names.is_empty() {
            return Err(Error::empty(format!(
                "{name}: has no shapes, expected a file with blend shapes, a folder of meshes, or a project file or \
                 rig with examples"
            )));
        }
        Ok(Self { of: name, ..found })
    }
}

/// All files that [`NamedShapes::read`] reads, in their order.
pub(crate) fn files(path: &Path) -> Result<Vec<PathBuf>> {
    match FileKind::detect(path) {
        Some(FileKind::Project) => Ok(project::files(&project::read_project(path)?, path)),
        Some(_) => Ok(vec![path.to_owned()]),
        None => Ok(meshes(path)),
    }
}

fn of_rig(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let other = rig_file::read(path)?;
    if other.handles().labels != rig.handles().labels {
        return Err(Error::mismatch(format!(
            "{}: has other handles than the rig that plays the curves; give a rig of the same handles, or the shapes \
             as meshes",
            path.display()
        )));
    }
    Ok(of_examples(&other).unwrap_or_default())
}

fn of_project(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let project = project::read_project(path)?;
    // The user names this file, as a mesh is named.
    let face = project::load_without_handles(&project, path, Reach::Anywhere)?;
    let space = Space { metres_per_unit: Some(face.metres_per_unit), up: Some(face.up_axis) };
    let handles = OnMesh::find(&face.neutral, space, rig, path)?;
    let mut found = NamedShapes::default();
    for example in face.examples {
        found.names.push(example.name);
        found.at_handles.push(handles.displacements(&example.positions, &face.neutral.positions));
    }
    Ok(found)
}

fn of_file(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let Shapes { neutral, shapes, space, .. } = mesh::read_file(path, &Selection::default(), true)?;
    let handles = OnMesh::find(&neutral, space, rig, path)?;
    let mut found = NamedShapes::default();
    for shape in shapes {
        let positions = shape.on(&neutral.positions);
        found.names.push(shape.name);
        found.at_handles.push(handles.displacements(&positions, &neutral.positions));
    }
    Ok(found)
}

/// A mesh for each shape. There may be no neutral among them, so each has the rig's vertices in their order.
fn of_meshes(path: &Path, rig: &Rig) -> Result<NamedShapes> {
    let rest = rest(rig);
    let faces = rig.surface().faces.clone();
    let of_rig = Mesh { positions: rest.clone(), faces, uvs: None, materials: None };
    let mut found = NamedShapes::default();
    for file in meshes(path) {
        let read = mesh::read_file(&file, &Selection::default(), false)?;
        // The rig's mesh has no path of its own here.
        let order = mesh::order(&read.neutral, &of_rig, Path::new("the rig's mesh"), &file)?;
        let space = ShapeSpace::by_size(&read.neutral.positions, read.space, rig, &file)?;
        let in_space = read.neutral.positions.into_iter().map(|x| space.to_rig(x)).collect();
        let positions = order.of_neutral(in_space, &rest);
        let displacement =
            |point: &SurfacePoint| point.mean(|v| difference(positions[v.index()], rest[v.index()]));
        found.names.push(file.file_stem().unwrap_or_default().to_string_lossy().into_owned());
        found.at_handles.push(rig.handles().points.iter().map(displacement).collect());
    }
    Ok(found)
}

/// The meshes of a folder or of a pattern, by name.
pub(crate) fn meshes(path: &Path) -> Vec<PathBuf> {
    let pattern = if path.is_dir() { path.join("*") } else { path.to_owned() };
    project::meshes_fitting(&pattern)
}
