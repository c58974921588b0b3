//! The objects of a crate file, from its tables to a layer.

use super::structure::{Spec, Structure};
use super::value_rep::{ValueRep, kind};
use super::values::{Reader, Track};
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Relationship, Specifier, Value};
use crate::read::budget::MOST_PRIMS_DEEP;
use crate::read::opened::VARIANT_SET;
use rhytid_core::{Error, Result};
use std::collections::HashMap;

/// The layer, the tracks that its attributes number, and the names of what was left out.
pub(super) fn layer(reader: &mut Reader) -> Result<(Layer, Vec<Track>, Vec<String>)> {
    let objects = Objects::index(reader)?;
    let mut builder = Builder { reader, objects, tracks: Vec::new(), unread: Vec::new() };
    let Some(root) = builder.objects.root else {
        return Err(builder.reader.damaged("it has no root"));
    };
    let mut layer = Layer::default();
    let mut children = Vec::new();
    for (name, rep) in builder.fields(root)? {
        match name.as_str() {
            "primChildren" => children = builder.names(rep)?,
            _ => builder.field(&mut layer.metadata, name, rep)?,
        }
    }
    layer.prims = builder.prims(root.path, children, 0)?;
    Ok((layer, builder.tracks, builder.unread))
}

/// Which object is below which.
struct Objects {
    root: Option<Spec>,
    /// By the parent's path, the name and whether it is a property.
    below: HashMap<(u32, u32, bool), Spec>,
}

impl Objects {
    fn index(reader: &mut Reader) -> Result<Self> {
        let mut objects = Self { root: None, below: HashMap::new() };
        for spec in std::mem::take(&mut reader.structure.specs) {
            reader.spend(64)?;
            let Some(node) = reader.structure.paths.get(spec.path as usize).copied().flatten() else {
                return Err(
                    reader.damaged(format_args!("an object has the path {}, which is not there", spec.path))
                );
            };
            let before = match node.parent {
                None => objects.root.replace(spec),
                Some(parent) => objects.below.insert((parent, node.name, node.is_property), spec),
            };
            if before.is_some() {
                return Err(reader.damaged(format_args!("two objects have the path {}", spec.path)));
            }
        }
        objects.root = objects.root.filter(|root| root.kind == Spec::ROOT);
        Ok(objects)
    }
}

struct Builder<'a> {
    reader: &'a mut Reader,
    objects: Objects,
    tracks: Vec<Track>,
    /// What was left out, by name.
    unread: Vec<String>,
}

