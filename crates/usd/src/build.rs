//! Short constructors for the parts of a layer.
use super::layer::{Attribute, Fields, Prim, Property, Relationship, Specifier, Value};

/// A prim that is defined here and has nothing yet.
pub(super) fn prim(type_name: &str, name: &str) -> Prim {
    Prim {
        specifier: Specifier::Def,
        type_name: type_name.into(),
        name: name.into(),
        metadata: Fields::new(),
        properties: Vec::new(),
        children: Vec::new(),
    }
}

/// An attribute that has a value, or none yet.
pub(super) fn attribute(type_name: &str, name: &str, default: Option<Value>) -> Attribute {
    Attribute {
        name: name.into(),
        type_name: type_name.into(),
        uniform: false,
        metadata: Fields::new(),
        default,
        connections: Vec::new(),
        samples: None,
    }
}

impl Prim {
    /// Adds an attribute.
    pub(super) fn push(&mut self, attribute: Attribute) {
        self.properties.push(Property::Attribute(attribute));
    }

    /// Adds an attribute that has a value.
    pub(super) fn set(&mut self, type_name: &str, name: &str, value: Value) {
        self.push(attribute(type_name, name, Some(value)));
    }

    /// Adds an attribute that has one value for all times.
    pub(super) fn set_uniform(&mut self, type_name: &str, name: &str, value: Value) {
        self.push(Attribute { uniform: true, ..attribute(type_name, name, Some(value)) });
    }

    /// Adds a relationship to the objects with these paths.
    pub(super) fn relate(&mut self, name: &str, targets: Vec<String>) {
        self.properties.push(Property::Relationship(Relationship { name: name.into(), targets }));
    }

    /// Says that an API schema is applied, after those that are applied already.
    pub(super) fn apply(&mut self, schema: &str) {
        for (name, value) in &mut self.metadata {
            if let ("apiSchemas", Value::PrependedTokens(applied)) = (name.as_str(), value) {
                applied.push(schema.into());
                return;
            }
        }
        self.metadata.push(("apiSchemas".into(), Value::PrependedTokens(vec![schema.into()])));
    }
}

/// A token.
pub(super) fn token(text: &str) -> Value {
    Value::Token(text.into())
}
