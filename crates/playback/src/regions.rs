//! Regions of a face by the names of its handles, and gains of the wrinkles in them.

use crate::fade::of_vertices;
use rhytid_core::{Error, InputErrorKind, Result, Rig};

/// Regions, each with the words in a label that stand for it. The first region that matches counts.
const WORDS: [(&str, &[&str]); 10] = [
    ("brows", &["brow", "corrugator"]),
    ("lids", &["lid", "eye", "canthus", "orbit"]),
    ("nose", &["nose", "nostril", "nasal", "nasion", "alar", "columella"]),
    ("cheeks", &["cheek", "zygom", "malar", "nasolabial", "buccal"]),
    ("lips", &["lip", "mouth", "cupid", "philtrum", "commissure"]),
    ("chin", &["chin", "mentalis", "menton"]),
    ("jaw", &["jaw", "mandib", "gonion"]),
    ("forehead", &["forehead", "frontal", "glabella"]),
    ("ears", &["ear_", "tragus"]),
    ("neck", &["neck", "throat"]),
];

/// The 68 landmarks of Multi-PIE and iBUG by their numbers, which labels such as `mp36` contain.
const LANDMARKS: [(&str, std::ops::Range<u32>); 5] =
    [("jaw", 0..17), ("brows", 17..27), ("nose", 27..36), ("lids", 36..48), ("lips", 48..68)];

/// The region that a handle's label names, such as `brows` of `brow_l`, `LeftEyebrow3` or `mp20`.
pub fn region_of(label: &str) -> Option<&'static str> {
    let lower = label.to_lowercase();
    let by_word = WORDS.iter().find(|(_, words)| words.iter().any(|word| lower.contains(word)));
    let number = || lower.strip_prefix("mp")?.parse::<u32>().ok();
    let by_number = || number().and_then(|n| LANDMARKS.iter().find(|(_, range)| range.contains(&n)));
    by_word.map(|(name, _)| *name).or_else(|| by_number().map(|(name, _)| *name))
}

/// The rig with its wrinkles multiplied by `gains`, each of a handle or a region.
///
/// A gain is a ratio. The gain of a handle counts before that of its region. The gain of a vertex is the mean
/// of those of the handles that drive its wrinkles.
///
/// # Errors
/// [`Error::Input`] if a name is neither that of a handle nor that of a region with a handle in it. Otherwise
/// the errors of [`Rig::scale_wrinkles`].
pub fn scale_wrinkles(rig: Rig, gains: &[(String, f64)]) -> Result<Rig> {
    let gains = handle_gains(&rig.handles().labels, gains)?;
    let beyond: Vec<f64> = gains.iter().map(|gain| gain - 1.0).collect();
    let beyond = of_vertices(&rig, &beyond);
    rig.scale_wrinkles(|v| 1.0 + f64::from(beyond[v]))
}

/// Checks that each name of `gains` is that of a handle, or of a region with a handle in it.
///
/// # Errors
/// As [`scale_wrinkles`].
pub fn check_gains(labels: &[String], gains: &[(String, f64)]) -> Result<()> {
    handle_gains(labels, gains).map(|_| ())
}

/// The gain of each handle: the handle's own in `gains`, else its region's, else 1.
fn handle_gains(labels: &[String], gains: &[(String, f64)]) -> Result<Vec<f64>> {
    for (name, _) in gains {
        if !labels.iter().any(|label| label == name || region_of(label) == Some(name)) {
            let mut regions: Vec<&str> = labels.iter().filter_map(|label| region_of(label)).collect();
            regions.sort_unstable();
            regions.dedup();
            return Err(Error::input(format!(
                "“{name}” is neither a handle of the rig nor a region of its handles; the regions in the \
                 names of handles are {}",
                if regions.is_empty() { "none".to_owned() } else { regions.join(", ") }
            ))
            .of_kind(InputErrorKind::UnknownName { name: name.clone() }));
        }
    }
    let gain = |label: &String| {
        let of = |is: &dyn Fn(&str) -> bool| gains.iter().find(|(name, _)| is(name)).map(|(_, gain)| *gain);
        of(&|name| name == label).or_else(|| of(&|name| region_of(label) == Some(name))).unwrap_or(1.0)
    };
    Ok(labels.iter().map(gain).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_name_regions() {
        for (label, expected) in [
            ("brow_l", Some("brows")),
            ("LeftEyebrow3", Some("brows")),
            ("UpperLid", Some("lids")),
            ("eye.R", Some("lids")),
            ("lip-corner", Some("lips")),
            ("Chin", Some("chin")),
            ("jaw07", Some("jaw")),
            ("mp16", Some("jaw")),
            ("mp17", Some("brows")),
            ("mp35", Some("nose")),
            ("mp36", Some("lids")),
            ("mp67", Some("lips")),
            ("mp68", None),
            ("mp", None),
            ("fps12", None),
            ("M7", None),
        ] {
            assert_eq!(region_of(label), expected, "{label}");
        }
    }

    #[test]
    fn a_handles_own_gain_wins_over_its_regions() {
        let labels = ["brow_l", "brow_r", "chin", "M7"].map(str::to_owned);
        let gains = |gains: &[(&str, f64)]| {
            let gains: Vec<(String, f64)> =
                gains.iter().map(|(name, gain)| ((*name).to_owned(), *gain)).collect();
            handle_gains(&labels, &gains)
        };
        assert_eq!(gains(&[("brows", 0.5), ("brow_r", 1.5), ("M7", 0.0)]).unwrap(), [0.5, 1.5, 1.0, 0.0]);
        assert_eq!(gains(&[]).unwrap(), [1.0; 4]);
        let message = gains(&[("lips", 0.5)]).unwrap_err().to_string();
        assert!(message.contains("“lips” is neither") && message.contains("are brows, chin"), "{message}");
    }
}
