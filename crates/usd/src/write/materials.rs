//! The materials that a mesh names: a subset of its faces for each, and an empty material to fill in.
use super::names::identifiers;
use super::numbers::integer;
use crate::build::{attribute, prim, token};
use crate::layer::{Attribute, Prim, Value};
use rhytid_core::{Materials, Result};

/// Adds the subsets to `mesh`, and returns the scope with the materials, which is to stand at the path
/// `scope`.
pub(super) fn bind(mesh: &mut Prim, materials: &Materials, scope: &str) -> Result<Prim> {
    let (_, scope_name) = scope.rsplit_once('/').unwrap_or(("", scope));
    let mut looks = prim("Scope", scope_name);
    let mut faces_of = vec![Vec::new(); materials.list.len()];
    for (face, &material) in materials.of_face.iter().enumerate() {
        if material != Materials::NONE {
            faces_of[material as usize].push(integer(face)?);
        }
    }
    let all = materials.of_face.iter().all(|&material| material != Materials::NONE);
    let family = if all { "partition" } else { "nonOverlapping" };
    mesh.set_uniform("token", "subsetFamily:materialBind:familyType", token(family));
    let names = identifiers(materials.names());
    for ((name, original), faces) in names.iter().zip(materials.names()).zip(faces_of) {
        mesh.children.push(subset(name, faces, format!("{scope}/{name}")));
        looks.children.push(material(name, original, scope));
    }
    Ok(looks)
}

fn subset(name: &str, faces: Vec<i32>, material: String) -> Prim {
    let mut subset = prim("GeomSubset", name);
    subset.apply("MaterialBindingAPI");
    subset.set_uniform("token", "elementType", token("face"));
    subset.set_uniform("token", "familyName", token("materialBind"));
    subset.set("int[]", "indices", Value::Ints(faces));
    subset.relate("material:binding", vec![material]);
    subset
}

/// A material that looks as USD's preview surface does when nothing is said, with the input's name as custom
/// data.
fn material(name: &str, original: &str, scope: &str) -> Prim {
    let mut material = prim("Material", name);
    let data = vec![("name".into(), Value::String(original.into()))];
    material.metadata.push(("customData".into(), Value::Dictionary(data)));
    material.push(Attribute {
        connections: vec![format!("{scope}/{name}/surface.outputs:surface")],
        ..attribute("token", "outputs:surface", None)
    });
    let mut surface = prim("Shader", "surface");
    surface.set_uniform("token", "info:id", token("UsdPreviewSurface"));
    surface.push(attribute("token", "outputs:surface", None));
    material.children.push(surface);
    material
}
