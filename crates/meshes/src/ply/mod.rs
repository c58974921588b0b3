//! PLY: ASCII and both binary forms. The existing crates give no useful line or element numbers, and refuse
//! ASCII numbers such as `.5`, `1.` or `nan`. So this is a reader of its own.

mod header;
mod values;

use super::uvs::{uvs_from_corners, warn_partial_uvs};
use header::{Element, Header, Scalar};
use rhytid_core::{Error, Mesh, Result};
use values::Values;

pub(super) fn decode(bytes: &[u8], name: &str) -> Result<Mesh> {
    let header = Header::parse(bytes, name)?;
    let vertices = header.element("vertex");
    if vertices.is_none() || header.element("face").is_none() {
        return Err(Error::unsupported_format(match (vertices, header.element("tristrips")) {
            (Some(_), Some(_)) => format!(
                "{name}: stores its surface as triangle strips (the element tristrips), which are not \
                 supported; export it with faces"
            ),
            (Some(_), None) => format!(
                "{name}: has points but no element face, expected polygons; export the surface, not only its \
                 points"
            ),
            _ => format!("{name}: has no element vertex, expected vertices and faces; export the mesh again"),
        }));
    }
    let vertex_count = vertices.map_or(0, |e| e.count);
    if vertex_count > u64::from(u32::MAX) {
        return Err(Error::too_large(format!(
            "{name}: announces {vertex_count} vertices, expected at most {}; the header may be damaged",
            u32::MAX
        )));
    }
    let mut values = Values::new(bytes, &header, name);
    let mut mesh = Mesh::default();
    let mut vertex_uvs = None;
    let mut corner_uvs = None;
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => vertex_uvs = read_vertices(&mut values, element, &mut mesh)?,
            "face" => corner_uvs = read_faces(&mut values, element, vertex_count, &mut mesh)?,
            _ => skip(&mut values, element)?,
        }
    }
    mesh.uvs = corner_uvs
        .map(|uvs: Vec<[f32; 2]>| {
            // One entry per corner; there are no more corners than `indices` has entries.
            let corners = (0..uvs.len() as u32).collect();
            uvs_from_corners(uvs, corners, mesh.positions.len(), &mesh.faces.indices)
        })
        .or_else(|| vertex_uvs.map(|values| rhytid_core::Uvs { values, corners: None }));
    Ok(mesh)
}

/// Texture coordinates per vertex, if the vertices have any.
fn read_vertices(
    values: &mut Values<'_>,
    element: &Element,
    mesh: &mut Mesh,
) -> Result<Option<Vec<[f32; 2]>>> {
    let scalar = |wanted: &str| element.properties.iter().position(|p| p.name == wanted && p.list.is_none());
    let (Some(x), Some(y), Some(z)) = (scalar("x"), scalar("y"), scalar("z")) else {
        return values.fail("the element vertex lacks a property x, y or z; export the mesh again".into());
    };
    let uv = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]]
        .iter()
        .find_map(|[u, v]| scalar(u).zip(scalar(v)));
    let mut uvs = uv.map(|_| Vec::new());
    let mut row = vec![0.0; element.properties.len()];
    for i in 0..element.count {
        values.begin(element, i)?;
        for (property, value) in element.properties.iter().zip(&mut row) {
            match property.list {
                Some(count) => values.skip_list(count, property.scalar)?,
                None => *value = values.number(property.scalar)?,
            }
        }
        values.end()?;
        mesh.positions.push([row[x], row[y], row[z]]);
        if let (Some(uvs), Some((u, v))) = (&mut uvs, uv) {
            uvs.push([row[u] as f32, row[v] as f32]);
        }
    }
    Ok(uvs)
}

