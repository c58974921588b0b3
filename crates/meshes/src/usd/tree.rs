//! The prims of a layer, each with its path and its place.

use super::place::local;
use super::values::Values;
use glam::DMat4;
use rhytid_core::Result;
use rhytid_usd::layer::{Layer, Prim, Property, Specifier, Value};
use rhytid_usd::read::field;
use std::collections::HashMap;

/// A prim that the layer defines.
pub(super) struct Placed<'a> {
    pub(super) path: String,
    pub(super) prim: &'a Prim,
    pub(super) inherited: Inherited<'a>,
}

/// What a prim has of its own or from those above it.
#[derive(Clone, Copy)]
pub(super) struct Inherited<'a> {
    /// From the prim's space to the layer's, for columns.
    pub(super) world: DMat4,
    /// Whether it is to be seen: neither invisible nor a guide or proxy.
    pub(super) is_shown: bool,
    /// The path of its material.
    pub(super) material: Option<&'a str>,
    /// The path of its skeleton.
    pub(super) skeleton: Option<&'a str>,
}

/// All prims that are defined and active.
pub(super) struct Tree<'a> {
    /// Parents first.
    pub(super) prims: Vec<Placed<'a>>,
    by_path: HashMap<String, usize>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(layer: &'a Layer, values: &mut Values<'_>) -> Result<Self> {
        let at_root = Inherited { world: DMat4::IDENTITY, is_shown: true, material: None, skeleton: None };
        let mut prims = Vec::new();
        for prim in &layer.prims {
            add(prim, "", at_root, values, &mut prims)?;
        }
        let by_path = prims.iter().enumerate().map(|(i, placed)| (placed.path.clone(), i)).collect();
        Ok(Self { prims, by_path })
    }

    /// The prim at a path.
    pub(super) fn at(&self, path: &str) -> Option<&Placed<'a>> {
        self.by_path.get(path).map(|i| &self.prims[*i])
    }

    pub(super) fn of_type<'t>(&'t self, type_name: &'t str) -> impl Iterator<Item = &'t Placed<'a>> {
        self.prims.iter().filter(move |placed| placed.prim.type_name == type_name)
    }
}

/// Adds a prim and those below it. The reader of layers limits how deep they are.
fn add<'a>(
    prim: &'a Prim,
    parent: &str,
    above: Inherited<'a>,
    values: &mut Values<'_>,
    found: &mut Vec<Placed<'a>>,
) -> Result<()> {
    let is_active = field(&prim.metadata, "active") != Some(&Value::Bool(false));
    if prim.specifier != Specifier::Def || !is_active {
        return Ok(());
    }
    let path = format!("{parent}/{}", prim.name);
    let local = local(prim, &path, values)?;
    let is = |value: Option<Value>, words: &[&str]| match value {
        Some(Value::Token(word)) => words.contains(&word.as_str()),
        _ => false,
    };
    let is_hidden = is(values.get(prim, "visibility")?, &["invisible"])
        || is(values.get(prim, "purpose")?, &["guide", "proxy"]);
    let inherited = Inherited {
        world: if local.resets { local.matrix } else { above.world * local.matrix },
        is_shown: above.is_shown && !is_hidden,
        material: target(prim, "material:binding").or(above.material),
        skeleton: target(prim, "skel:skeleton").or(above.skeleton),
    };
    found.push(Placed { path: path.clone(), prim, inherited });
    for child in &prim.children {
        add(child, &path, inherited, values, found)?;
    }
    Ok(())
}

/// What the relationship `name` points to.
pub(super) fn targets<'a>(prim: &'a Prim, name: &str) -> &'a [String] {
    let of_name = |property: &'a Property| match property {
        Property::Relationship(relationship) if relationship.name == name => Some(&*relationship.targets),
        _ => None,
    };
    prim.properties.iter().find_map(of_name).unwrap_or_default()
}

/// The first of these.
pub(super) fn target<'a>(prim: &'a Prim, name: &str) -> Option<&'a str> {
    targets(prim, name).first().map(String::as_str)
}
