//! Lookups in a layer that was read.

use crate::export::{HeadMotion, Provenance, Word};
use crate::usd::layer::{Attribute, Fields, Layer, Prim, Property, Value};

/// The field called `name`.
pub(crate) fn field<'a>(fields: &'a Fields, name: &str) -> Option<&'a Value> {
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

/// The attribute of `prim` called `name`.
pub(crate) fn attribute<'a>(prim: &'a Prim, name: &str) -> Option<&'a Attribute> {
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

/// The largest error that the animation below the default prim `root` states, in millimetres, if it does.
pub(super) fn stated_error(root: &Prim) -> Option<f64> {
    match field(dictionary(dictionary(&root.metadata, "customData")?, "rhytidError")?, "worstMillimetres")? {
        Value::Double(millimetres) => Some(*millimetres),
        _ => None,
    }
}

/// How the animation below the default prim `root` was made, if it says so.
pub(super) fn provenance(root: &Prim) -> Option<Provenance> {
    let fields = dictionary(dictionary(&root.metadata, "customData")?, "rhytid")?;
    let text = |name: &str| match field(fields, name)? {
        Value::String(text) => Some(text.clone()),
        _ => None,
    };
    let number = |name: &str| match field(fields, name)? {
        Value::Int(x) => Some(f64::from(*x)),
        Value::Double(x) => Some(*x),
        _ => None,
    };
    let flag = |name: &str| match field(fields, name)? {
        Value::Bool(yes) => Some(*yes),
        _ => None,
    };
    // Beyond this, doubles have no odd numbers.
    let frame =
        |name: &str| number(name).filter(|x| x.fract() == 0.0 && (0.0..=9e15).contains(x)).map(|x| x as u64);
    Some(Provenance {
        version: text("version")?,
        rig: text("rig")?,
        stage: Word::of(&text("stage")?),
        first_frame: frame("first_frame")?,
        end_frame: frame("end_frame")?,
        fps: Provenance::rate(number("fps")?),
        missing: Word::of(&text("missing")?),
        detail: number("detail"),
        detail_of: text("detail_of"),
        edit: text("edit"),
        edit_hash: text("edit_hash"),
        normals: flag("normals"),
        velocities: flag("velocities"),
        strain: flag("strain"),
        refine: flag("refine"),
        // Older files have neither of these.
        fade_detail: matches!(field(fields, "fade_detail"), Some(Value::Bool(true))),
        head: text("head").map_or(HeadMotion::Keep.into(), |word| Word::of(&word)),
    })
}
