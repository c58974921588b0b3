//! The materials of a mesh: a subset of its faces for each, and how each looks, as USD's preview surface.
use super::names::{display_name, identifiers};
use super::numbers::integer;
use super::textures::Assets;
use crate::build::{attribute, prim, token};
use crate::layer::{Attribute, Prim, Value};
use rhytid_core::{Look, Materials, Result, Transparency};
use rhytid_export::Scene;

/// The material of faces that have none in the input.
const WITHOUT: &str = "skin";

/// Binds `mesh` and subsets of its faces to materials, and returns the scope with the materials, which is to
/// stand at the path `scope`. `assets` says which textures they have.
pub(super) fn bind(mesh: &mut Prim, scene: &Scene<'_>, scope: &str, assets: &Assets) -> Result<Prim> {
    let (_, scope_name) = scope.rsplit_once('/').unwrap_or(("", scope));
    let mut looks = prim("Scope", scope_name);
    let listed = scene.materials.map_or(&[][..], |materials| &materials.list);
    let of_face = scene.materials.map_or(&[][..], |materials| &materials.of_face);
    // The last list is of the faces without a material.
    let mut faces_of = vec![Vec::new(); listed.len() + 1];
    for (face, &material) in of_face.iter().enumerate() {
        let place = if material == Materials::NONE { listed.len() } else { material as usize };
        faces_of[place].push(integer(face)?);
    }
    let mut names = identifiers(listed.iter().map(|material| &*material.name).chain([WITHOUT]));
    let without = names.pop().unwrap_or_default();
    let faces_without = faces_of.pop().unwrap_or_default();
    for ((name, material), faces) in names.iter().zip(listed).zip(faces_of) {
        let asset = assets.of(material.look().texture);
        let look = if asset.is_some() { material.look() } else { material.look_without_texture() };
        mesh.children.push(subset(name, &material.name, faces, format!("{scope}/{name}")));
        looks.children.push(shaded(name, &material.name, &look, asset, scope));
    }
    if !listed.is_empty() {
        mesh.set_uniform("token", "subsetFamily:materialBind:familyType", token("partition"));
    }
    let path = format!("{scope}/{without}");
    if listed.is_empty() {
        mesh.apply("MaterialBindingAPI");
        mesh.relate("material:binding", vec![path]);
    } else if !faces_without.is_empty() {
        // Blender gives faces beside all subsets the first material.
        mesh.children.push(subset(&without, &without, faces_without, path));
    } else {
        return Ok(looks);
    }
    looks.children.push(shaded(&without, &without, &Materials::look_without(), None, scope));
    Ok(looks)
}

fn subset(name: &str, original: &str, faces: Vec<i32>, material: String) -> Prim {
    let mut subset = prim("GeomSubset", name);
    subset.metadata.extend(display_name(name, original));
    subset.apply("MaterialBindingAPI");
    subset.set_uniform("token", "elementType", token("face"));
    subset.set_uniform("token", "familyName", token("materialBind"));
    subset.set("int[]", "indices", Value::Ints(faces));
    subset.relate("material:binding", vec![material]);
    subset
}

/// A material below the scope. `asset` is the path of the texture of its base colour.
fn shaded(name: &str, original: &str, look: &Look, asset: Option<&str>, scope: &str) -> Prim {
    let path = format!("{scope}/{name}");
    let mut material = prim("Material", name);
    let mut data = vec![("name".into(), Value::String(original.into()))];
    if look.is_default {
        // So that nobody takes it for what was scanned.
        data.push(("defaultLook".into(), Value::Bool(true)));
    }
    material.metadata.push(("customData".into(), Value::Dictionary(data)));
    material.metadata.extend(display_name(name, original));
    material.push(connected("token", "outputs:surface", format!("{path}/surface.outputs:surface")));
    material.children.push(surface(look, asset.is_some(), &path));
    if let Some(asset) = asset {
        material.children.extend([texture(look, asset, &path), coordinates()]);
    }
    material
}

/// The preview surface. A texture is multiplied by the base colour and the opacity, which is done where the
/// texture is read.
fn surface(look: &Look, has_texture: bool, material: &str) -> Prim {
    let mut surface = shader("surface", "UsdPreviewSurface");
    let of_texture =
        |type_name, name, output| connected(type_name, name, format!("{material}/texture.outputs:{output}"));
    if has_texture {
        surface.push(of_texture("color3f", "inputs:diffuseColor", "rgb"));
    } else {
        surface.set("color3f", "inputs:diffuseColor", Value::Float3(look.base_color));
    }
    match look.transparency {
        Transparency::Opaque => surface.set("float", "inputs:opacity", Value::Float(1.0)),
        Transparency::Mask(_) | Transparency::Blend if has_texture => {
            surface.push(of_texture("float", "inputs:opacity", "a"));
        }
        Transparency::Mask(_) | Transparency::Blend => {
            surface.set("float", "inputs:opacity", Value::Float(look.opacity));
        }
    }
    if let Transparency::Mask(cutoff) = look.transparency {
        surface.set("float", "inputs:opacityThreshold", Value::Float(cutoff));
    }
    surface.set("float", "inputs:roughness", Value::Float(look.roughness));
    surface.set("float", "inputs:metallic", Value::Float(look.metallic));
    surface.push(attribute("token", "outputs:surface", None));
    surface
}

/// What reads the texture. Outside of 0 to 1, it repeats.
fn texture(look: &Look, asset: &str, material: &str) -> Prim {
    let mut texture = shader("texture", "UsdUVTexture");
    texture.set("asset", "inputs:file", Value::Asset(asset.into()));
    texture.set("token", "inputs:sourceColorSpace", token("sRGB"));
    texture.set("token", "inputs:wrapS", token("repeat"));
    texture.set("token", "inputs:wrapT", token("repeat"));
    let [red, green, blue] = look.base_color;
    let scale = [red, green, blue, look.opacity];
    if scale != [1.0; 4] {
        texture.set("float4", "inputs:scale", Value::Float4(scale));
    }
    texture.push(connected("float2", "inputs:st", format!("{material}/st.outputs:result")));
    texture.push(attribute("float3", "outputs:rgb", None));
    texture.push(attribute("float", "outputs:a", None));
    texture
}

/// What reads the texture coordinates.
fn coordinates() -> Prim {
    let mut coordinates = shader("st", "UsdPrimvarReader_float2");
    coordinates.set("string", "inputs:varname", Value::String("st".into()));
    coordinates.push(attribute("float2", "outputs:result", None));
    coordinates
}

fn shader(name: &str, id: &str) -> Prim {
    let mut shader = prim("Shader", name);
    shader.set_uniform("token", "info:id", token(id));
    shader
}

fn connected(type_name: &str, name: &str, to: String) -> Attribute {
    Attribute { connections: vec![to], ..attribute(type_name, name, None) }
}
