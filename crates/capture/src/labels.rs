//! Labels: which marker of a file belongs to which handle.
use crate::settings::Settings;
use crate::subjects::{choose, parted};
use rhytid_core::text::bare_label;
use rhytid_core::{Error, InputErrorKind, Result};
use std::collections::{BTreeMap, BTreeSet};

/// The columns of a file, matched with the handles.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Matched {
    /// The column of each handle's marker; `None` where the file has none.
    pub columns: Vec<Option<usize>>,
    /// The columns that belong to no handle, and may be on the actor's head.
    pub others: Vec<usize>,
    /// The columns that are not used: those of other subjects.
    pub left_out: Vec<usize>,
    /// The subject whose markers are used, where the file has more than one.
    pub subject: Option<String>,
    /// What a person should know of the choice of the subject.
    pub warning: Option<String>,
}

/// Whether a label is one that a capture system gives to a point without a name: `*7`, `Unlabeled1`, `U_1`,
/// `New 0001`, `uname*12`, or `#3`, which a reader gives to an empty label. Such a label names another point
/// from one stretch of a take to the next. The prefix of a subject does not matter.
pub fn is_unlabelled(label: &str) -> bool {
    let name = bare_label(label);
    let name = without_repeat(&name);
    let stem = name.trim_end_matches('#').trim_end_matches(|c: char| c.is_ascii_digit());
    let is_numbered = stem.len() < name.len();
    let word = stem.trim_end_matches([' ', '_', '-', '*', '.']);
    match word {
        // A plain number may be the name that somebody gave to a marker.
        "" => !stem.is_empty() || name.is_empty(),
        "#" => is_numbered,
        "u" => is_numbered && stem == "u_",
        "new" | "uname" => is_numbered && stem != word,
        "unlabeled" | "unlabelled" | "unnamed" | "unidentified" | "unknown" => true,
        _ => false,
    }
}

/// A name without the number that a reader adds to one that comes twice, such as `#2` in `unlabeled#2`.
fn without_repeat(name: &str) -> &str {
    match name.rsplit_once('#') {
        Some((first, number)) if !first.is_empty() && number.parse::<u32>().is_ok() => first,
        _ => name,
    }
}

/// With fewer matched handles the alignment would be undetermined.
const FEWEST: usize = 4;

/// Finds each of the `handles` among the labels of a `file`. Four rules apply in order, and `map` (handle →
/// label in the file) is the first. Then come the same label, the same label in another case, and the same
/// label behind a prefix such as `Actor:`. Apart from the map, labels of other subjects than `subject` do not
/// count. `None` takes the only subject whose labels are the handles'.
///
/// # Errors
/// [`Error::Input`] if `map` names an unknown handle or label, if the file has no such subject, or if two
/// subjects have the handles' labels.
pub fn same_names(
    handles: &[String],
    file: &[String],
    map: &BTreeMap<String, String>,
    subject: Option<&str>,
) -> Result<Vec<Option<usize>>> {
    Ok(matched(handles, file, map, subject)?.columns)
}

fn matched(
    handles: &[String],
    file: &[String],
    map: &BTreeMap<String, String>,
    subject: Option<&str>,
) -> Result<Matched> {
    for (handle, label) in map {
        if !handles.contains(handle) {
            return Err(Error::input(format!(
                "the map gives the handle “{handle}” a marker, but the rig has no such handle"
            ))
            .of_kind(InputErrorKind::UnknownMarkers { labels: vec![handle.clone()] }));
        }
        if !file.contains(label) {
            return Err(Error::input(format!(
                "the map gives the handle “{handle}” the marker “{label}”, but the file has no such marker"
            ))
            .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.clone()] }));
        }
    }
    let labels = parted(handles, file);
    let mapped: BTreeSet<usize> =
        map.values().filter_map(|label| file.iter().position(|known| known == label)).collect();
    let chosen = choose(handles, file, &labels, subject, &mapped)?;
    let mut taken = chosen.is_anothers.clone();
    let mut columns: Vec<Option<usize>> = vec![None; handles.len()];
    for (handle, column) in handles.iter().zip(&mut columns) {
        *column = map.get(handle).and_then(|label| file.iter().position(|known| known == label));
        column.iter().for_each(|&i| taken[i] = true);
    }
    let mut take = |fits: &dyn Fn(&str, usize) -> bool| {
        for (handle, column) in handles.iter().zip(&mut columns).filter(|(_, column)| column.is_none()) {
            *column = (0..file.len()).find(|&i| !taken[i] && fits(handle, i));
            column.iter().for_each(|&i| taken[i] = true);
        }
    };
    take(&|handle, i| handle == file[i]);
    take(&|handle, i| handle.to_lowercase() == file[i].trim().to_lowercase());
    take(&|handle, i| bare_label(handle) == labels[i].name);
    let used: BTreeSet<usize> = columns.iter().copied().flatten().collect();
    let free = (0..file.len()).filter(|i| !used.contains(i));
    let (left_out, others) = free.partition(|&i| chosen.is_anothers[i]);
    Ok(Matched { columns, others, left_out, subject: chosen.subject, warning: chosen.warning })
}

