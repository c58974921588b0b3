//! Groups of vertices, as DCC tools write them into OBJ files: `g NAME` before the faces of each.

use super::like::like;
use super::obj;
use super::read::{Format, decode};
use super::text;
use rhytid_core::{Error, InputErrorKind, Mesh, Result, input_file};
use std::collections::HashMap;
use std::path::Path;

/// The most groups that a face may be in, because each of its vertices is kept for each group.
const AT_ONCE: usize = 64;

/// Reads the groups of an OBJ file, in the order of their names. A group has the vertices of its faces,
/// ascending. The mesh in the file has to be like `neutral`, which was read from `neutral_path`. Faces before
/// the first `g` are in no group.
///
/// # Errors
/// As [`super::read_like`]; [`Error::Input`] if the file is no OBJ or has no group.
pub fn read_groups(neutral: &Mesh, neutral_path: &Path, path: &Path) -> Result<Vec<(String, Vec<u32>)>> {
    let fault = |what: &str| Error::malformed(format!("{}: {what}", path.display()));
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
        return Err(fault("groups are read from .obj; export the mesh with its groups in this format")
            .of_kind(InputErrorKind::UnsupportedFormat));
    }
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    let mesh = like(decode(&bytes, Format::Obj, &path.display().to_string())?, neutral, neutral_path, path)?;
    let groups = of_faces(&bytes, &mesh, path)?;
    match groups.is_empty() {
        true => Err(fault("has no group, expected “g NAME” before the faces of each region")
            .of_kind(InputErrorKind::Empty)),
        false => Ok(groups),
    }
}

/// Reads the groups of the OBJ file that `mesh` was read from, as [`read_groups`] does. None if it has none.
///
/// # Errors
/// [`Error::Input`] if a face is in too many groups; [`Error::Io`].
pub fn groups_of(mesh: &Mesh, path: &Path) -> Result<Vec<(String, Vec<u32>)>> {
    of_faces(&input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?, mesh, path)
}

/// The groups of an OBJ whose faces are those of `mesh`.
fn of_faces(bytes: &[u8], mesh: &Mesh, path: &Path) -> Result<Vec<(String, Vec<u32>)>> {
    let fault = |what: &str| Error::malformed(format!("{}: {what}", path.display()));
    let mut groups: Vec<(String, Vec<u32>)> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    // The groups of the next face, and the faces. Each face has a statement of its own.
    let (mut current, mut faces): (Vec<usize>, _) = (Vec::new(), mesh.faces.iter());
    for obj::Statement { text, .. } in obj::statements(bytes) {
        let mut words = obj::words(&text);
        match words.next() {
            Some(b"g") => {
                current.clear();
                for name in words.map(text::name).filter(|name| name != "default") {
                    let group = *known.entry(name).or_insert_with_key(|name| {
                        groups.push((name.clone(), Vec::new()));
                        groups.len() - 1
                    });
                    current.push(group);
                }
                if current.len() > AT_ONCE {
                    return Err(fault(&format!(
                        "puts faces into {} groups at once, expected at most {AT_ONCE}; split the line",
                        current.len()
                    )));
                }
            }
            _ if obj::is_face(&text) => {
                let face = faces.next().unwrap_or_default();
                current.iter().for_each(|&group| groups[group].1.extend(face));
            }
            _ => {}
        }
    }
    for (_, vertices) in &mut groups {
        vertices.sort_unstable();
        vertices.dedup();
    }
    groups.retain(|(_, vertices)| !vertices.is_empty());
    groups.sort();
    Ok(groups)
}
