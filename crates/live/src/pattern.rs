//! Which messages have the markers' positions.

use crate::part::HANDLE;
use std::fmt;
use std::str::FromStr;

/// Where the label stands in an address pattern.
const LABEL: &str = "{label}";

/// The address of the messages that have a marker's position.
///
/// With `{label}` in it, such as `/marker/{label}`, the label is in the address, and the arguments are X, Y
/// and Z. Without it, such as `/VMC/Ext/Tra/Pos`, the arguments are the label, X, Y and Z. Further arguments
/// are ignored. A label in an address has no `/` in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// The address up to the label, or all of it.
    before: String,
    /// What follows the label; `None` where the label is the first argument.
    after: Option<String>,
}

impl Default for Pattern {
    /// `/rhytid/handle`
    fn default() -> Self {
        Self { before: HANDLE.to_owned(), after: None }
    }
}

impl FromStr for Pattern {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (before, after) = match text.split_once(LABEL) {
            Some((before, after)) => (before, Some(after)),
            None => (text, None),
        };
        let is_word =
            |part: &str| part.chars().all(|c| !c.is_whitespace() && !c.is_control() && c != '{' && c != '}');
        if !before.starts_with('/') || before.len() > 200 || !is_word(before) || !after.is_none_or(is_word) {
            return Err(format!(
                "expected an OSC address such as /marker/{LABEL} with the arguments X Y Z, or /marker with \
                 the arguments LABEL X Y Z"
            ));
        }
        Ok(Self { before: before.to_owned(), after: after.map(str::to_owned) })
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.after {
            Some(after) => write!(f, "{}{LABEL}{after}", self.before),
            None => f.write_str(&self.before),
        }
    }
}

/// A message's address in the view of a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fits<'a> {
    /// The label is in the address.
    Label(&'a str),
    /// The label is the first argument.
    LabelledByArgument,
    /// It is the address of another message.
    No,
}

impl Pattern {
    /// Whether the frames have no number and no time of their own.
    pub(crate) fn is_foreign(&self) -> bool {
        *self != Self::default()
    }

    /// What the address says.
    pub(crate) fn fits<'a>(&self, address: &'a str) -> Fits<'a> {
        let Some(after) = &self.after else {
            return if address == self.before { Fits::LabelledByArgument } else { Fits::No };
        };
        let label = address.strip_prefix(&*self.before).and_then(|rest| rest.strip_suffix(&**after));
        match label {
            Some(label) if !label.is_empty() && !label.contains('/') => Fits::Label(label),
            _ => Fits::No,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_stand_in_addresses_or_behind_them() {
        let pattern = |text: &str| text.parse::<Pattern>().unwrap();
        assert_eq!(pattern("/marker/{label}").fits("/marker/chin"), Fits::Label("chin"));
        assert_eq!(pattern("/a/{label}/position").fits("/a/Anna:chin/position"), Fits::Label("Anna:chin"));
        for (text, address) in [
            ("/marker/{label}", "/marker/"),
            ("/marker/{label}", "/marker/chin/confidence"),
            ("/marker/{label}", "/other/chin"),
            ("/a/{label}/position", "/a/position"),
            ("/VMC/Ext/Tra/Pos", "/VMC/Ext/Tra/Pos/Local"),
        ] {
            assert_eq!(pattern(text).fits(address), Fits::No, "{text} {address}");
        }
        assert_eq!(pattern("/VMC/Ext/Tra/Pos").fits("/VMC/Ext/Tra/Pos"), Fits::LabelledByArgument);
        for text in ["/marker/{label}", "/a/{label}/position", "/VMC/Ext/Tra/Pos"] {
            assert_eq!(pattern(text).to_string(), text);
        }
        for text in ["", "marker", "{label}", "/a b", "/{label}/{label}", "/{name}"] {
            assert!(text.parse::<Pattern>().is_err(), "{text}");
        }
    }
}
