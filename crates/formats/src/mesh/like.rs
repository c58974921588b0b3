//! Meshes that have to be like another one.

use super::read::read;
use rhytid_core::{Error, Mesh, Result};
use std::path::Path;

/// Reads the positions of an example: a mesh with the same vertices and faces as `neutral`, which was read from
/// `neutral_path`. Its texture coordinates do not matter. Gives V positions in the neutral's vertex order.
///
/// # Errors
/// As [`super::read()`], and [`Error::Input`] if the number of vertices or a face differs.
pub fn read_like(neutral: &Mesh, neutral_path: &Path, path: &Path) -> Result<Vec<[f64; 3]>> {
    let mesh = read(path)?;
    let (path, like) = (path.display(), neutral_path.display());
    let cure = "an example needs the neutral's vertices and faces in the same order: export both from the same \
                mesh, without merging, splitting or reordering";
    let (found, expected) = (mesh.positions.len(), neutral.positions.len());
    if found != expected {
        return Err(Error::input(format!("{path}: has {found} vertices, but {like} has {expected}; {cure}")));
    }
    if let Some((f, (a, b))) =
        mesh.faces.iter().zip(neutral.faces.iter()).enumerate().find(|(_, (a, b))| a != b)
    {
        return Err(Error::input(format!(
            "{path}: face {} joins the vertices {}, but in {like} it joins {} (vertices counted from 0); {cure}",
            f + 1,
            list(a),
            list(b)
        )));
    }
    let (found, expected) = (mesh.faces.len(), neutral.faces.len());
    if found != expected {
        return Err(Error::input(format!(
            "{path}: has {found} faces, but {like} has {expected}, the first {} being the same; {cure}",
            found.min(expected)
        )));
    }
    Ok(mesh.positions)
}

/// A face's vertices for a message; a monstrous polygon is cut.
fn list(face: &[u32]) -> String {
    const SHOWN: usize = 16;
    let shown: Vec<String> = face.iter().take(SHOWN).map(u32::to_string).collect();
    let rest = if face.len() > SHOWN { format!(" … ({} in all)", face.len()) } else { String::new() };
    format!("{}{rest}", shown.join(" "))
}
