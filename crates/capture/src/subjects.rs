//! Subjects: the actors and props of a take. The prefixes of the labels tell them apart, such as `Anna:` in
//! `Anna:jaw00`.
use rhytid_core::text::{LABEL_SEPARATORS, bare_label, listed, quoted};
use rhytid_core::{Error, InputErrorKind, Remedy, Result};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Between a subject and a label where half of the handles' names stand behind the same prefix.
const SOMETIMES: [char; 5] = ['_', '.', '-', ' ', '/'];

/// A separator is looked for among so many letters.
const LONGEST_PREFIX: usize = 64;

/// A subject with a smaller part of the best subject's handles is no rival of it.
const RIVAL: f64 = 0.5;

/// A subject whose labels are the handles' own has at least this part of the best subject's handles.
const AS_GOOD: f64 = 0.9;

/// A label in two parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Label {
    /// The subject's name, as the file has it. `#2` for the second marker of a label that comes twice. `None`
    /// without a prefix.
    pub subject: Option<String>,
    /// The marker's name without the prefix, in lower case.
    pub name: String,
}

/// Whether a subject has this name. Upper and lower case do not matter, nor a colon behind the name.
pub(crate) fn is_called(subject: &str, name: &str) -> bool {
    subject.to_lowercase() == name.trim().trim_end_matches(LABEL_SEPARATORS).to_lowercase()
}

/// The labels of a `file` in their parts, for these `handles`.
pub(crate) fn parted(handles: &[String], file: &[String]) -> Vec<Label> {
    let names: HashSet<String> = handles.iter().map(|handle| bare_label(handle)).collect();
    let mut labels: Vec<Label> = file.iter().map(|label| of_label(label, &names)).collect();
    // Prefixes before other separators count only where they are before half of the handles' names.
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for label in file {
        if let Some((prefix, _)) = split(label, |name| names.contains(name)) {
            *counts.entry(prefix.to_owned()).or_default() += 1;
        }
    }
    counts.retain(|_, count| *count >= 4 && 2 * *count >= names.len());
    if counts.is_empty() {
        return labels;
    }
    for (parts, label) in labels.iter_mut().zip(file) {
        let is_free = parts.subject.is_none() && !names.contains(&parts.name);
        if is_free {
            let at = label.char_indices().take(LONGEST_PREFIX).filter(|(_, c)| SOMETIMES.contains(c));
            let known = at.map(|(at, _)| at).find(|&at| counts.contains_key(&label[..at]));
            if let Some(at) = known {
                let name = label[at + 1..].trim().to_lowercase();
                *parts = Label { subject: Some(label[..at].to_owned()), name };
            }
        }
    }
    labels
}

/// A label whose separator is one of [`LABEL_SEPARATORS`], or which repeats a handle's name, such as
/// `jaw00#2`.
fn of_label(label: &str, names: &HashSet<String>) -> Label {
    let name = bare_label(label);
    if let Some((subject, _)) = label.split_once(LABEL_SEPARATORS)
        && !subject.trim().is_empty()
    {
        return Label { subject: Some(subject.trim().to_owned()), name };
    }
    if let Some((first, number)) = name.rsplit_once('#')
        && names.contains(first)
        && !names.contains(&name)
        && number.parse::<u32>().is_ok()
    {
        return Label { subject: Some(format!("#{number}")), name: first.to_owned() };
    }
    Label { subject: None, name }
}

/// The first prefix before one of [`SOMETIMES`] behind which there is a name that suits, and this name.
fn split(label: &str, suits: impl Fn(&str) -> bool) -> Option<(&str, String)> {
    let separators = label.char_indices().take(LONGEST_PREFIX).filter(|(_, c)| SOMETIMES.contains(c));
    for (at, _) in separators {
        let name = label[at + 1..].trim().to_lowercase();
        if at > 0 && suits(&name) {
            return Some((&label[..at], name));
        }
    }
    None
}

/// The subject whose markers are the handles'.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chosen {
    /// Its name; `None` where the markers have no prefix, or the file has but one prefix.
    pub subject: Option<String>,
    /// For each label of the file whether it belongs to another subject.
    pub is_anothers: Vec<bool>,
    /// What a person should know of the choice.
    pub warning: Option<String>,
}

/// The markers of one prefix.
struct Group<'a> {
    subject: Option<&'a str>,
    /// The handles whose names its labels have.
    handles: BTreeSet<usize>,
    /// How many of its labels are a handle's label, prefix and all.
    exact: usize,
}

