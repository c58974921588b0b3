//! One mesh prim.

use super::shapes::{self, Worn};
use super::tree::{Placed, Tree, target};
use super::values::Values;
use crate::shapes::Shape;
use glam::{DMat4, DVec3};
use rhytid_core::{Faces, Result};
use rhytid_usd::layer::{Attribute, Property, Value};
use rhytid_usd::read::{attribute, field};
use std::collections::HashMap;

/// What a mesh prim has, in the layer's space.
pub(super) struct PrimMesh {
    /// The name of the prim.
    pub(super) name: String,
    pub(super) positions: Vec<[f64; 3]>,
    /// Without those that are holes or have fewer than three corners.
    pub(super) faces: Faces,
    pub(super) uvs: Option<PrimUvs>,
    /// The names of its materials.
    pub(super) materials: Vec<String>,
    /// The number of each face's material in `materials`.
    pub(super) material_of_face: Vec<Option<usize>>,
    pub(super) shapes: Vec<Shape>,
}

/// Texture coordinates by corner.
pub(super) struct PrimUvs {
    pub(super) values: Vec<[f32; 2]>,
    /// The entry of each corner, which may be past the last.
    pub(super) corners: Vec<u32>,
}

/// Reads a mesh of the layer whose prims are `tree`.
pub(super) fn read(
    placed: &Placed<'_>,
    tree: &Tree<'_>,
    worn: &[Worn],
    values: &mut Values<'_>,
) -> Result<PrimMesh> {
    let Placed { path, prim, .. } = placed;
    let wrong = |values: &Values<'_>, what: &str| values.wrong(path, what);
    let Some(mut positions) = values.vectors(prim, "points")? else {
        return Err(wrong(values, "has no points, expected those of a mesh; export it again"));
    };
    let Some(counts) = values.indices(prim, path, "faceVertexCounts")? else {
        return Err(wrong(values, "has no faceVertexCounts, expected a mesh with faces; export it again"));
    };
    let Some(indices) = values.indices(prim, path, "faceVertexIndices")? else {
        return Err(wrong(values, "has no faceVertexIndices, expected a mesh with faces; export it again"));
    };
    // The schema's fallback says nothing about a scan, so a scheme counts only if the file has it.
    if let Some(Value::Token(scheme)) = values.get(prim, "subdivisionScheme")?
        && scheme != "none"
    {
        log::warn!(
            "{}: {path} is the cage of a subdivision surface ({scheme}); its points are read as they are",
            values.name
        );
    }
    let all = counts.iter().map(|n| u64::from(*n)).sum::<u64>();
    if all != indices.len() as u64 {
        let what = format!("has {} corners, expected the {all} of its faces; export it again", indices.len());
        return Err(wrong(values, &what));
    }
    if let Some(v) = indices.iter().find(|v| **v as usize >= positions.len()) {
        let what = format!("names the point {v}, expected 0 to {}", positions.len().saturating_sub(1));
        return Err(wrong(values, &format!("{what}; export it again")));
    }
    let uvs = uvs(placed, &indices, counts.len(), positions.len(), values)?;
    let OfFaces { names, of_face } = materials(placed, tree, counts.len(), values)?;

    let to_layer = to_layer(placed, tree, values)?;
    let mut shapes = shapes::read(placed, tree, positions.len(), values)?;
    shapes::wear(&mut positions, &shapes, worn, values);
    positions.iter_mut().for_each(|x| *x = to_layer.transform_point3(DVec3::from_array(*x)).to_array());
    for (_, by) in shapes.iter_mut().flat_map(|shape| &mut shape.moved) {
        *by = to_layer.transform_vector3(DVec3::from_array(*by)).to_array();
    }

    let is_left_handed = values.get(prim, "orientation")? == Some(Value::Token("leftHanded".to_owned()));
    // A mirror turns faces inside out.
    let is_turned = is_left_handed != (to_layer.determinant() < 0.0);
    let holes = values.indices(prim, path, "holeIndices")?.unwrap_or_default();
    let mut is_hole = vec![false; counts.len()];
    for face in holes {
        if let Some(hole) = is_hole.get_mut(face as usize) {
            *hole = true;
        }
    }
    let mut read = PrimMesh {
        name: prim.name.clone(),
        positions,
        faces: Faces::default(),
        uvs: uvs.as_ref().map(|uvs| PrimUvs { values: uvs.values.clone(), corners: Vec::new() }),
        materials: names,
        material_of_face: Vec::new(),
        shapes,
    };
    let (mut first, mut left_out) = (0, 0);
    for (f, count) in counts.iter().enumerate() {
        let mut corners: Vec<usize> = (first..first + *count as usize).collect();
        first += *count as usize;
        if *count < 3 || is_hole[f] {
            left_out += usize::from(*count < 3);
            continue;
        }
        if is_turned {
            corners[1..].reverse();
        }
        let face: Vec<u32> = corners.iter().map(|corner| indices[*corner]).collect();
        read.faces.push(&face);
        if let (Some(kept), Some(all)) = (&mut read.uvs, &uvs) {
            kept.corners.extend(corners.iter().map(|corner| all.corners[*corner]));
        }
        read.material_of_face.push(of_face[f]);
    }
    if left_out > 0 {
        log::warn!(
            "{}: {left_out} faces of {path} have fewer than three corners and are left out",
            values.name
        );
    }
    Ok(read)
}

