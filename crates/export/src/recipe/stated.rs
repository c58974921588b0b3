//! A recipe as a file states it.

use super::Recipe;
use rhytid_core::{Error, Result};
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};
use std::fmt;

/// A recipe as a file states it: fields by their names, including fields that a later version of this program
/// has written. Empty if the file states nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StatedRecipe(pub Vec<(String, Value)>);

impl StatedRecipe {
    /// The recipe of shapes, which belong to no take.
    pub fn of_shapes(rig: &str) -> Self {
        let Self(mut fields) = Self::from(&Recipe { rig: rig.into(), ..Recipe::default() });
        let of_takes = fields.iter_mut().filter(|(name, _)| ["missing", "head"].contains(&name.as_str()));
        of_takes.for_each(|(_, value)| *value = Value::String(String::new()));
        Self(fields)
    }

    /// The recipe.
    ///
    /// # Errors
    /// [`Error::Input`] if a field is missing, is unknown, or has a value that this program does not know.
    pub fn recipe(&self) -> Result<Recipe> {
        let parse = |fields: Map<String, Value>| serde_json::from_value::<Recipe>(Value::Object(fields));
        parse(self.0.iter().cloned().collect()).map_err(|error| {
            // Each field is tried alone in a recipe that is otherwise sound.
            let is_wrong = |(name, value): &&(String, Value)| {
                parse(Self::from(&Recipe::default()).with(name, value.clone()).0.into_iter().collect())
                    .is_err()
            };
            let what = match self.0.iter().find(is_wrong) {
                Some((name, value)) => format!("{name} = {value}"),
                None => error.to_string(),
            };
            Error::unsupported_version(format!(
                "was made with {what}, which this program does not know; export it again"
            ))
        })
    }

    /// A field.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }

    /// A field's text.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.get(name)?.as_str()
    }

    /// The same with another value of a field.
    #[must_use]
    pub fn with(mut self, name: &str, value: Value) -> Self {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some(field) => field.1 = value,
            None => self.0.push((name.to_owned(), value)),
        }
        self
    }

    /// The first field that differs in `other`: its name and both values as text. The fields `but_for` may
    /// differ.
    pub fn difference(&self, other: &Self, but_for: &[&str]) -> Option<[String; 3]> {
        let names = self.0.iter().chain(&other.0).map(|(name, _)| name.as_str());
        let shown = |value: Option<&Value>| match value {
            None => "none".to_owned(),
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
        };
        let differs = |name: &&str| !but_for.contains(name) && self.get(name) != other.get(name);
        let name = names.into_iter().find(differs)?;
        Some([name.to_owned(), shown(self.get(name)), shown(other.get(name))])
    }
}

impl From<&Recipe> for StatedRecipe {
    fn from(recipe: &Recipe) -> Self {
        // Through text, because text keeps the order of the fields.
        let json = serde_json::to_string(recipe);
        json.and_then(|json| serde_json::from_str(&json)).unwrap_or_default()
    }
}

impl Serialize for StatedRecipe {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'de> Deserialize<'de> for StatedRecipe {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        /// The entries of an object in the order in which they come.
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Vec<(String, Value)>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Self::Value, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(entries)
            }
        }
        deserializer.deserialize_map(InOrder).map(Self)
    }
}
