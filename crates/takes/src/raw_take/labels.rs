//! Labels as files have them: in any encoding, missing, or more than once.
use rhytid_core::text::listed;
use std::collections::{HashMap, HashSet};

/// The text of a label or a value: UTF-8, or else Latin-1. The blanks and zeros that pad it are removed.
pub(super) fn text(bytes: &[u8]) -> String {
    let padding = |c: char| c.is_whitespace() || c == '\0';
    match std::str::from_utf8(bytes) {
        Ok(text) => text.trim_matches(padding).to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect::<String>().trim_matches(padding).to_owned(),
    }
}

/// Makes labels distinct: the second `a` becomes `a#2`, and an empty label in place k, from 1, becomes `#k`.
pub(super) fn distinct(labels: Vec<String>, warnings: &mut Vec<String>) -> Vec<String> {
    let mut taken: HashSet<String> = labels.iter().filter(|label| !label.is_empty()).cloned().collect();
    // How often each label has come.
    let mut times: HashMap<String, usize> = HashMap::new();
    let (mut nameless, mut repeated) = (Vec::new(), Vec::new());
    let mut out = Vec::with_capacity(labels.len());
    for (place, label) in labels.into_iter().enumerate() {
        if label.is_empty() {
            let mut name = format!("#{}", place + 1);
            while !taken.insert(name.clone()) {
                name.push('#');
            }
            nameless.push(name.clone());
            out.push(name);
            continue;
        }
        let count = times.entry(label.clone()).or_insert(0);
        *count += 1;
        if *count == 1 {
            out.push(label);
            continue;
        }
        let mut name = format!("{label}#{count}");
        while !taken.insert(name.clone()) {
            *count += 1;
            name = format!("{label}#{count}");
        }
        repeated.push(name.clone());
        out.push(name);
    }
    let mut warn = |names: &[String], what: &str| {
        if !names.is_empty() {
            let names_listed = listed(names.iter().map(String::as_str));
            warnings.push(format!("{} of {} {what}: {names_listed}", names.len(), out.len()));
        }
    };
    warn(&nameless, "markers have no label and are named after their position in the file");
    warn(&repeated, "markers repeat the label of an earlier marker and get a number after it");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(labels: &[&str]) -> (Vec<String>, Vec<String>) {
        let mut warnings = Vec::new();
        let out = distinct(labels.iter().map(|&label| label.to_owned()).collect(), &mut warnings);
        (out, warnings)
    }

    #[test]
    fn labels_become_distinct_and_each_kind_of_change_is_one_warning() {
        assert_eq!(named(&["a", "b"]), (vec!["a".into(), "b".into()], vec![]));
        let (labels, warnings) = named(&["a", "", "a", "a#2", "a", "", "#2"]);
        assert_eq!(labels, ["a", "#2#", "a#3", "a#2", "a#4", "#6", "#2"]);
        assert_eq!(
            warnings,
            [
                "2 of 7 markers have no label and are named after their position in the file: \"#2#\", \"#6\"",
                "2 of 7 markers repeat the label of an earlier marker and get a number after it: \"a#3\", \"a#4\"",
            ]
        );
    }

    #[test]
    fn many_equal_labels_take_no_quadratic_time() {
        let labels = vec!["x"; 300_000];
        assert_eq!(named(&labels).0[299_999], "x#300000");
    }

    #[test]
    fn text_is_utf_8_or_latin_1_without_its_padding() {
        assert_eq!(text(b" jaw00  \0\0"), "jaw00");
        assert_eq!(text("Zähne ".as_bytes()), "Zähne");
        assert_eq!(text(b"Z\xE4hne"), "Zähne");
    }
}
