//! What a marker's label says about its place: on the head, on a side, above or below.

use rhytid_core::text::{LABEL_SEPARATORS, bare_label};

/// Words for what is worn on the head.
const WORN: [&str; 5] = ["head", "cap", "helmet", "band", "hat"];

/// Whether a label says that its marker is on a cap or a head band: `Head_L`, `Anna:head1`, `Headband:7`. An
/// actor may be called Hattie, so the prefix must end with such a word.
pub(crate) fn says_head(label: &str) -> bool {
    let name = bare_label(label).replace(['_', '-', ' ', '.'], "");
    if WORN.iter().any(|word| name.starts_with(word) || name.ends_with(word)) {
        return !name.contains("forehead");
    }
    let is_worn = |part: &str| WORN.iter().any(|word| part.ends_with(word));
    let digits = |c: char| c.is_ascii_digit() || c == ' ' || c == '_';
    let mut prefixes = label.split(LABEL_SEPARATORS).rev().skip(1);
    prefixes.any(|part| is_worn(part.to_lowercase().trim_end_matches(digits))) && says_nothing_else(&name)
}

/// Whether a name behind a prefix is a number, or a word such as `Marker 3`.
fn says_nothing_else(name: &str) -> bool {
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    ["", "m", "mk", "mkr", "marker"].contains(&word)
}

/// Whether a label says left (true) or right: `brow_l`, `LeftBrow`, `R_Cheek`, `lip.R`, `LBROW1`. The actor
/// before a colon does not matter.
pub(crate) fn says_left(label: &str) -> Option<bool> {
    let lower = bare_label(label);
    for (word, left) in [("left", true), ("right", false)] {
        if lower.contains(word) {
            return Some(left);
        }
    }
    let parts: Vec<&str> = lower.split(['_', '.', '-', ' ']).collect();
    if parts.len() > 1 {
        for part in [parts[0], parts[parts.len() - 1]] {
            match part {
                "l" => return Some(true),
                "r" => return Some(false),
                _ => {}
            }
        }
    }
    // A letter before or behind a word of the face: LBRO1, RightLip's short form RLIP2, BrowL.
    let word = parts[parts.len() - 1].trim_end_matches(|letter: char| letter.is_ascii_digit());
    for (letter, left) in [('l', true), ('r', false)] {
        let rest = [word.strip_prefix(letter), word.strip_suffix(letter)];
        if rest.into_iter().flatten().any(|rest| PLACES.contains(&rest)) {
            return Some(left);
        }
    }
    None
}

/// Words of the face that stand beside a letter for the side.
const PLACES: [&str; 17] = [
    "brow", "bro", "eyebrow", "lid", "eye", "eyelid", "cheek", "chk", "lip", "mouth", "mth", "jaw", "chin",
    "nose", "nostril", "forehead", "temple",
];

/// Whether a label names a place above the nose (true) or below it: `brow_l`, `forehead`, `chin`, `LowerLip`.
pub(crate) fn says_above(label: &str) -> Option<bool> {
    const ABOVE: [&str; 4] = ["brow", "forehead", "eyelid", "temple"];
    const BELOW: [&str; 4] = ["chin", "jaw", "lip", "mouth"];
    let name = bare_label(label);
    let says = |words: [&str; 4]| words.iter().any(|word| name.contains(word));
    match (says(ABOVE), says(BELOW)) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_say_their_side() {
        for (label, expected) in [
            ("brow_l", Some(true)),
            ("R_Cheek", Some(false)),
            ("LeftBrow3", Some(true)),
            ("lip.R", Some(false)),
            ("actor:jaw-right", Some(false)),
            ("LBROW1", Some(true)),
            ("Anna:RLip2", Some(false)),
            ("cheekR", Some(false)),
            ("mp30", None),
            ("lip", None),
            ("l", None),
            ("R12", None),
            ("Wright:mp30", None),
            ("R:brow_l", Some(true)),
        ] {
            assert_eq!(says_left(label), expected, "{label}");
        }
    }

    #[test]
    fn labels_say_what_is_on_the_head() {
        for label in ["head0", "Head_L", "HAT", "anna:cap", "headband2", "Anna:Head_L", "Anna|headband 3"]
            .into_iter()
            .chain(["Headband:Marker 1", "Anna:Cap2:7", "Hattie:head_1"])
        {
            assert!(says_head(label), "{label}");
        }
        for label in
            ["forehead_l", "brow", "LeftCheek", "Fore-Head", "Hattie:brow", "Captain:m7", "Anna_Head:jaw_l"]
        {
            assert!(!says_head(label), "{label}");
        }
    }

    #[test]
    fn labels_say_their_height() {
        for (label, expected) in [
            ("brow_l", Some(true)),
            ("LowerLip", Some(false)),
            ("UpperLip2", Some(false)),
            ("CHIN", Some(false)),
            ("nose", None),
            ("m12", None),
            ("Philip:m12", None),
        ] {
            assert_eq!(says_above(label), expected, "{label}");
        }
    }
}
