//! The grammar of USD text, as far as layers have it that Rhytid or USD's own tools wrote.

use super::bytes::Place;
use super::lexer::{Lexer, Next};
use super::values;
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Relationship, Specifier, Value};
use crate::read::budget::MOST_PRIMS_DEEP;
use crate::read::opened::VARIANT_SET;
use rhytid_core::Result;
use std::collections::HashMap;

/// Where the time samples of an attribute are.
pub(super) struct Track {
    /// USD's name of the type.
    pub(super) type_name: String,
    pub(super) times: Vec<f64>,
    /// Where each value begins.
    pub(super) values: Vec<Place>,
}

/// Reads a layer from its first byte to its last.
pub(super) struct Parser {
    pub(super) lexer: Lexer,
    pub(super) tracks: Vec<Track>,
    /// What was left out, by name.
    pub(super) unread: Vec<String>,
}

impl Parser {
    pub(super) fn layer(&mut self) -> Result<Layer> {
        let mut layer = Layer::default();
        if self.lexer.next()? == Next::Mark(b'(') {
            layer.metadata = self.metadata()?;
        }
        while self.lexer.next()? != Next::End {
            let keyword = self.lexer.word("def, over or class")?;
            match keyword.as_str() {
                "def" | "over" | "class" => layer.prims.extend(self.prim(&keyword, 0)?),
                "reorder" => self.reorder()?,
                _ => return Err(self.unexpected(&keyword, "def, over or class")),
            }
        }
        Ok(layer)
    }

    /// Behind `def`, `over` or `class`; `None` for a class.
    fn prim(&mut self, keyword: &str, depth: usize) -> Result<Option<Prim>> {
        if depth == MOST_PRIMS_DEEP {
            return Err(self.lexer.wrong(format_args!(
                "prims are more than {MOST_PRIMS_DEEP} deep; the file is damaged, export it again"
            )));
        }
        let type_name = match self.lexer.next()? {
            Next::Quoted => String::new(),
            _ => self.lexer.word("a prim's type or its name in quotes")?,
        };
        let name = self.lexer.quoted()?;
        let metadata = if self.lexer.next()? == Next::Mark(b'(') { self.metadata()? } else { Vec::new() };
        let specifier = if keyword == "def" { Specifier::Def } else { Specifier::Over };
        let mut prim =
            Prim { specifier, type_name, name, metadata, properties: Vec::new(), children: Vec::new() };
        let mut places = HashMap::new();
        self.lexer.expect(b'{')?;
        while !self.lexer.accept(b'}')? {
            let keyword = self.lexer.word("a property, a prim or “}”")?;
            match keyword.as_str() {
                "def" | "over" | "class" => prim.children.extend(self.prim(&keyword, depth + 1)?),
                "reorder" => self.reorder()?,
                "variantSet" => {
                    let name = self.lexer.quoted()?;
                    self.unread.push(format!("{VARIANT_SET} {name}"));
                    self.lexer.expect(b'=')?;
                    self.skip_variants()?;
                }
                _ => self.property(keyword, &mut prim.properties, &mut places)?,
            }
            while self.lexer.accept(b';')? {}
        }
        if keyword == "class" {
            self.unread.push(format!("the class {}", prim.name));
            return Ok(None);
        }
        Ok(Some(prim))
    }

    /// `reorder nameChildren = […]` and the like.
    fn reorder(&mut self) -> Result<()> {
        self.lexer.word("what is reordered")?;
        self.lexer.expect(b'=')?;
        self.lexer.skip_value()
    }

    /// `{ "name" (metadata) { … } … }`, whose content may be anything that a prim has.
    fn skip_variants(&mut self) -> Result<()> {
        self.lexer.skip_value()
    }

    /// Between brackets: `name = value`, with the kind of list operation before it, or a comment in quotes.
    fn metadata(&mut self) -> Result<Fields> {
        self.lexer.expect(b'(')?;
        let mut fields = Vec::new();
        while !self.lexer.accept(b')')? {
            if self.lexer.next()? == Next::Quoted {
                fields.push(("comment".to_owned(), Value::String(self.lexer.quoted()?)));
                continue;
            }
            let mut name = self.lexer.word("the name of a field")?;
            let operation = is_list_operation(&name).then(|| name.clone());
            if operation.is_some() {
                name = self.lexer.word("the name of a field")?;
            }
            self.lexer.expect(b'=')?;
            let value = match (operation.as_deref(), name.as_str()) {
                (Some("delete" | "reorder"), _) => {
                    self.lexer.skip_value()?;
                    None
                }
                (_, "payload" | "inherits" | "specializes") => {
                    values::references(&mut self.lexer)?;
                    // As the format's library calls it in all other files.
                    if name == "inherits" {
                        name = "inheritPaths".to_owned();
                    }
                    None
                }
                (_, "apiSchemas") => Some(Value::PrependedTokens(values::tokens(&mut self.lexer)?)),
                (_, "references") => Some(Value::PrependedReferences(values::references(&mut self.lexer)?)),
                (Some(_), _) | (None, "variants") => {
                    self.lexer.skip_value()?;
                    None
                }
                // As the format's library calls it in all other files.
                (None, "doc") => {
                    name = "documentation".to_owned();
                    Some(Value::String(self.lexer.quoted()?))
                }
                (None, _) => values::metadata(&mut self.lexer, &name)?,
            };
            match value {
                Some(value) => fields.push((name, value)),
                None => self.unread.push(name),
            }
            while self.lexer.accept(b';')? {}
        }
        Ok(fields)
    }

