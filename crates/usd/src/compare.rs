//! The differences between a layer that was read and the one that an export writes: every prim, property,
//! value and field. Time samples are compared elsewhere, frame by frame.

use super::layer::{Attribute, Fields, Layer, Prim, Property, Relationship, Value};
use rhytid_core::text::quoted;
use std::collections::HashSet;

/// Fields that people and pipelines add. They change nothing that is shown.
const NOTES: [&str; 5] = ["comment", "documentation", "customData", "customLayerData", "displayName"];

/// Numbers of normals may differ by this much, since devices round differently. A thousandth of them may
/// differ by more, at thin triangles.
const OF_NORMALS: f32 = 2e-3;

/// The differences, each as a place and what is there. `unread` names what the reader has left out.
pub(crate) fn differences(found: &Layer, unread: &[String], expected: &Layer) -> Vec<String> {
    let mut differences = Differences::default();
    unread.iter().for_each(|what| differences.add(what, "is there, expected none"));
    differences.fields("the layer", &found.metadata, &expected.metadata);
    differences.prims("", &found.prims, &expected.prims);
    differences.0
}

#[derive(Default)]
struct Differences(Vec<String>);

impl Differences {
    fn add(&mut self, place: &str, what: &str) {
        self.0.push(format!("{place}: {what}"));
    }

    /// What is of one name in `found` and in `expected`, and the names that only one of them has.
    fn pairs<'a, T>(
        &mut self,
        (found, expected): (&'a [T], &'a [T]),
        name: impl Fn(&T) -> &str,
        place: impl Fn(&str) -> String,
    ) -> Vec<(&'a T, &'a T)> {
        let mut pairs = Vec::new();
        for item in expected {
            match found.iter().find(|other| name(other) == name(item)) {
                Some(other) => pairs.push((other, item)),
                None => self.add(&place(name(item)), "is missing"),
            }
        }
        let is_unknown = |item: &&T| expected.iter().all(|other| name(other) != name(item));
        for item in found.iter().filter(is_unknown) {
            self.add(&place(name(item)), "is there, expected none");
        }
        let mut seen = HashSet::new();
        for item in found.iter().filter(|item| !seen.insert(name(item))) {
            self.add(&place(name(item)), "is there twice");
        }
        pairs
    }

    fn fields(&mut self, place: &str, found: &Fields, expected: &Fields) {
        let without_notes = |fields: &Fields| -> Fields {
            fields.iter().filter(|(name, _)| !NOTES.contains(&name.as_str())).cloned().collect()
        };
        let (found, expected) = (without_notes(found), without_notes(expected));
        let pairs = self.pairs((&found, &expected), |(name, _)| name, |name| format!("{place}: {name}"));
        for ((name, found), (_, expected)) in pairs {
            if !is_same(name, found, expected) {
                self.add(&format!("{place}: {name}"), &differs(found, expected));
            }
        }
    }

    fn prims(&mut self, place: &str, found: &[Prim], expected: &[Prim]) {
        let pairs = self.pairs((found, expected), |prim| &prim.name, |name| format!("{place}/{name}"));
        for (found, expected) in pairs {
            let place = format!("{place}/{}", found.name);
            if (found.specifier, &found.type_name) != (expected.specifier, &expected.type_name) {
                let what = format!(
                    "is {:?} {}, expected {:?} {}",
                    found.specifier, found.type_name, expected.specifier, expected.type_name
                );
                self.add(&place, &what);
            }
            self.fields(&place, &found.metadata, &expected.metadata);
            let properties = (&*found.properties, &*expected.properties);
            for (found, expected) in self.pairs(properties, Property::name, |name| format!("{place}.{name}"))
            {
                self.property(&format!("{place}.{}", found.name()), found, expected);
            }
            self.prims(&place, &found.children, &expected.children);
        }
    }

    fn property(&mut self, place: &str, found: &Property, expected: &Property) {
        match (found, expected) {
            (Property::Attribute(found), Property::Attribute(expected)) => {
                self.attribute(place, found, expected);
            }
            (Property::Relationship(found), Property::Relationship(expected)) => {
                self.relationship(place, found, expected);
            }
            (Property::Attribute(_), _) => self.add(place, "is an attribute, expected a relationship"),
            (Property::Relationship(_), _) => self.add(place, "is a relationship, expected an attribute"),
        }
    }

    fn attribute(&mut self, place: &str, found: &Attribute, expected: &Attribute) {
        if found.type_name != expected.type_name {
            self.add(place, &format!("has the type {}, expected {}", found.type_name, expected.type_name));
        }
        if found.uniform != expected.uniform {
            self.add(place, if found.uniform { "is uniform" } else { "is not uniform" });
        }
        match (found.samples.is_some(), expected.samples.is_some()) {
            (true, false) => self.add(place, "has time samples, expected none"),
            (false, true) => self.add(place, "has no time samples"),
            _ => {}
        }
        if found.connections != expected.connections {
            self.add(place, "is connected to something else");
        }
        match (&found.default, &expected.default) {
            (None, None) => {}
            (Some(_), None) => self.add(place, "has a value without a time, expected none"),
            (None, Some(_)) => self.add(place, "has no value without a time"),
            (Some(found), Some(expected)) if is_same(&expected_name(place), found, expected) => {}
            (Some(found), Some(expected)) => self.add(place, &differs(found, expected)),
        }
        self.fields(place, &found.metadata, &expected.metadata);
    }

    fn relationship(&mut self, place: &str, found: &Relationship, expected: &Relationship) {
        if found.targets != expected.targets {
            self.add(place, "points to something else");
        }
    }
}

/// The property's name in `/prim/prim.name`.
fn expected_name(place: &str) -> String {
    place.rsplit_once('.').map_or(place, |(_, name)| name).to_owned()
}

/// Whether two values are the same; normals to rounding.
fn is_same(name: &str, found: &Value, expected: &Value) -> bool {
    match (found, expected) {
        (Value::Float3s(found), Value::Float3s(expected)) if name == "normals" => {
            let is_off = |(a, b): (&[f32; 3], &[f32; 3])| {
                let apart = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
                apart.is_nan() || apart > OF_NORMALS
            };
            let off = found.iter().zip(expected).filter(|pair| is_off(*pair)).count();
            found.len() == expected.len() && off * 1000 <= expected.len()
        }
        _ => found == expected,
    }
}

/// Both values, if they are short.
fn differs(found: &Value, expected: &Value) -> String {
    let words = |value: &Value| match value {
        Value::Bool(x) => Some(x.to_string()),
        Value::Int(x) => Some(x.to_string()),
        Value::Float(x) => Some(x.to_string()),
        Value::Double(x) => Some(x.to_string()),
        Value::String(text) | Value::Token(text) | Value::Asset(text) => Some(quoted(text)),
        Value::Tokens(texts) if texts.len() < 8 => Some(quoted(&texts.join(", "))),
        _ => None,
    };
    match (words(found), words(expected)) {
        (Some(found), Some(expected)) => format!("is {found}, expected {expected}"),
        _ => "has other numbers".to_owned(),
    }
}
