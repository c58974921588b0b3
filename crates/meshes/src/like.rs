//! Meshes that have to be like another one.

use super::by_corners::{self, moved};
use super::read::{Format, read};
use rhytid_core::{Error, Faces, Mesh, Result};
use std::path::Path;

/// Reads the positions of an example, V of them in the neutral's vertex order. The example is a mesh with the
/// vertices of `neutral`, which was read from `neutral_path`. It has the same faces, in any order and cut
/// into triangles or not. Its texture coordinates do not matter.
///
/// glTF splits vertices where normals or texture coordinates differ. If one of the files is glTF, the example
/// may be split in another way, if its faces have the same corners in the same order.
///
/// # Errors
/// As [`super::read()`], and [`Error::Input`] if the number of vertices differs or a face joins others.
pub fn read_like(neutral: &Mesh, neutral_path: &Path, path: &Path) -> Result<Vec<[f64; 3]>> {
    let mesh = read(path)?;
    let order = order(&mesh, neutral, neutral_path, path)?;
    Ok(order.of_neutral(mesh.positions, &neutral.positions))
}

/// Which vertex of a mesh is which of the neutral's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order {
    /// For each vertex of the neutral, the vertex of the mesh, or `None` for a vertex in no face. `None` if
    /// the mesh has the neutral's order.
    vertices: Option<Vec<Option<u32>>>,
}

impl Order {
    /// Positions of the mesh's vertices in the neutral's order. A vertex in no face is where `neutral` has
    /// it.
    pub fn of_neutral(&self, positions: Vec<[f64; 3]>, neutral: &[[f64; 3]]) -> Vec<[f64; 3]> {
        match &self.vertices {
            Some(vertices) => moved(neutral, vertices, &positions),
            None => positions,
        }
    }
}

/// Which vertices of `mesh`, which was read from `path`, are those of the neutral as in [`read_like`].
///
/// # Errors
/// [`Error::Input`] if the number of vertices differs or a face joins others.
pub fn order(mesh: &Mesh, neutral: &Mesh, neutral_path: &Path, path: &Path) -> Result<Order> {
    let is_gltf = |path: &Path| matches!(Format::from_extension(path), Ok(Format::Gltf));
    let may_be_split = is_gltf(path) || is_gltf(neutral_path);
    match check_like(mesh, neutral, neutral_path, path, may_be_split) {
        Ok(()) => Ok(Order { vertices: None }),
        Err(error) if may_be_split => match by_corners::vertices(mesh, neutral) {
            Some(vertices) => Ok(Order { vertices: Some(vertices) }),
            None => Err(error),
        },
        Err(error) => Err(error),
    }
}

/// `mesh`, which was read from `path`, if it has the vertices and faces of the neutral in the same order.
///
/// # Errors
/// [`Error::Input`] if the number of vertices differs or a face joins others.
pub fn like(mesh: Mesh, neutral: &Mesh, neutral_path: &Path, path: &Path) -> Result<Mesh> {
    check_like(&mesh, neutral, neutral_path, path, false)?;
    Ok(mesh)
}

fn check_like(mesh: &Mesh, neutral: &Mesh, neutral_path: &Path, path: &Path, is_gltf: bool) -> Result<()> {
    let (path, like) = (path.display(), neutral_path.display());
    let cure = match is_gltf {
        true => {
            "an example needs the neutral's faces in the same order: export both from the same mesh with the same \
             shading and texture coordinates, or as OBJ with the option \"keep vertex order\""
        }
        false => {
            "an example needs the neutral's vertices in the same order: export both from the same mesh, without \
             merging, splitting or reordering vertices"
        }
    };
    let (found, expected) = (mesh.positions.len(), neutral.positions.len());
    if found != expected {
        return Err(Error::mismatch(format!(
            "{path}: has {found} vertices, but {like} has {expected}; {cure}"
        )));
    }
    if mesh.faces == neutral.faces {
        return Ok(());
    }
    if let Some(f) = not_within(&mesh.faces, &neutral.faces, expected)
        && let Some(g) = not_within(&neutral.faces, &mesh.faces, expected)
    {
        let face = |faces: &Faces, f: usize| list(faces.iter().nth(f).unwrap_or_default());
        return Err(Error::mismatch(format!(
            "{path}: face {} joins the vertices {}, which no face of {like} has together; in {like}, face {} \
             joins {} (vertices counted from 0): {cure}",
            f + 1,
            face(&mesh.faces, f),
            g + 1,
            face(&neutral.faces, g)
        )));
    }
    Ok(())
}

/// The first of `faces` whose vertices are not all in one of `others`.
fn not_within(faces: &Faces, others: &Faces, vertices: usize) -> Option<usize> {
    let mut at: Vec<Vec<u32>> = vec![Vec::new(); vertices];
    let mut sorted = Vec::with_capacity(others.len());
    for (f, other) in others.iter().enumerate() {
        let mut other = other.to_vec();
        other.sort_unstable();
        other.iter().for_each(|&v| at[v as usize].push(f as u32));
        sorted.push(other);
    }
    let is_within = |face: &[u32]| {
        let others = face.first().map_or(&[][..], |&v| &at[v as usize]);
        others.iter().any(|&f| face.iter().all(|v| sorted[f as usize].binary_search(v).is_ok()))
    };
    faces.iter().position(|face| !is_within(face))
}

/// A face's vertices for a message; a monstrous polygon is cut.
fn list(face: &[u32]) -> String {
    const SHOWN: usize = 16;
    let shown: Vec<String> = face.iter().take(SHOWN).map(u32::to_string).collect();
    let rest = if face.len() > SHOWN { format!(" … ({} in all)", face.len()) } else { String::new() };
    format!("{}{rest}", shown.join(" "))
}
