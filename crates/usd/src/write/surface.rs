//! The common part of an animation and shapes: the layer's metadata, the default prim, and the mesh at rest.
use super::materials;
use super::names::identifier;
use super::numbers::integer;
use crate::build::{attribute, prim, token};
use crate::layer::{Attribute, Fields, Layer, Prim, Value};
use rhytid_core::{Faces, Result, UpAxis, Uvs};
use rhytid_export::{Scene, StatedRecipe};
use serde_json::Value as Json;

/// A layer in the making.
pub(super) struct Surface {
    pub(super) metadata: Fields,
    /// The default prim, without children.
    pub(super) root: Prim,
    /// The mesh, to be its first child.
    pub(super) mesh: Prim,
    /// The materials, to be its last child.
    pub(super) looks: Option<Prim>,
}

impl Surface {
    /// The scene at rest, under a prim of the type `root`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if it has more vertices than USD counts.
    pub(super) fn new(scene: &Scene<'_>, root: &str) -> Result<Self> {
        let name = identifier(scene.name);
        let mut root = prim(root, &name);
        root.metadata.push(("kind".into(), token("component")));
        root.metadata.push(("customData".into(), custom_data(scene.recipe)));
        let mut mesh = mesh(scene, &format!("{name}_mesh"))?;
        let scope = format!("/{name}/Looks");
        let looks = scene.materials.map(|named| materials::bind(&mut mesh, named, &scope)).transpose()?;
        Ok(Self { metadata: metadata(scene, &name), root, mesh, looks })
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
            self.root
                .push(Attribute { samples: Some(head), ..attribute("matrix4d", "xformOp:transform", None) });
            let order = Value::Tokens(vec!["xformOp:transform".into()]);
            self.root.set_uniform("token[]", "xformOpOrder", order);
        }
    }

    /// The layer, with these prims between the mesh and the materials.
    pub(super) fn into_layer(self, between: Vec<Prim>) -> Layer {
        let mut root = self.root;
        root.children = std::iter::once(self.mesh).chain(between).chain(self.looks).collect();
        Layer { metadata: self.metadata, prims: vec![root] }
    }
}

fn metadata(scene: &Scene<'_>, name: &str) -> Fields {
    let up_axis = match scene.up_axis {
        UpAxis::Y => "Y",
        UpAxis::Z => "Z",
    };
    vec![
        ("defaultPrim".into(), token(name)),
        ("metersPerUnit".into(), Value::Double(scene.metres_per_unit)),
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

fn mesh(scene: &Scene<'_>, name: &str) -> Result<Prim> {
    let mut mesh = prim("Mesh", name);
    mesh.set_uniform("bool", "doubleSided", Value::Bool(true));
    mesh.set_uniform("token", "subdivisionScheme", token("none"));
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