/// From the points' space to the layer's. A skinned mesh is read as it was bound: its skeleton places it.
fn to_layer(placed: &Placed<'_>, tree: &Tree<'_>, values: &mut Values<'_>) -> Result<DMat4> {
    let is_skinned = attribute(placed.prim, "primvars:skel:jointIndices").is_some();
    let skeleton = placed.inherited.skeleton.filter(|_| is_skinned);
    let Some(skeleton) = skeleton.and_then(|path| tree.at(path)) else {
        return Ok(placed.inherited.world);
    };
    let bind = match values.get(placed.prim, "primvars:skel:geomBindTransform")? {
        Some(Value::Matrix4d(rows)) => DMat4::from_cols_array_2d(&rows),
        _ => DMat4::IDENTITY,
    };
    Ok(skeleton.inherited.world * bind)
}

/// The mesh's texture coordinates: those called `st`, else its first ones.
fn uvs(
    placed: &Placed<'_>,
    indices: &[u32],
    faces: usize,
    points: usize,
    values: &mut Values<'_>,
) -> Result<Option<PrimUvs>> {
    let is_uv = |attribute: &&Attribute| {
        let is_of_role = attribute.type_name.starts_with("texCoord2");
        attribute.name == "primvars:st"
            || attribute.name.starts_with("primvars:") && is_of_role && !attribute.name.ends_with(":indices")
    };
    let of_prim = placed.prim.properties.iter().filter_map(|property| match property {
        Property::Attribute(attribute) => Some(attribute),
        Property::Relationship(_) => None,
    });
    let found: Vec<&Attribute> = of_prim.filter(is_uv).collect();
    let named = found.iter().find(|attribute| attribute.name == "primvars:st");
    let Some(chosen) = named.or(found.first()) else { return Ok(None) };
    let coordinates: Vec<[f32; 2]> = match values.get(placed.prim, &chosen.name)? {
        Some(Value::Float2s(uvs)) => uvs,
        Some(Value::Double2s(uvs)) => uvs.iter().map(|uv| uv.map(|x| x as f32)).collect(),
        Some(Value::Float3s(uvs)) => uvs.iter().map(|[u, v, _]| [*u, *v]).collect(),
        _ => return Ok(None),
    };
    let order = values.indices(placed.prim, &placed.path, &format!("{}:indices", chosen.name))?;
    let interpolation = match field(&chosen.metadata, "interpolation") {
        Some(Value::Token(word)) => word.as_str(),
        // The default of USD.
        _ => "constant",
    };
    let elements = order.as_ref().map_or(coordinates.len(), Vec::len);
    let by_corner: Option<Vec<u32>> = match interpolation {
        "faceVarying" if elements == indices.len() => Some((0..indices.len() as u32).collect()),
        "vertex" | "varying" if elements == points => Some(indices.to_vec()),
        _ => None,
    };
    let entry = |element: &u32| order.as_ref().map_or(*element, |order| order[*element as usize]);
    match by_corner {
        Some(elements) => {
            let corners = elements.iter().map(entry).collect();
            Ok(Some(PrimUvs { values: coordinates, corners }))
        }
        None => {
            log::warn!(
                "{}: {} of {} do not fit its {faces} faces (interpolation {interpolation}), so they are left out",
                values.name,
                chosen.name,
                placed.path
            );
            Ok(None)
        }
    }
}

/// Materials by face.
struct OfFaces {
    names: Vec<String>,
    /// The number in `names`.
    of_face: Vec<Option<usize>>,
}

/// The materials that the mesh and its subsets are bound to.
fn materials(placed: &Placed<'_>, tree: &Tree<'_>, faces: usize, values: &mut Values<'_>) -> Result<OfFaces> {
    let mut names = Vec::new();
    let mut numbers: HashMap<String, usize> = HashMap::new();
    let mut number = |path: &str| {
        let name = material_name(tree, path);
        *numbers.entry(name.clone()).or_insert_with(|| {
            names.push(name);
            names.len() - 1
        })
    };
    let of_mesh = placed.inherited.material.map(&mut number);
    let mut of_face = vec![of_mesh; faces];
    for subset in placed.prim.children.iter().filter(|child| child.type_name == "GeomSubset") {
        let Some(material) = target(subset, "material:binding") else { continue };
        let material = number(material);
        let path = format!("{}/{}", placed.path, subset.name);
        for face in values.indices(subset, &path, "indices")?.unwrap_or_default() {
            if let Some(of_face) = of_face.get_mut(face as usize) {
                *of_face = Some(material);
            }
        }
    }
    Ok(OfFaces { names, of_face })
}

/// The name of the material at a path. An export of Rhytid keeps the name that the input had.
pub(super) fn material_name(tree: &Tree<'_>, path: &str) -> String {
    let data = tree.at(path).and_then(|material| field(&material.prim.metadata, "customData"));
    let original = match data {
        Some(Value::Dictionary(data)) => field(data, "name"),
        _ => None,
    };
    let name = match original {
        Some(Value::String(name)) => name,
        _ => path.rsplit('/').next().unwrap_or(path),
    };
    // Each face may name it again.
    name.chars().take(LONGEST_NAME).collect()
}

/// The most characters of a material's name.
const LONGEST_NAME: usize = 256;