impl Builder<'_> {
    /// The names and values of an object.
    fn fields(&mut self, spec: Spec) -> Result<Vec<(String, ValueRep)>> {
        let mut fields = Vec::new();
        for at in spec.field_set as usize.. {
            let Structure { field_sets, fields: all, .. } = &self.reader.structure;
            match field_sets.get(at) {
                Some(&Structure::END_OF_SET) => break,
                Some(&index) if (index as usize) < all.len() => {
                    let field = all[index as usize];
                    fields.push((self.reader.owned_token(field.name)?, field.value));
                }
                _ => {
                    return Err(self
                        .reader
                        .damaged(format_args!("the fields of path {} have no end", spec.path)));
                }
            }
        }
        Ok(fields)
    }

    /// A list of names, as numbers of tokens.
    fn names(&mut self, rep: ValueRep) -> Result<Vec<u32>> {
        if rep.kind() != kind::TOKEN_VECTOR || rep.is_array() {
            return Err(self.reader.damaged(format_args!("a list of names has the type {}", rep.kind())));
        }
        self.reader.token_vector(rep)
    }

    /// Takes the object out, so that none is visited twice.
    fn take(&mut self, parent: u32, name: u32, is_property: bool) -> Result<Spec> {
        let found = self.objects.below.remove(&(parent, name, is_property));
        found.ok_or_else(|| match self.reader.token(name) {
            Ok(name) => {
                self.reader.damaged(format_args!("“{name}” is listed and not there, or listed twice"))
            }
            Err(error) => error,
        })
    }

    fn prims(&mut self, parent: u32, names: Vec<u32>, depth: usize) -> Result<Vec<Prim>> {
        if depth == MOST_PRIMS_DEEP && !names.is_empty() {
            return Err(self.reader.damaged(format_args!("it has prims more than {MOST_PRIMS_DEEP} deep")));
        }
        let mut prims = Vec::new();
        for name in names {
            let spec = self.take(parent, name, false)?;
            if spec.kind != Spec::PRIM {
                return Err(self.wrong_kind(spec, name));
            }
            prims.extend(self.prim(spec, name, depth)?);
        }
        Ok(prims)
    }

    /// A prim with all below; `None` for a class.
    fn prim(&mut self, spec: Spec, name: u32, depth: usize) -> Result<Option<Prim>> {
        let mut prim = Prim {
            specifier: Specifier::Over,
            type_name: String::new(),
            name: self.reader.owned_token(name)?,
            metadata: Vec::new(),
            properties: Vec::new(),
            children: Vec::new(),
        };
        let (mut children, mut is_class) = (Vec::new(), false);
        for (name, rep) in self.fields(spec)? {
            match (name.as_str(), rep.kind()) {
                ("specifier", kind::SPECIFIER) => match rep.inlined() {
                    0 => prim.specifier = Specifier::Def,
                    1 => prim.specifier = Specifier::Over,
                    _ => is_class = true,
                },
                ("typeName", kind::TOKEN) => prim.type_name = self.reader.owned_token(rep.inlined())?,
                ("primChildren", _) => children = self.names(rep)?,
                ("variantSetChildren", _) => {
                    for name in self.names(rep)? {
                        let name = self.reader.owned_token(name)?;
                        self.unread.push(format!("{VARIANT_SET} {name}"));
                    }
                }
                ("properties", _) => {
                    for name in self.names(rep)? {
                        let spec = self.take(spec.path, name, true)?;
                        prim.properties.push(self.property(spec, name)?);
                    }
                }
                _ => self.field(&mut prim.metadata, name, rep)?,
            }
        }
        prim.children = self.prims(spec.path, children, depth + 1)?;
        if is_class {
            self.unread.push(format!("the class {}", prim.name));
            return Ok(None);
        }
        Ok(Some(prim))
    }

    fn property(&mut self, spec: Spec, name: u32) -> Result<Property> {
        match spec.kind {
            Spec::ATTRIBUTE => Ok(Property::Attribute(self.attribute(spec, name)?)),
            Spec::RELATIONSHIP => Ok(Property::Relationship(self.relationship(spec, name)?)),
            _ => Err(self.wrong_kind(spec, name)),
        }
    }

    fn attribute(&mut self, spec: Spec, name: u32) -> Result<Attribute> {
        let mut attribute = Attribute {
            name: self.reader.owned_token(name)?,
            type_name: String::new(),
            uniform: false,
            metadata: Vec::new(),
            default: None,
            connections: Vec::new(),
            samples: None,
        };
        for (name, rep) in self.fields(spec)? {
            match (name.as_str(), rep.kind()) {
                ("typeName", kind::TOKEN) => attribute.type_name = self.reader.owned_token(rep.inlined())?,
                ("variability", kind::VARIABILITY) => attribute.uniform = rep.inlined() == 1,
                ("default", _) => {
                    attribute.default = self.reader.value(rep)?;
                    if attribute.default.is_none() {
                        self.unread.push(format!("the value of {}", attribute.name));
                    }
                }
                ("connectionPaths", kind::PATH_LIST_OP) => attribute.connections = self.paths(rep)?,
                ("timeSamples", kind::TIME_SAMPLES) => {
                    let track = self.reader.track(rep)?;
                    attribute.samples = Some(self.tracks.len());
                    self.tracks.push(track);
                }
                _ => self.metadata(&mut attribute.metadata, name, rep)?,
            }
        }
        Ok(attribute)
    }

    fn relationship(&mut self, spec: Spec, name: u32) -> Result<Relationship> {
        let mut relationship = Relationship { name: self.reader.owned_token(name)?, targets: Vec::new() };
        for (name, rep) in self.fields(spec)? {
            match name.as_str() {
                "targetPaths" if rep.kind() == kind::PATH_LIST_OP => {
                    relationship.targets = self.paths(rep)?;
                }
                // Lists of what the targets themselves have, and the fallbacks of other fields.
                "targetChildren" | "variability" | "custom" => {}
                _ => self.unread.push(format!("{}: {name}", relationship.name)),
            }
        }
        Ok(relationship)
    }

    fn paths(&mut self, rep: ValueRep) -> Result<Vec<String>> {
        let paths = self.reader.list_op(rep)?;
        paths.into_iter().map(|path| self.reader.path(path)).collect()
    }

    /// Adds a field.
    fn field(&mut self, fields: &mut Fields, name: String, rep: ValueRep) -> Result<()> {
        match self.reader.value(rep)? {
            Some(value) => fields.push((name, value)),
            None => self.unread.push(name),
        }
        Ok(())
    }

    /// Adds metadata, without what is no more than the fallback.
    fn metadata(&mut self, fields: &mut Fields, name: String, rep: ValueRep) -> Result<()> {
        // Lists of what the connections themselves have.
        if name == "connectionChildren" {
            return Ok(());
        }
        let before = fields.len();
        self.field(fields, name, rep)?;
        if fields[before..] == [("custom".to_owned(), Value::Bool(false))] {
            fields.pop();
        }
        Ok(())
    }

    fn wrong_kind(&self, spec: Spec, name: u32) -> Error {
        match self.reader.token(name) {
            Ok(name) => self.reader.damaged(format_args!("“{name}” is listed and of the kind {}", spec.kind)),
            Err(error) => error,
        }
    }
}
