//! Which handle a marker of the network belongs to, by the rules that also apply to files.

use crate::warnings::{About, Warnings};
use rhytid_core::text::bare_label;
use std::collections::{BTreeMap, HashMap};

/// The most labels that are learned.
pub(crate) const MOST_LABELS: usize = 1_024;
/// The most actors whose markers are left out.
const MOST_ACTORS: usize = 16;

/// How a marker's label is a handle's, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rule {
    /// It is the same, or the map says so.
    Same,
    /// It is the same in another case.
    Folded,
    /// It is the same behind a prefix.
    Bare,
}

/// The handles' labels.
#[derive(Debug)]
pub(crate) struct Handles {
    names: Vec<String>,
    /// The handle of each label, by rule. `None` where two handles have it.
    by_rule: [(Rule, HashMap<String, Option<usize>>); 3],
    /// H: the marker of each handle, once one has come.
    bound: Vec<Option<(Rule, String)>>,
    /// Prefixes of actors whose markers are left out.
    others: Vec<String>,
}

impl Handles {
    /// Handles of these names. `map` gives some of them a marker of another label.
    pub(crate) fn new(names: &[String], map: &BTreeMap<String, String>) -> Self {
        let of = |key: &dyn Fn(&str) -> String, is_same: bool| {
            let mut handles = HashMap::new();
            for (handle, name) in names.iter().enumerate() {
                let mapped = map.get(name);
                let label = match mapped {
                    Some(label) if is_same => label.clone(),
                    Some(_) => continue,
                    None => key(name),
                };
                handles.entry(label).and_modify(|known| *known = None).or_insert(Some(handle));
            }
            handles
        };
        let by_rule = [
            (Rule::Same, of(&str::to_owned, true)),
            (Rule::Folded, of(&str::to_lowercase, false)),
            (Rule::Bare, of(&bare_label, false)),
        ];
        Self { names: names.to_vec(), by_rule, bound: vec![None; names.len()], others: Vec::new() }
    }

    /// Notes that a marker of this label comes.
    pub(crate) fn learn(&mut self, label: &str, warnings: &mut Warnings) {
        let Some((rule, handle)) = self.candidate(label) else { return };
        match &self.bound[handle] {
            Some((_, bound)) if bound == label => {}
            Some((known, _)) if *known < rule => {}
            Some((known, bound)) if *known == rule => {
                let bound = bound.clone();
                warnings.say(About::Names, || {
                    format!(
                        "the markers “{bound}” and “{label}” both have the name of the handle “{}”, so the \
                         markers of “{}” are left out; send those of one actor, or give a map of handles to markers",
                        self.names[handle],
                        prefix(label)
                    )
                });
                if rule == Rule::Bare && prefix(label) != prefix(&bound) && self.others.len() < MOST_ACTORS {
                    self.leave_out(prefix(label).to_owned());
                }
            }
            _ => self.bound[handle] = Some((rule, label.to_owned())),
        }
    }

    /// The handle of a marker; `None` where it has none, or where another marker is the handle's.
    pub(crate) fn handle(&self, label: &str) -> Option<usize> {
        let (_, handle) = self.candidate(label)?;
        self.bound[handle].as_ref().is_some_and(|(_, bound)| bound == label).then_some(handle)
    }

    fn leave_out(&mut self, actor: String) {
        for bound in &mut self.bound {
            if bound.as_ref().is_some_and(|(rule, label)| *rule == Rule::Bare && prefix(label) == actor) {
                *bound = None;
            }
        }
        self.others.push(actor);
    }

    fn candidate(&self, label: &str) -> Option<(Rule, usize)> {
        for (rule, handles) in &self.by_rule {
            let found = match rule {
                Rule::Same => handles.get(label),
                Rule::Folded => handles.get(&label.trim().to_lowercase()),
                Rule::Bare if self.others.iter().any(|other| other == prefix(label)) => None,
                Rule::Bare => handles.get(&bare_label(label)),
            };
            if let Some(Some(handle)) = found {
                return Some((*rule, *handle));
            }
        }
        None
    }
}

/// What stands before the bare label, such as `Anna:`.
fn prefix(label: &str) -> &str {
    label.rfind(':').map_or("", |at| &label[..=at])
}

/// The markers of a stream.
#[derive(Debug)]
pub(crate) enum Labels {
    /// Only a rig's handles.
    Handles(Handles),
    /// All markers, under their own labels.
    All { names: Vec<String>, index: HashMap<String, usize> },
}

impl Labels {
    /// The markers' names.
    pub(crate) fn names(&self) -> &[String] {
        match self {
            Self::Handles(handles) => &handles.names,
            Self::All { names, .. } => names,
        }
    }

    /// Notes that a marker of this label comes. Another marker is learned only where `may_grow`.
    pub(crate) fn learn(&mut self, label: &str, may_grow: bool, warnings: &mut Warnings) {
        match self {
            Self::Handles(handles) => handles.learn(label, warnings),
            Self::All { names, index } if !index.contains_key(label) => {
                if !may_grow || names.len() == MOST_LABELS {
                    warnings.say(About::TooManyMarkers, || {
                        format!(
                            "the marker “{label}” is left out: only markers of the first seconds are \
                             recorded, and at most {MOST_LABELS}; show every marker when the recording begins"
                        )
                    });
                    return;
                }
                index.insert(label.to_owned(), names.len());
                names.push(label.to_owned());
            }
            Self::All { .. } => {}
        }
    }

    /// The place of a marker among the names.
    pub(crate) fn place(&self, label: &str) -> Option<usize> {
        match self {
            Self::Handles(handles) => handles.handle(label),
            Self::All { index, .. } => index.get(label).copied(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn handles(names: &[&str], map: &[(&str, &str)]) -> Handles {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        Handles::new(&names, &map.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect())
    }

    /// The handles of markers that come, in this order.
    fn found(handles: &mut Handles, labels: &[&str]) -> (Vec<Option<usize>>, Vec<String>) {
        let mut warnings = Warnings::default();
        labels.iter().for_each(|label| handles.learn(label, &mut warnings));
        (labels.iter().map(|label| handles.handle(label)).collect(), warnings.sentences)
    }

    #[test]
    fn the_rules_of_files_in_their_order() {
        let mut known = handles(&["jaw", "Lip", "brow", "nose", "chin", "ear"], &[("chin", "m7")]);
        let (found, said) =
            found(&mut known, &["Actor:jaw", "jaw", "lip", "Anna:Head:Brow", "NOSE", "m7", "cap", "chin"]);
        assert_eq!(found, [None, Some(0), Some(1), Some(2), Some(3), Some(4), None, None]);
        assert!(said.is_empty(), "{said:?}");
    }

    #[test]
    fn two_actors_are_not_mixed() {
        let mut known = handles(&["chin", "brow"], &[]);
        let (found, said) = found(&mut known, &["Anna:chin", "Bert:brow", "Bert:chin", "Anna:brow"]);
        assert_eq!(found, [Some(0), None, None, Some(1)]);
        assert!(said.len() == 1 && said[0].contains("of “Bert:” are left out"), "{said:?}");
    }

    #[test]
    fn handles_of_one_bare_name_are_not_guessed() {
        let mut known = handles(&["L:brow", "R:brow"], &[]);
        assert_eq!(found(&mut known, &["X:brow", "X:L:brow", "r:BROW"]).0, [None, None, Some(1)]);
    }
}
