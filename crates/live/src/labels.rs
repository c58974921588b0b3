//! Which handle a marker of the network belongs to, by the rules that also apply to files.

use crate::warnings::{About, Warnings};
use rhytid_core::text::{bare_label, label_prefix, quoted};
use std::collections::{BTreeMap, HashMap};

/// The most labels that are learned.
pub(crate) const MOST_LABELS: usize = 1_024;
/// The most actors whose markers are left out.
const MOST_ACTORS: usize = 16;
/// The most labels of no handle that are named.
const NAMED: usize = 3;

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
    /// The first labels that came and are no handle's.
    unknown: Vec<String>,
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
        let bound = vec![None; names.len()];
        Self { names: names.to_vec(), by_rule, bound, others: Vec::new(), unknown: Vec::new() }
    }

    /// Notes that a marker of this label comes.
    pub(crate) fn learn(&mut self, label: &str, warnings: &mut Warnings) {
        let Some((rule, handle)) = self.candidate(label) else {
            if self.unknown.len() < NAMED && !self.unknown.iter().any(|known| known == label) {
                self.unknown.push(label.to_owned());
            }
            return;
        };
        match &self.bound[handle] {
            Some((_, bound)) if bound == label => {}
            Some((known, _)) if *known < rule => {}
            Some((known, bound)) if *known == rule => {
                let actor = label_prefix(label).to_owned();
                let is_other_actor = rule == Rule::Bare && actor != label_prefix(bound);
                warnings.say(About::Names, || {
                    let (left_out, remedy) = match is_other_actor {
                        true => (format!("the markers of “{actor}” are"), "send those of one actor"),
                        false => ("the second is".to_owned(), "rename one of them"),
                    };
                    format!(
                        "the markers “{bound}” and “{label}” both have the name of the handle “{}”, so {left_out} \
                         left out; {remedy}",
                        self.names[handle]
                    )
                });
                if is_other_actor && self.others.len() < MOST_ACTORS {
                    self.leave_out(actor);
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

    /// What came where no marker is a handle's; `None` where one is, or where nothing came.
    fn unknown_words(&self) -> Option<String> {
        if self.unknown.is_empty() || self.bound.iter().any(Option::is_some) {
            return None;
        }
        let expected = self.names.iter().take(NAMED).map(|name| quoted(name)).collect::<Vec<_>>();
        Some(format!(
            "markers came with the labels {}, and none is a handle's, expected labels such as {}",
            self.unknown.iter().map(|label| quoted(label)).collect::<Vec<_>>().join(", "),
            expected.join(", ")
        ))
    }

    fn leave_out(&mut self, actor: String) {
        for bound in &mut self.bound {
            if bound.as_ref().is_some_and(|(rule, label)| *rule == Rule::Bare && label_prefix(label) == actor)
            {
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
                Rule::Bare if self.others.iter().any(|other| other == label_prefix(label)) => None,
                Rule::Bare => handles.get(&bare_label(label)),
            };
            if let Some(Some(handle)) = found {
                return Some((*rule, *handle));
            }
        }
        None
    }
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

    /// What came where no marker is a handle's, as a sentence without its full stop.
    pub(crate) fn unknown_words(&self) -> Option<String> {
        match self {
            Self::Handles(handles) => handles.unknown_words(),
            Self::All { .. } => None,
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
        for separator in [':', '|'] {
            let mut known = handles(&["chin", "brow"], &[]);
            let of = |actor: &str, name: &str| format!("{actor}{separator}{name}");
            let labels = [of("Anna", "chin"), of("Bert", "brow"), of("Bert", "chin"), of("Anna", "brow")];
            let (found, said) = found(&mut known, &labels.each_ref().map(String::as_str));
            assert_eq!(found, [Some(0), None, None, Some(1)]);
            let words = format!("of “Bert{separator}” are left out; send those of one actor");
            assert!(said.len() == 1 && said[0].contains(&words), "{said:?}");
        }
    }

    #[test]
    fn two_spellings_of_one_name_are_named() {
        let mut known = handles(&["Chin", "brow"], &[]);
        let (found, said) = found(&mut known, &["CHIN", "chin", "brow"]);
        assert_eq!(found, [Some(0), None, Some(1)]);
        assert!(said.len() == 1 && said[0].contains("so the second is left out; rename one"), "{said:?}");
    }

    #[test]
    fn handles_of_one_bare_name_are_not_guessed() {
        let mut known = handles(&["L:brow", "R:brow"], &[]);
        assert_eq!(found(&mut known, &["X:brow", "X:L:brow", "r:BROW"]).0, [None, None, Some(1)]);
    }
}
