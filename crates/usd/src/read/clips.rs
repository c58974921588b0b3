//! Reads value clips: the other files that a layer takes its samples from, and the content that their
//! manifest has to declare.

use super::lookup::{default_prim, dictionary, field};
use crate::build::{attribute, prim};
use crate::layer::{Attribute, Layer, Prim, Property, Specifier, Value};

/// The files that a layer takes its samples from, relative to its own.
pub(crate) struct Clips<'a> {
    /// In the order of their time codes.
    pub(crate) assets: &'a [String],
    /// What has samples in them.
    pub(crate) manifest: &'a str,
}

/// The clips of the layer's default prim; `None` if it has none.
pub(crate) fn clips(layer: &Layer) -> Option<Clips<'_>> {
    let set = dictionary(dictionary(&default_prim(layer)?.metadata, "clips")?, "default")?;
    match (field(set, "assetPaths")?, field(set, "manifestAssetPath")?) {
        (Value::Assets(assets), Value::Asset(manifest)) => Some(Clips { assets, manifest }),
        _ => None,
    }
}

/// The path of an object that has samples in the clip `clip` and is not in `manifest`; `None` if there is
/// none. USD does not play such samples.
pub(super) fn undeclared(clip: &Layer, manifest: &Layer) -> Option<String> {
    fn within(wanted: &Prim, among: &[Prim]) -> Option<String> {
        let name = &wanted.name;
        let Some(found) = among.iter().find(|prim| prim.name == *name) else {
            return Some(format!("/{name}"));
        };
        let lacks = |wanted: &&Property| found.properties.iter().all(|found| found.name() != wanted.name());
        match wanted.properties.iter().find(lacks) {
            Some(property) => Some(format!("/{name}.{}", property.name())),
            None => {
                let below = wanted.children.iter().find_map(|child| within(child, &found.children));
                below.map(|path| format!("/{name}{path}"))
            }
        }
    }
    within(&declarations(default_prim(clip)?)?, &manifest.prims)
}

/// The prims and attributes with samples in `animated` and below, by name and type alone; `None` if nothing
/// has samples.
pub(crate) fn declarations(animated: &Prim) -> Option<Prim> {
    let declare = |property: &Property| match property {
        Property::Attribute(Attribute { name, type_name, samples: Some(_), .. }) => {
            Some(Property::Attribute(attribute(type_name, name, None)))
        }
        _ => None,
    };
    let properties: Vec<Property> = animated.properties.iter().filter_map(declare).collect();
    let children: Vec<Prim> = animated.children.iter().filter_map(declarations).collect();
    let some = !properties.is_empty() || !children.is_empty();
    some.then(|| Prim { specifier: Specifier::Over, properties, children, ..prim("", &animated.name) })
}
