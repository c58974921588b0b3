//! Which channels the frames of a recipe have.

use rhytid_core::ChannelKind;
use serde::de::{self, Deserialize, Deserializer};
use serde::{Serialize, Serializer};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The kinds of channels that frames have. By default those of [`ChannelKind::is_default`].
///
/// Files state the kinds that differ from the default, each as a yes or no under its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelChoice(BTreeSet<ChannelKind>);

impl Default for ChannelChoice {
    fn default() -> Self {
        Self(ChannelKind::ALL.into_iter().filter(|kind| kind.is_default()).collect())
    }
}

impl ChannelChoice {
    /// Positions alone.
    pub const NONE: Self = Self(BTreeSet::new());

    /// Whether frames have this kind.
    pub fn has(&self, kind: ChannelKind) -> bool {
        self.0.contains(&kind)
    }

    /// Adds this kind to the frames, or removes it.
    pub fn set(&mut self, kind: ChannelKind, yes: bool) {
        if yes {
            self.0.insert(kind)
        } else {
            self.0.remove(&kind)
        };
    }

    /// The same with this kind.
    #[must_use]
    pub fn with(mut self, kind: ChannelKind) -> Self {
        self.set(kind, true);
        self
    }

    /// The same without it.
    #[must_use]
    pub fn without(mut self, kind: ChannelKind) -> Self {
        self.set(kind, false);
        self
    }

    /// The kinds that frames have, in the order of [`ChannelKind::ALL`].
    pub fn kinds(&self) -> impl Iterator<Item = ChannelKind> + '_ {
        self.0.iter().copied()
    }
}

impl Serialize for ChannelChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let others = ChannelKind::ALL.into_iter().filter(|kind| self.has(*kind) != kind.is_default());
        serializer.collect_map(others.map(|kind| (kind.name(), self.has(kind))))
    }
}

impl<'de> Deserialize<'de> for ChannelChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let fields = BTreeMap::<String, Value>::deserialize(deserializer)?;
        let mut choice = Self::default();
        // serde flattens this choice: every field that is no other field of the recipe arrives here.
        for (name, value) in fields {
            match (ChannelKind::ALL.into_iter().find(|kind| kind.name() == name), value) {
                (Some(kind), Value::Bool(yes)) => choice.set(kind, yes),
                (_, value) => return Err(de::Error::custom(format!("{name} = {value}"))),
            }
        }
        Ok(choice)
    }
}
