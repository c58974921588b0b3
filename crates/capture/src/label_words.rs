//! What a marker's label says about its place: on the head, on a side, above or below.

/// Whether a label says that its marker is on a cap or a head band.
pub(crate) fn says_head(label: &str) -> bool {
    let lower = label.to_lowercase();
    let words = ["head", "cap", "helmet", "band", "hat"];
    !lower.contains("forehead") && words.iter().any(|word| lower.starts_with(word) || lower.ends_with(word))
}

/// Whether a label says left (true) or right: `brow_l`, `LeftBrow`, `R_Cheek`, `lip.R`, `LBROW1`.
pub(crate) fn says_left(label: &str) -> Option<bool> {
    let lower = label.to_lowercase();
    for (word, left) in [("left", true), ("right", false)] {
        if lower.contains(word) {
            return Some(left);
        }
    }
    let parts: Vec<&str> = label.split(['_', '.', '-', ' ', ':']).collect();
    if parts.len() > 1 {
        for part in [parts[0], parts[parts.len() - 1]] {
            match part {
                "l" | "L" => return Some(true),
                "r" | "R" => return Some(false),
                _ => {}
            }
        }
    }
    // A letter before or behind a word of the face: LBRO1, RightLip's short form RLIP2, BrowL.
    let bare = parts[parts.len() - 1].trim_end_matches(|letter: char| letter.is_ascii_digit());
    let lower = bare.to_lowercase();
    for (letter, left) in [('l', true), ('r', false)] {
        let rest = [lower.strip_prefix(letter), lower.strip_suffix(letter)];
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
    let lower = label.to_lowercase();
    let says = |words: [&str; 4]| words.iter().any(|word| lower.contains(word));
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
        ] {
            assert_eq!(says_left(label), expected, "{label}");
        }
    }

    #[test]
    fn labels_say_what_is_on_the_head() {
        let says = ["head0", "Head_L", "HAT", "anna:cap", "headband2"].map(says_head);
        assert_eq!(says, [true; 5]);
        assert_eq!(["forehead_l", "brow", "LeftCheek"].map(says_head), [false; 3]);
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
        ] {
            assert_eq!(says_above(label), expected, "{label}");
        }
    }
}
