//! The common part of an animation and shapes: the layer's metadata, the default prim, and the mesh at rest.
use super::choices::{Choices, scheme};
use super::materials;
use super::names::{display_name, identifier};
use super::numbers::integer;
use crate::build::{attribute, prim, token};
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Specifier, Value};
use crate::read::SCALE;
use rhytid_core::{Faces, Result, UpAxis, Uvs};
use rhytid_export::{Scene, StatedRecipe, Subdivision};
use serde_json::Value as Json;

/// The head's motion.
const TRANSFORM: &str = "xformOp:transform";
/// The order of transforms.
const ORDER: &str = "xformOpOrder";

/// A layer in the making.
pub(super) struct Surface {
    metadata: Fields,
    /// The names of the prims above the face's.
    above: Vec<String>,
    /// Whether the layer goes over another that has the mesh.
    over: bool,
    /// The face's prim, without children.
    pub(super) root: Prim,
    /// The mesh, to be its first child.
    pub(super) mesh: Prim,
    /// The materials, to be its last child.
    looks: Prim,
}

impl Surface {
    /// The scene at rest, under a prim of the type `root`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if it has more vertices than USD counts.
    pub(super) fn new(scene: &Scene<'_>, root: &str, choices: &Choices) -> Result<Self> {
        let (above, name) = choices.path(scene);
        let mut root = prim(root, &name);
        root.metadata.push(("kind".into(), token("component")));
        root.metadata.push(("customData".into(), custom_data(scene.recipe)));
        if choices.prim_path.is_none() {
            root.metadata.extend(display_name(&name, scene.name));
        }
        let mut mesh = mesh(scene, &choices.mesh(&name), choices.subdivision)?;
        let scope = format!("{}/Looks", path_of(&above, &name));
        let looks = materials::bind(&mut mesh, scene, &scope, &choices.assets)?;
        let unit = if choices.metres { 1.0 } else { scene.metres_per_unit };
        if choices.metres {
            root.set("double3", SCALE, Value::Double3([scene.metres_per_unit; 3]));
            root.set_uniform("token[]", ORDER, Value::Tokens(vec![SCALE.into()]));
        }
        let metadata = metadata(scene, unit, above.first().unwrap_or(&name));
        Ok(Self { metadata, above, over: choices.over, root, mesh, looks })
    }

    /// The path of the face's prim.
    pub(super) fn path(&self) -> String {
        path_of(&self.above, &self.root.name)
    }

    /// Says when the frames are; a head that moves has its samples under the number `head`.
    pub(super) fn play(&mut self, scene: &Scene<'_>, head: usize) {
        let first = scene.first_time_code;
        for (name, value) in [
            ("startTimeCode", first),
            ("endTimeCode", first + (scene.frames - 1) as f64),
            ("timeCodesPerSecond", scene.rate),
            ("framesPerSecond", scene.rate),
        ] {
            self.metadata.push((name.into(), Value::Double(value)));
        }
        if scene.head.is_some() {
            self.root.push(Attribute { samples: Some(head), ..attribute("matrix4d", TRANSFORM, None) });
            let scaled = self.root.properties.iter().any(|property| property.name() == SCALE);
            self.root.properties.retain(|property| property.name() != ORDER);
            // The last of them moves the points first.
            let order = [SCALE, TRANSFORM].into_iter().filter(|name| scaled || *name == TRANSFORM);
            self.root.set_uniform("token[]", ORDER, Value::Tokens(order.map(String::from).collect()));
        }
    }

    /// The layer, with these prims between the mesh and the materials.
    pub(super) fn into_layer(self, between: Vec<Prim>) -> Layer {
        let mut root = self.root;
        root.children = std::iter::once(self.mesh).chain(between).chain([self.looks]).collect();
        if self.over {
            let empty = over(prim("", &root.name));
            root = sampled(root).unwrap_or(empty);
        }
        let within = |child: Prim, name: &String| {
            let mut parent = prim("Xform", name);
            parent.metadata.push(("kind".into(), token("group")));
            if self.over {
                parent = over(parent);
            }
            parent.children.push(child);
            parent
        };
        Layer { metadata: self.metadata, prims: vec![self.above.iter().rev().fold(root, within)] }
    }
}

fn path_of(above: &[String], name: &str) -> String {
    above.iter().map(|name| format!("/{name}")).collect::<String>() + "/" + name
}