    /// A property whose first word was read. It may add to one of the `properties` that came before, which
    /// are found by their `places`, as `.timeSamples` does.
    fn property(
        &mut self,
        first: String,
        properties: &mut Vec<Property>,
        places: &mut HashMap<String, usize>,
    ) -> Result<()> {
        let (mut word, mut is_custom, mut is_uniform, mut is_left_out) = (first, false, false, false);
        loop {
            match word.as_str() {
                "custom" => is_custom = true,
                "uniform" => is_uniform = true,
                "varying" | "config" => {}
                "delete" | "reorder" => is_left_out = true,
                operation if is_list_operation(operation) => {}
                _ => break,
            }
            word = self.lexer.word("a type")?;
        }
        let found = match word.as_str() {
            "rel" => Property::Relationship(self.relationship()?),
            _ => {
                let mut attribute = self.attribute(word)?;
                attribute.uniform = is_uniform;
                if is_custom {
                    attribute.metadata.push(("custom".to_owned(), Value::Bool(true)));
                }
                Property::Attribute(attribute)
            }
        };
        if is_left_out {
            self.unread.push(format!("what is taken from {}", found.name()));
            return Ok(());
        }
        let place = *places.entry(found.name().to_owned()).or_insert(properties.len());
        match (properties.get_mut(place), found) {
            (None, found) => properties.push(found),
            (Some(Property::Attribute(before)), Property::Attribute(found)) => {
                if before.default.is_some() && found.default.is_some() {
                    self.unread.push(format!("a second value of {}", found.name));
                }
                add(before, found);
            }
            (Some(Property::Relationship(before)), Property::Relationship(found)) => {
                before.targets.extend(found.targets);
            }
            (Some(before), _) => {
                return Err(self.lexer.wrong(format_args!(
                    "“{}” is an attribute and a relationship; the file is damaged, export it again",
                    before.name()
                )));
            }
        }
        Ok(())
    }

    /// Behind the first word of an attribute's type.
    fn attribute(&mut self, mut type_name: String) -> Result<Attribute> {
        if self.lexer.accept(b'[')? {
            self.lexer.expect(b']')?;
            type_name.push_str("[]");
        }
        let name = self.lexer.word("the name of an attribute")?;
        // Names have no points. The text behind a point says which part of the attribute is set.
        let (name, part) = name.split_once('.').unwrap_or((&name, ""));
        let mut attribute = Attribute {
            name: name.to_owned(),
            type_name,
            uniform: false,
            metadata: Vec::new(),
            default: None,
            connections: Vec::new(),
            samples: None,
        };
        if self.lexer.accept(b'=')? {
            match part {
                "" => {
                    attribute.default = values::value(&mut self.lexer, &attribute.type_name)?;
                    if attribute.default.is_none() {
                        self.unread.push(format!("the value of {}", attribute.name));
                    }
                }
                "timeSamples" => attribute.samples = Some(self.samples(&attribute.type_name)?),
                "connect" => attribute.connections = values::paths(&mut self.lexer)?,
                _ => {
                    self.unread.push(format!("{}.{part}", attribute.name));
                    self.lexer.skip_value()?;
                }
            }
        }
        if self.lexer.next()? == Next::Mark(b'(') {
            attribute.metadata = self.metadata()?;
        }
        Ok(attribute)
    }

    /// Behind `rel`.
    fn relationship(&mut self) -> Result<Relationship> {
        let name = self.lexer.word("the name of a relationship")?;
        let targets = if self.lexer.accept(b'=')? { values::paths(&mut self.lexer)? } else { Vec::new() };
        if self.lexer.next()? == Next::Mark(b'(') {
            let fields = self.metadata()?;
            self.unread.extend(fields.into_iter().map(|(field, _)| format!("{name}: {field}")));
        }
        Ok(Relationship { name, targets })
    }

    /// `{ time: value, … }`. Values are passed, and read when they are wanted.
    fn samples(&mut self, type_name: &str) -> Result<usize> {
        let mut track = Track { type_name: type_name.to_owned(), times: Vec::new(), values: Vec::new() };
        self.lexer.expect(b'{')?;
        while !self.lexer.accept(b'}')? {
            let time = self.lexer.number()?;
            if track.times.last().is_some_and(|&last| last >= time) || time.is_nan() {
                return Err(self.lexer.wrong(format_args!(
                    "time code {time} does not ascend from the one before; the file is damaged, export it again"
                )));
            }
            self.lexer.expect(b':')?;
            track.times.push(time);
            track.values.push(self.lexer.place()?);
            self.lexer.skip_value()?;
            if !self.lexer.accept(b',')? {
                self.lexer.expect(b'}')?;
                break;
            }
        }
        self.tracks.push(track);
        Ok(self.tracks.len() - 1)
    }

    fn unexpected(&self, found: &str, expected: &str) -> rhytid_core::Error {
        self.lexer
            .wrong(format_args!("found “{found}”, expected {expected}; the file is damaged, export it again"))
    }
}

fn is_list_operation(word: &str) -> bool {
    matches!(word, "prepend" | "append" | "add" | "delete" | "reorder")
}

/// Adds to an attribute what another statement says of it.
fn add(before: &mut Attribute, found: Attribute) {
    before.default = found.default.or(before.default.take());
    before.samples = found.samples.or(before.samples);
    before.connections.extend(found.connections);
    for (name, value) in found.metadata {
        if before.metadata.iter().all(|(known, _)| *known != name) {
            before.metadata.push((name, value));
        }
    }
}