/// Chooses among the subjects. `wanted` is the one to take. Without it, the subject of the labels in `mapped`
/// is taken, or the only one whose labels are the handles'.
///
/// # Errors
/// [`Error::Input`] if the file has no such subject, or if two subjects have the handles' labels.
pub(crate) fn choose(
    handles: &[String],
    file: &[String],
    labels: &[Label],
    wanted: Option<&str>,
    mapped: &BTreeSet<usize>,
) -> Result<Chosen> {
    let mut groups = groups(handles, file, labels);
    let all = Chosen { subject: None, is_anothers: vec![false; file.len()], warning: None };
    let of_map: BTreeSet<&str> = mapped.iter().filter_map(|&i| labels[i].subject.as_deref()).collect();
    let best = if let Some(wanted) = wanted {
        let is_wanted = |group: &Group| group.subject.is_some_and(|subject| is_called(subject, wanted));
        let place = groups.iter().position(is_wanted);
        place.ok_or_else(|| unknown(wanted, labels))?
    } else if of_map.len() == 1
        && let Some(place) = groups.iter().position(|group| group.subject.is_some_and(|s| of_map.contains(s)))
    {
        place
    } else {
        let count = |group: &Group| group.handles.len();
        let most = groups.iter().map(count).max().unwrap_or(0);
        // Labels that are the handles' own tell more than labels behind a prefix.
        let own = |group: &Group| group.exact > 0 && count(group) as f64 >= AS_GOOD * most as f64;
        let owners: Vec<usize> = (0..groups.len()).filter(|&i| own(&groups[i])).collect();
        let best = match owners[..] {
            [only] => Some(only),
            _ => groups.iter().position(|group| count(group) == most),
        };
        let Some(best) = best.filter(|_| most > 0) else { return Ok(all) };
        let is_rival = |group: &Group| {
            count(group) as f64 >= RIVAL * count(&groups[best]) as f64
                && !group.handles.is_disjoint(&groups[best].handles)
        };
        let rivals: Vec<&Group> = groups.iter().filter(|group| is_rival(group)).collect();
        if rivals.len() > 1 && owners.len() != 1 {
            return Err(ambiguous(rivals.iter().map(|group| (group.subject, group.handles.len()))));
        }
        best
    };
    let best = groups.remove(best);
    // Markers of another prefix may still be the same actor's, if no handle has two markers then.
    let mut handles = best.handles.clone();
    let mut others: Vec<(Option<&str>, usize)> = Vec::new();
    for group in &groups {
        // A prop has none of the handles' labels, and may be the actor's cap.
        let is_unwanted = wanted.is_some() && group.subject.is_some() && !group.handles.is_empty();
        if is_unwanted || !group.handles.is_disjoint(&handles) {
            others.push((group.subject, group.handles.len()));
        } else {
            handles.extend(&group.handles);
        }
    }
    let left_out: HashSet<Option<&str>> = others.iter().map(|(subject, _)| *subject).collect();
    let is_anothers = labels.iter().map(|label| left_out.contains(&label.subject.as_deref())).collect();
    others.retain(|(_, count)| *count >= 4);
    let warning = (!others.is_empty() && wanted.is_none()).then(|| {
        format!(
            "the take has markers of more than one subject, and those of {} are used; left out are those of \
             {}, which have the names of {} handles; name the subject to take another one",
            named(best.subject),
            listed_subjects(others.iter().copied()),
            others.iter().map(|(_, count)| *count).max().unwrap_or(0),
        )
    });
    let subject = best.subject.filter(|_| !groups.is_empty()).map(str::to_owned);
    Ok(Chosen { subject, is_anothers, warning })
}

/// The groups of the file in the order of their first labels.
fn groups<'a>(handles: &[String], file: &[String], labels: &'a [Label]) -> Vec<Group<'a>> {
    let mut by_name: HashMap<String, Vec<usize>> = HashMap::new();
    for (h, handle) in handles.iter().enumerate() {
        by_name.entry(bare_label(handle)).or_default().push(h);
    }
    let whole: HashSet<String> = handles.iter().map(|handle| handle.trim().to_lowercase()).collect();
    let mut places: HashMap<Option<&str>, usize> = HashMap::new();
    let mut groups: Vec<Group<'a>> = Vec::new();
    for (label, parts) in file.iter().zip(labels) {
        let subject = parts.subject.as_deref();
        let place = *places.entry(subject).or_insert_with(|| {
            groups.push(Group { subject, handles: BTreeSet::new(), exact: 0 });
            groups.len() - 1
        });
        groups[place].handles.extend(by_name.get(&parts.name).into_iter().flatten());
        groups[place].exact += usize::from(whole.contains(&label.trim().to_lowercase()));
    }
    groups
}

fn named(subject: Option<&str>) -> String {
    subject.map_or_else(|| "the markers without a prefix".to_owned(), quoted)
}

