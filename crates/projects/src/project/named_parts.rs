//! Materials of a neutral that names none: its objects or groups whose names say what they are.

use rhytid_core::{Material, Materials, Mesh, Result, Tissue};
use rhytid_meshes::{self as mesh, Format, MeshPart};
use std::path::Path;

/// The vertices of an object or a group.
struct Part {
    name: String,
    /// V.
    has: Vec<bool>,
}

/// A material for each object or group whose name tells that it is not skin, such as `Teeth`, and that is not
/// connected with the rest. All other faces have none. `None` if there is no such part. `parts` are those
/// that the file at `path` has as glTF and USD have them; the groups of an OBJ are read here.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the groups cannot be read; [`rhytid_core::Error::Io`].
pub(super) fn materials(neutral: &Mesh, path: &Path, parts: &[MeshPart]) -> Result<Option<Materials>> {
    let mut found: Vec<Part> = Vec::new();
    let mut add = |name: &str, vertices: &mut dyn Iterator<Item = u32>| {
        if Tissue::of_name(name).is_none_or(|tissue| tissue == Tissue::Skin) {
            return;
        }
        let place = found.iter().position(|part| part.name == name);
        let place = place.unwrap_or_else(|| {
            found.push(Part { name: name.to_owned(), has: vec![false; neutral.positions.len()] });
            found.len() - 1
        });
        vertices.for_each(|v| found[place].has[v as usize] = true);
    };
    for part in parts {
        add(&part.name, &mut part.vertices.clone());
    }
    if matches!(Format::from_extension(path), Ok(Format::Obj)) {
        for (name, vertices) in mesh::groups_of(neutral, path)? {
            add(&name, &mut vertices.into_iter());
        }
    }
    // A group may also be a region of the skin, such as the mouth's.
    let is_whole = |part: &Part| {
        neutral.faces.iter().all(|face| {
            let inside = face.iter().filter(|v| part.has[**v as usize]).count();
            inside == 0 || inside == face.len()
        })
    };
    found.retain(is_whole);
    if found.is_empty() {
        return Ok(None);
    }
    let mut materials = Materials::default();
    for face in neutral.faces.iter() {
        let part = found.iter().find(|part| face.iter().all(|&v| part.has[v as usize]));
        let Some(part) = part else {
            materials.of_face.push(Materials::NONE);
            continue;
        };
        let place = materials.names().position(|name| name == part.name);
        materials.of_face.push(place.unwrap_or(materials.list.len()) as u32);
        if place.is_none() {
            materials.list.push(Material::new(&part.name));
        }
    }
    Ok((!materials.list.is_empty()).then_some(materials))
}