/// The columns of [`same_names`], if at least four handles have one.
///
/// # Errors
/// As [`same_names`], or if fewer than four handles are found.
pub(crate) fn match_labels(handles: &[String], file: &[String], settings: &Settings) -> Result<Matched> {
    let matched = matched(handles, file, &settings.markers, settings.subject.as_deref())?;
    let found = matched.columns.iter().flatten().count();
    if found < FEWEST {
        let shown = |labels: &[String]| {
            let more = labels.len().saturating_sub(8);
            let shown: Vec<&str> = labels.iter().take(8).map(String::as_str).collect();
            shown.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
        };
        let without = handles.iter().zip(&matched.columns).filter(|(_, column)| column.is_none());
        let labels = without.map(|(handle, _)| handle.clone()).collect();
        return Err(Error::input(format!(
            "{found} of the rig's {} handles have a marker of that name, expected at least {FEWEST}; the \
             handles are {}, the markers {}; give a map of handles to markers",
            handles.len(),
            shown(handles),
            shown(file)
        ))
        .of_kind(InputErrorKind::MissingMarkers { labels }));
    }
    Ok(matched)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(names: &[&str]) -> Vec<String> {
        names.iter().map(|n| (*n).to_owned()).collect()
    }

    #[test]
    fn labels_of_points_without_a_name() {
        for label in [
            "*7",
            "Anna:*12",
            "Unlabeled1",
            "Unlabeled_1234",
            "unlabelled 3",
            "U_1",
            "New 0001",
            "new_12",
            "uname*12",
            "#3",
            "#2#",
            "Unnamed",
            "Unidentified 4",
            "Unlabeled#2",
            "*7#3",
            "",
        ] {
            assert!(is_unlabelled(label), "{label}");
        }
        for label in [
            "M12",
            "M0012",
            "12",
            "U1",
            "New1",
            "u",
            "jaw00#2",
            "newest_1",
            "lip_u_1",
            "unlabeled_lip",
            "New",
        ] {
            assert!(!is_unlabelled(label), "{label}");
        }
    }

    #[test]
    fn each_rule_and_their_order() {
        let handles = labels(&["jaw", "Lip", "brow", "nose", "chin", "ear"]);
        let file = labels(&["Actor:jaw", "jaw", "lip", "Anna:Head:Brow", "NOSE", "m7", "cap"]);
        let map = BTreeMap::from([("chin".to_owned(), "m7".to_owned())]);
        let settings = Settings { markers: map, ..Settings::default() };
        let found = match_labels(&handles, &file, &settings).unwrap();
        assert_eq!(found.columns, [Some(1), Some(2), Some(3), Some(4), Some(5), None]);
        // Another actor has the same label.
        assert_eq!((found.others, found.left_out), (vec![6], vec![0]));
    }

    #[test]
    fn too_few_and_wrong_maps() {
        let handles = labels(&["a", "b", "c", "d"]);
        let refused = |file: &[&str], map: &[(&str, &str)], words: &str| {
            let markers = map.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
            let settings = Settings { markers, ..Settings::default() };
            let error = match_labels(&handles, &labels(file), &settings).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
            error.input_kind().unwrap().clone()
        };
        let unknown = InputErrorKind::UnknownMarkers { labels: labels(&["q"]) };
        assert_eq!(refused(&["a"], &[("q", "a")], "no such handle"), unknown);
        assert_eq!(refused(&["a"], &[("a", "q")], "no such marker"), unknown);
        let missing = InputErrorKind::MissingMarkers { labels: labels(&["d"]) };
        assert_eq!(refused(&["a", "b", "c", "x"], &[], "3 of the rig's 4 handles"), missing);
    }
}