fn listed_subjects<'a>(subjects: impl Iterator<Item = (Option<&'a str>, usize)>) -> String {
    let names: Vec<String> = subjects.map(|(subject, _)| named(subject)).collect();
    const SHOWN: usize = 8;
    let more = names.len().saturating_sub(SHOWN);
    let shown = names[..names.len() - more].join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

/// An error about a subject that none of the `labels` has. It names those that there are.
pub(crate) fn unknown(wanted: &str, labels: &[Label]) -> Error {
    let mut known: Vec<&str> = Vec::new();
    for subject in labels.iter().filter_map(|label| label.subject.as_deref()) {
        if !known.contains(&subject) {
            known.push(subject);
        }
    }
    let known = if known.is_empty() { "no subject".to_owned() } else { listed(known.into_iter()) };
    Error::input(format!(
        "no subject of the take is called {}; it has {known}; a subject is what stands before the colon of \
         labels such as “Anna:chin”",
        quoted(wanted)
    ))
    .of_kind(InputErrorKind::UnknownName { name: wanted.to_owned() })
}

/// An error about subjects between which nothing decides, each with the number of its markers.
pub(crate) fn ambiguous<'a>(subjects: impl Iterator<Item = (Option<&'a str>, usize)>) -> Error {
    Error::conflict(format!(
        "markers of more than one subject may be the face's: {}; say which subject is meant",
        listed_subjects(subjects)
    ))
    .with_remedies(&[Remedy::ChooseSubject])
}

#[cfg(test)]
mod tests {
    use super::*;

    const HANDLES: [&str; 6] = ["jaw_l", "jaw_r", "brow", "lip", "nose", "chin"];

    fn strings(labels: &[&str]) -> Vec<String> {
        labels.iter().map(|label| (*label).to_owned()).collect()
    }

    fn with(prefix: &str) -> Vec<String> {
        HANDLES.iter().map(|handle| format!("{prefix}{handle}")).collect()
    }

    fn chosen(file: &[String], wanted: Option<&str>) -> Result<Chosen> {
        let handles = strings(&HANDLES);
        choose(&handles, file, &parted(&handles, file), wanted, &BTreeSet::new())
    }

    #[test]
    fn prefixes_with_each_separator() {
        for separator in [":", "|", "_", ".", "-", " ", "/"] {
            let mut file = [with(&format!("Anna{separator}")), with(&format!("Ben{separator}"))].concat();
            file.push(format!("Ben{separator}cap"));
            let error = chosen(&file, None).unwrap_err();
            assert!(error.to_string().contains("\"Anna\", \"Ben\""), "{error}");
            for (wanted, first) in [("Anna", 0), ("ben", 6), ("Ben:", 6)] {
                let found = chosen(&file, Some(wanted)).unwrap();
                let mine: Vec<usize> = (0..12).filter(|&i| !found.is_anothers[i]).collect();
                assert_eq!(mine, (first..first + 6).collect::<Vec<_>>(), "{separator}");
                assert_eq!(found.is_anothers[12], first == 0, "{separator}");
                assert!(found.warning.is_none());
            }
            let error = chosen(&file, Some("Carl")).unwrap_err();
            assert!(error.to_string().contains("it has \"Anna\", \"Ben\""), "{error}");
        }
    }

    #[test]
    fn names_with_a_separator_have_no_prefix() {
        let file = strings(&["left_brow", "right_brow", "jaw_l", "jaw_r", "nose", "lip", "chin"]);
        let parts = parted(&strings(&HANDLES), &file);
        assert!(parts.iter().all(|parts| parts.subject.is_none()), "{parts:?}");
    }

    #[test]
    fn the_rigs_own_labels_come_before_those_behind_a_prefix() {
        let file = [with("Ben:"), with("")].concat();
        let found = chosen(&file, None).unwrap();
        assert_eq!(found.is_anothers, [[true; 6], [false; 6]].concat());
        assert!(found.warning.unwrap().contains("left out are those of \"Ben\""));
    }

    #[test]
    fn one_actor_with_several_prefixes_is_whole() {
        let file = strings(&["Face:jaw_l", "Face:jaw_r", "BROW", "Face:lip", "Nose:nose", "chin", "Cap:a"]);
        let found = chosen(&file, None).unwrap();
        assert_eq!((found.is_anothers, found.warning), (vec![false; 7], None));
    }

    #[test]
    fn another_actor_with_a_few_of_the_labels_is_left_out() {
        let mut file = with("Anna:");
        file.extend(strings(&["Ben:lip", "Ben:nose", "Ben:elbow"]));
        let found = chosen(&file, None).unwrap();
        assert_eq!(found.subject.as_deref(), Some("Anna"));
        assert_eq!(found.is_anothers[6..], [true; 3]);
    }

    #[test]
    fn labels_that_repeat_are_another_subjects() {
        let mut file = with("");
        file.extend(HANDLES.iter().map(|handle| format!("{handle}#2")));
        let found = chosen(&file, None).unwrap();
        assert_eq!(found.is_anothers, [[false; 6], [true; 6]].concat());
        assert!(found.warning.unwrap().contains("\"#2\""));
        assert_eq!(chosen(&file, Some("#2")).unwrap().is_anothers, [[true; 6], [false; 6]].concat());
    }

    #[test]
    fn a_map_says_which_subject_is_meant() {
        let file = [with("Anna:"), with("Ben:")].concat();
        let handles = strings(&HANDLES);
        let parts = parted(&handles, &file);
        let found = choose(&handles, &file, &parts, None, &BTreeSet::from([7])).unwrap();
        assert_eq!(found.is_anothers, [[true; 6], [false; 6]].concat());
    }
}
