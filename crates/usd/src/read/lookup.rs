//! Lookups in a layer that was read.

use crate::layer::{Attribute, Fields, Layer, Prim, Property, Specifier, Value};
use rhytid_export::morphs::Off;
use rhytid_export::{Deviation, StatedRecipe};
use serde_json::{Number, Value as Json};

/// The field called `name`.
pub fn field<'a>(fields: &'a Fields, name: &str) -> Option<&'a Value> {
    fields.iter().find(|(known, _)| known == name).map(|(_, value)| value)
}

/// The dictionary called `name`.
pub(crate) fn dictionary<'a>(fields: &'a Fields, name: &str) -> Option<&'a Fields> {
    match field(fields, name)? {
        Value::Dictionary(entries) => Some(entries),
        _ => None,
    }
}

/// The prim that stands for the whole layer.
pub(crate) fn default_prim(layer: &Layer) -> Option<&Prim> {
    let Some(Value::Token(name)) = field(&layer.metadata, "defaultPrim") else { return None };
    layer.prims.iter().find(|prim| prim.name == *name)
}

/// The transform from mesh units to the layer's, if they are not the same.
pub(crate) const SCALE: &str = "xformOp:scale";

/// The prim of the face in a layer of Rhytid, and where it is.
pub(crate) struct FaceAt<'a> {
    /// The names of the prims from the root of the layer to it.
    pub(crate) path: Vec<&'a str>,
    pub(crate) prim: &'a Prim,
    /// The mesh below it, if there is a single one.
    pub(crate) mesh: Option<&'a Prim>,
}

/// The prim of the face: the default prim, or the one below it that has the recipe or the skeleton. `None`
/// without a default prim.
pub(crate) fn face_of(layer: &Layer) -> Option<FaceAt<'_>> {
    let root = default_prim(layer)?;
    let (mut path, mut prim) = (vec![root.name.as_str()], root);
    while stated_recipe(prim).is_none() && prim.type_name != "SkelRoot" {
        let [only] = &prim.children[..] else {
            (path, prim) = (vec![root.name.as_str()], root);
            break;
        };
        path.push(&only.name);
        prim = only;
    }
    let mesh = match meshes(prim)[..] {
        [mesh] => Some(mesh),
        _ => None,
    };
    Some(FaceAt { path, prim, mesh })
}

/// The meshes below `prim`. A layer that goes over another does not say that they are meshes, but has their
/// points.
pub(super) fn meshes(prim: &Prim) -> Vec<&Prim> {
    let mut found = Vec::new();
    for child in &prim.children {
        let is_over = child.specifier == Specifier::Over && child.type_name.is_empty();
        if child.type_name == "Mesh" || is_over && attribute(child, "points").is_some() {
            found.push(child);
        }
        found.extend(meshes(child));
    }
    found
}

/// The attribute of `prim` called `name`.
pub fn attribute<'a>(prim: &'a Prim, name: &str) -> Option<&'a Attribute> {
    prim.properties.iter().find_map(|property| match property {
        Property::Attribute(attribute) if attribute.name == name => Some(attribute),
        _ => None,
    })
}

/// All prims of the type `type_name` below `prim`.
pub(super) fn below<'a>(prim: &'a Prim, type_name: &str) -> Vec<&'a Prim> {
    let mut found = Vec::new();
    for child in &prim.children {
        found.extend((child.type_name == type_name).then_some(child));
        found.extend(below(child, type_name));
    }
    found
}

/// The errors that an animation states.
pub(super) struct StatedErrors {
    /// In mesh units.
    pub(super) positions: Deviation,
    pub(super) normals: Off,
}

/// The errors that a prim states of its animation, if it does. What is missing is NaN, or beyond every frame.
pub(super) fn stated_errors(prim: &Prim, metres_per_unit: f64) -> Option<StatedErrors> {
    let stated = dictionary(dictionary(&prim.metadata, "customData")?, "rhytidError")?;
    let number = |name: &str| match field(stated, name) {
        Some(Value::Double(number)) => *number,
        _ => f64::NAN,
    };
    let length = |name: &str| number(name) / 1000.0 / metres_per_unit;
    let index = |name: &str| if number(name) >= 0.0 { number(name) as usize } else { usize::MAX };
    let positions = Deviation {
        worst: length("worstMillimetres"),
        at: (index("frame"), index("vertex")),
        rms: length("rmsMillimetres"),
    };
    let normals = Off { worst: number("normalWorst"), rms: number("normalRms") };
    Some(StatedErrors { positions, normals })
}

/// The recipe that a prim states of its animation, if it does.
pub(super) fn stated_recipe(prim: &Prim) -> Option<StatedRecipe> {
    let fields = dictionary(dictionary(&prim.metadata, "customData")?, "rhytid")?;
    let stated = StatedRecipe(json(fields));
    (stated.text("version").is_some() && stated.text("rig").is_some()).then_some(stated)
}

fn json(fields: &Fields) -> Vec<(String, Json)> {
    let entry = |(name, value): &(String, Value)| {
        let value = match value {
            Value::Bool(yes) => Json::Bool(*yes),
            Value::String(text) => Json::String(text.clone()),
            Value::Int(whole) => Json::from(*whole),
            // Whole numbers of frames that no int holds; beyond this, doubles have no odd numbers.
            Value::Double(x) if x.fract() == 0.0 && (f64::from(i32::MAX)..=9e15).contains(x) => {
                Json::from(*x as u64)
            }
            Value::Double(x) => Json::Number(Number::from_f64(*x)?),
            Value::Dictionary(fields) => Json::Object(json(fields).into_iter().collect()),
            _ => return None,
        };
        Some((name.clone(), value))
    };
    fields.iter().filter_map(entry).collect()
}
