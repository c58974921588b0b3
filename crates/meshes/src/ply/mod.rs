//! PLY: ASCII and both binary forms. The existing crates give no useful line or element numbers, and refuse
//! ASCII numbers such as `.5`, `1.` or `nan`. So this is a reader of its own.

mod header;
mod values;

use super::uvs::CornerUvs;
use header::{Element, Header, Property, Scalar};
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
    values.say_surplus();
    match (corner_uvs, vertex_uvs) {
        (Some(uvs), _) => uvs.finish(&mut mesh, name),
        (None, Some(of_vertices)) => {
            let mut uvs = CornerUvs::new(of_vertices);
            mesh.faces.indices.iter().for_each(|&v| uvs.push(v));
            uvs.finish(&mut mesh, name);
        }
        (None, None) => warn_unknown_uvs(&header, name),
    }
    Ok(mesh)
}

/// Says which properties look like texture coordinates where none have a known name.
fn warn_unknown_uvs(header: &Header, name: &str) {
    let looks_like = |property: &&Property| {
        let lower = property.name.to_ascii_lowercase();
        let has_name =
            ["uv", "tex"].iter().any(|begin| lower.starts_with(begin)) || lower.contains("texcoord");
        // Whole numbers are the indices of images.
        has_name && !is_known(&lower) && matches!(property.scalar, Scalar::F32 | Scalar::F64)
    };
    let properties = header.elements.iter().flat_map(|element| &element.properties);
    let found: Vec<&str> = properties.filter(looks_like).map(|property| &*property.name).collect();
    if !found.is_empty() {
        log::warn!(
            "{name}: has no texture coordinates under a known name, but {:?} may be some; rename them s and t \
             (of vertices) or texcoord (a list of faces) in the header",
            &found[..found.len().min(5)]
        );
    }
}

/// Names of the two texture coordinates of a vertex, as programs write them.
const UVS_OF_VERTICES: [[&str; 2]; 8] = [
    ["u", "v"],
    ["s", "t"],
    ["texture_u", "texture_v"],
    ["texture_s", "texture_t"],
    ["tu", "tv"],
    ["texcoord_u", "texcoord_v"],
    ["texcoord_s", "texcoord_t"],
    ["tex_u", "tex_v"],
];

/// Names of a face's list of texture coordinates, two for each corner.
const UVS_OF_FACES: [&str; 5] = ["texcoord", "texcoords", "t", "uv", "st"];

fn is_known(name: &str) -> bool {
    UVS_OF_FACES.contains(&name) || UVS_OF_VERTICES.as_flattened().contains(&name)
}

/// Texture coordinates per vertex, if the vertices have any.
fn read_vertices(
    values: &mut Values<'_>,
    element: &Element,
    mesh: &mut Mesh,
) -> Result<Option<Vec<[f32; 2]>>> {
    let scalar = |wanted: &str| {
        let mut properties = element.properties.iter();
        properties.position(|p| p.name.eq_ignore_ascii_case(wanted) && p.list.is_none())
    };
    let (Some(x), Some(y), Some(z)) = (scalar("x"), scalar("y"), scalar("z")) else {
        return values.fail("the element vertex lacks a property x, y or z; export the mesh again".into());
    };
    let uv = UVS_OF_VERTICES.iter().find_map(|[u, v]| scalar(u).zip(scalar(v)));
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
        values.end();
        mesh.positions.push([row[x], row[y], row[z]]);
        if let (Some(uvs), Some((u, v))) = (&mut uvs, uv) {
            uvs.push([row[u] as f32, row[v] as f32]);
        }
    }
    Ok(uvs)
}

/// Texture coordinates per corner, if some face has them.
fn read_faces(
    values: &mut Values<'_>,
    element: &Element,
    vertices: u64,
    mesh: &mut Mesh,
) -> Result<Option<CornerUvs>> {
    let list = |wanted: &str| {
        let mut properties = element.properties.iter();
        properties.position(|p| p.name.eq_ignore_ascii_case(wanted) && p.list.is_some())
    };
    let Some(indices) = list("vertex_indices").or_else(|| list("vertex_index")) else {
        return values.fail(
            "the element face lacks the list vertex_indices (or vertex_index); export the mesh again".into(),
        );
    };
    let texcoord = UVS_OF_FACES.iter().find_map(|name| list(name));
    let mut uvs = CornerUvs::default();
    let mut short_faces = 0_u64;
    let mut first_short = String::new();
    let mut wrong_lists = 0_u64;
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
        values.end();
        if face.len() < 3 {
            if short_faces == 0 {
                first_short = values.place();
            }
            short_faces += 1;
            continue;
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
        if uv.len() == face.len() * 2 {
            for pair in uv.chunks_exact(2) {
                uvs.push(uvs.values.len() as u32);
                uvs.values.push([pair[0] as f32, pair[1] as f32]);
            }
        } else {
            wrong_lists += u64::from(!uv.is_empty());
            uvs.push_none(face.len());
        }
    }
    if short_faces > 0 {
        log::warn!(
            "{}: {short_faces} faces have fewer than 3 corners and were left out, the first is {first_short}",
            values.name
        );
    }
    if wrong_lists > 0 {
        log::warn!(
            "{}: {wrong_lists} faces have texture coordinates that are not two numbers for each corner, so their \
             corners have none; export the mesh again",
            values.name
        );
    }
    Ok((!uvs.values.is_empty()).then_some(uvs))
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
        values.end();
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
            values.end();
        }
        values.say_surplus();
        return Ok(found);
    }
    values.fail("has no element vertex, expected vertices".into())
}