/// Texture coordinates per corner, if every face has them.
fn read_faces(
    values: &mut Values<'_>,
    element: &Element,
    vertices: u64,
    mesh: &mut Mesh,
) -> Result<Option<Vec<[f32; 2]>>> {
    let list = |wanted: &str| element.properties.iter().position(|p| p.name == wanted && p.list.is_some());
    let Some(indices) = list("vertex_indices").or_else(|| list("vertex_index")) else {
        return values.fail(
            "the element face lacks the list vertex_indices (or vertex_index); export the mesh again".into(),
        );
    };
    let texcoord = list("texcoord");
    let mut uvs: Vec<[f32; 2]> = Vec::new();
    let mut corners_without = 0;
    let (mut face, mut uv) = (Vec::new(), Vec::new());
    for i in 0..element.count {
        values.begin(element, i)?;
        uv.clear();
        for (p, property) in element.properties.iter().enumerate() {
            match property.list {
                Some(count) if p == indices => values.list(count, property.scalar, &mut face)?,
                Some(count) if Some(p) == texcoord => values.list(count, property.scalar, &mut uv)?,
                Some(count) => values.skip_list(count, property.scalar)?,
                None => {
                    values.number(property.scalar)?;
                }
            }
        }
        values.end()?;
        if face.len() < 3 {
            return values.fail(format!(
                "{} has {} corners, expected at least 3",
                values.place(),
                face.len()
            ));
        }
        for &index in &face {
            // Both bounds also refuse NaN; the cast below is exact.
            if !(index >= 0.0 && index < vertices as f64 && index.fract() == 0.0) {
                return values.fail(format!(
                    "{} has the vertex index {index}, expected a whole number from 0 to {}; the file may be \
                     damaged",
                    values.place(),
                    vertices.saturating_sub(1)
                ));
            }
            mesh.faces.indices.push(index as u32);
        }
        mesh.faces.counts.push(face.len() as u32);
        if uv.is_empty() {
            corners_without += face.len();
        } else if uv.len() == face.len() * 2 {
            uvs.extend(uv.chunks_exact(2).map(|c| [c[0] as f32, c[1] as f32]));
        } else {
            return values.fail(format!(
                "{} has {} texture numbers for its {} corners, expected {}",
                values.place(),
                uv.len(),
                face.len(),
                face.len() * 2
            ));
        }
    }
    if !uvs.is_empty() && corners_without > 0 {
        warn_partial_uvs(values.name, corners_without, mesh.faces.indices.len());
    }
    Ok((corners_without == 0 && !uvs.is_empty()).then_some(uvs))
}

fn skip(values: &mut Values<'_>, element: &Element) -> Result<()> {
    // An element without properties stores nothing, for any count.
    let stored = if element.properties.is_empty() { 0 } else { element.count };
    for i in 0..stored {
        values.begin(element, i)?;
        for property in &element.properties {
            match property.list {
                Some(count) => values.skip_list(count, property.scalar)?,
                None => {
                    values.number(property.scalar)?;
                }
            }
        }
        values.end()?;
    }
    Ok(())
}

/// The numbers of all vertices, by property, in the order of the file. Unsigned bytes are divided by 255.
pub(super) fn scalars(bytes: &[u8], name: &str) -> Result<Vec<(String, Vec<f64>)>> {
    let header = Header::parse(bytes, name)?;
    let mut values = Values::new(bytes, &header, name);
    for element in &header.elements {
        if element.name != "vertex" {
            skip(&mut values, element)?;
            continue;
        }
        let scalars = element.properties.iter().filter(|p| p.list.is_none());
        let mut found: Vec<(String, Vec<f64>)> = scalars.map(|p| (p.name.clone(), Vec::new())).collect();
        for i in 0..element.count {
            values.begin(element, i)?;
            let mut lists = found.iter_mut();
            for property in &element.properties {
                match property.list {
                    Some(count) => values.skip_list(count, property.scalar)?,
                    None => {
                        let scale = if property.scalar == Scalar::U8 { 255.0 } else { 1.0 };
                        let number = values.number(property.scalar)? / scale;
                        lists.next().into_iter().for_each(|(_, numbers)| numbers.push(number));
                    }
                }
            }
            values.end()?;
        }
        return Ok(found);
    }
    values.fail("has no element vertex, expected vertices".into())
}
