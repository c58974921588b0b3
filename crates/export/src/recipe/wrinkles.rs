//! What a recipe says of wrinkles: gains, and groups of examples.

use std::fmt;
use std::str::FromStr;

/// Gains of the wrinkles by handle or region; in files as `brows=0.5;chin=1.2`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gains(pub Vec<(String, f64)>);

impl Gains {
    /// Whether nothing is multiplied.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl fmt::Display for Gains {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let gains: Vec<String> = self.0.iter().map(|(region, gain)| format!("{region}={gain}")).collect();
        f.write_str(&gains.join(";"))
    }
}

impl FromStr for Gains {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let gain = |part: &str| {
            let (region, gain) = part.rsplit_once('=')?;
            let gain: f64 = gain.parse().ok()?;
            (!region.is_empty() && gain.is_finite()).then(|| (region.to_owned(), gain))
        };
        let expected =
            || format!("“{text}” is no list of regions and gains, expected such as brows=0.5;chin=1.2");
        text.split(';').map(gain).collect::<Option<_>>().map(Self).ok_or_else(expected)
    }
}

/// Examples whose wrinkles are switched on together; in files as `brows=frown+raise;mouth=smile`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WrinkleGroups(pub Vec<WrinkleGroup>);

/// Examples whose wrinkles are one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct WrinkleGroup {
    /// What the channel is called.
    pub name: String,
    /// The examples' names, at least one.
    pub examples: Vec<String>,
}

impl WrinkleGroups {
    /// Whether each example is by itself.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl fmt::Display for WrinkleGroup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name, self.examples.join("+"))
    }
}

impl FromStr for WrinkleGroup {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').map(|(name, examples)| {
            let examples: Vec<String> = examples.split('+').map(str::to_owned).collect();
            Self { name: name.to_owned(), examples }
        });
        let is_sound =
            |group: &Self| !group.name.is_empty() && group.examples.iter().all(|name| !name.is_empty());
        parts.filter(is_sound).ok_or_else(|| {
            "expected a name and the examples of the group, such as brows=frown+raise".to_owned()
        })
    }
}

impl fmt::Display for WrinkleGroups {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let groups: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&groups.join(";"))
    }
}

impl FromStr for WrinkleGroups {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split(';').map(str::parse).collect::<Result<_, _>>().map(Self)
    }
}