/// The same prim as an opinion on one that is defined elsewhere.
fn over(prim: Prim) -> Prim {
    let is_note = |(name, _): &(String, Value)| name == "customData";
    let metadata = prim.metadata.into_iter().filter(is_note).collect();
    Prim { specifier: Specifier::Over, type_name: String::new(), metadata, ..prim }
}

/// What has samples in a prim and below it, over what is defined elsewhere; `None` if nothing has. The order
/// of transforms and their scale belong to the samples of a transform.
fn sampled(prim: Prim) -> Option<Prim> {
    let mut prim = over(prim);
    prim.children = prim.children.into_iter().filter_map(sampled).collect();
    prim.properties.retain_mut(|property| match property {
        Property::Attribute(attribute) if attribute.samples.is_some() => {
            attribute.default = None;
            true
        }
        property => [ORDER, SCALE].contains(&property.name()),
    });
    (!prim.properties.is_empty() || !prim.children.is_empty()).then_some(prim)
}

fn metadata(scene: &Scene<'_>, metres_per_unit: f64, name: &str) -> Fields {
    let up_axis = match scene.up_axis {
        UpAxis::Y => "Y",
        UpAxis::Z => "Z",
    };
    vec![
        ("defaultPrim".into(), token(name)),
        ("metersPerUnit".into(), Value::Double(metres_per_unit)),
        ("upAxis".into(), token(up_axis)),
    ]
}

/// A recipe, under the names of its fields.
pub(crate) fn custom_data(recipe: &StatedRecipe) -> Value {
    Value::Dictionary(vec![("rhytid".into(), dictionary(recipe.0.iter().map(|(name, value)| (name, value))))])
}

fn dictionary<'a>(fields: impl Iterator<Item = (&'a String, &'a Json)>) -> Value {
    let entry = |(name, value): (&String, &Json)| {
        let value = match value {
            Json::Bool(yes) => Value::Bool(*yes),
            Json::String(text) => Value::String(text.clone()),
            // Frame numbers are small; the largest are kept as well as a double can.
            Json::Number(number) => match number.as_i64().and_then(|whole| i32::try_from(whole).ok()) {
                Some(whole) => Value::Int(whole),
                None => Value::Double(number.as_f64()?),
            },
            Json::Object(fields) => dictionary(fields.iter()),
            Json::Null | Json::Array(_) => return None,
        };
        Some((name.clone(), value))
    };
    Value::Dictionary(fields.filter_map(entry).collect())
}

fn mesh(scene: &Scene<'_>, name: &str, subdivision: Subdivision) -> Result<Prim> {
    let mut mesh = prim("Mesh", name);
    if identifier(scene.name) != scene.name {
        mesh.metadata.extend(display_name(name, scene.name));
    }
    mesh.set_uniform("bool", "doubleSided", Value::Bool(true));
    mesh.set_uniform("token", "subdivisionScheme", token(scheme(subdivision)));
    let Faces { counts, indices } = scene.faces;
    mesh.set("int[]", "faceVertexCounts", integers(counts)?);
    mesh.set("int[]", "faceVertexIndices", integers(indices)?);
    if let Some(Uvs { values, corners }) = scene.uvs {
        let interpolation = if corners.is_some() { "faceVarying" } else { "vertex" };
        mesh.push(Attribute {
            metadata: vec![("interpolation".into(), token(interpolation))],
            ..attribute("texCoord2f[]", "primvars:st", Some(Value::Float2s(values.clone())))
        });
        if let Some(corners) = corners {
            mesh.set("int[]", "primvars:st:indices", integers(corners)?);
        }
    }
    mesh.set("point3f[]", "points", Value::Float3s(scene.rest.to_vec()));
    if let Some(normals) = scene.rest_normals {
        mesh.push(Attribute {
            metadata: vec![("interpolation".into(), token("vertex"))],
            ..attribute("normal3f[]", "normals", Some(Value::Float3s(normals.to_vec())))
        });
    }
    mesh.set("float3[]", "extent", Value::Float3s(extent(scene.rest).to_vec()));
    Ok(mesh)
}

/// Smallest and largest coordinates.
pub(super) fn extent(positions: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let mut extent = [[f32::MAX; 3], [f32::MIN; 3]];
    for position in positions {
        for (axis, &x) in position.iter().enumerate() {
            extent[0][axis] = extent[0][axis].min(x);
            extent[1][axis] = extent[1][axis].max(x);
        }
    }
    extent
}

fn integers(numbers: &[u32]) -> Result<Value> {
    numbers.iter().map(|&x| integer(x as usize)).collect::<Result<_>>().map(Value::Ints)
}
