//! The flags and commands of this program that remedy an error or a warning of the library. The library's
//! sentences name none.

use rhytid::core::{Remedy, Warning};
use rhytid::{DeviceErrorKind, Error};

/// An error's sentence, followed by the remedy in this program.
pub(crate) fn of_error(error: &Error) -> String {
    let remedies = match error {
        Error::Input(input) => input.remedies(),
        Error::Device { kind: DeviceErrorKind::OutOfMemory | DeviceErrorKind::Lost, .. } => {
            &[Remedy::ListDevices]
        }
        _ => &[],
    };
    with(error.to_string(), remedies)
}

/// A warning's sentence, followed by the remedy in this program.
pub fn of_warning(warning: &Warning) -> String {
    with(warning.to_string(), warning.remedies())
}

fn with(sentence: String, remedies: &[Remedy]) -> String {
    let known: Vec<&str> = remedies.iter().filter_map(|remedy| words(*remedy)).collect();
    if known.is_empty() { sentence } else { format!("{sentence} (see {})", known.join(", ")) }
}

fn words(remedy: Remedy) -> Option<&'static str> {
    Some(match remedy {
        Remedy::MostPixels => "--max-pixels",
        Remedy::AllowElsewhere => "--allow-elsewhere",
        Remedy::HoldMissing => "--missing hold",
        Remedy::GiveRate => "--take-rate N, or --rate N of `rhytid handles` and `rhytid prepare`",
        Remedy::GiveTakeSpace => "--take-unit UNIT, --take-axes AXES",
        Remedy::CleanAsWorld => "`rhytid prepare TAKE --rig RIG --world -o clean.csv`",
        Remedy::SoftMarkers => "--soft-markers",
        Remedy::GiveShapes => "--shapes SHAPES",
        Remedy::FewerFrames => "--frames A..B",
        Remedy::Compress => "--compressed",
        Remedy::LargerError => "--max-error",
        Remedy::Quantize => "--quantize",
        Remedy::DoNotQuantize => "--quantize, which is to be left out",
        Remedy::Meshopt => "--meshopt",
        Remedy::MostTargets => "--targets N",
        Remedy::Force => "--force",
        Remedy::NoShapes => "--shapes, which is to be left out",
        Remedy::FewShapes => "--shapes N",
        Remedy::ChooseClip => "--clip NAME",
        Remedy::OneRate => "--fps N",
        Remedy::DropHead => "--head drop",
        Remedy::NoRefinement => "--refine, which is to be left out",
        Remedy::Examine => "`rhytid doctor`",
        Remedy::Conform => "`rhytid conform`",
        Remedy::ListDevices => "`rhytid devices`",
        Remedy::KeepSlides => "--skip slides",
        Remedy::DropStretch => "--drop",
        Remedy::ChooseSubject => "--subject NAME, or `subject` in the setup",
        Remedy::KeepImplausible => "--force",
        Remedy::GiveNeutral => "--neutral A..B",
        Remedy::MarkerTable => {
            "`rhytid prepare --write-markers TABLE.csv`, which writes the table, and --markers TABLE.csv, \
             which reads it"
        }
        Remedy::WriteFrame => "`rhytid correct`, which writes the mesh of a frame",
        // A warning without a remedy in this program.
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_remedy_has_words_that_name_a_flag_or_a_command() {
        for remedy in Remedy::ALL {
            let words = words(remedy).unwrap_or_default();
            assert!(words.contains("--") || words.contains("`rhytid "), "{remedy:?}: {words:?}");
        }
    }

    #[test]
    fn a_sentence_is_followed_by_its_remedies() {
        let error =
            Error::too_large("out.glb: is too large").with_remedies(&[Remedy::Compress, Remedy::Force]);
        assert_eq!(of_error(&error), "out.glb: is too large (see --compressed, --force)");
        assert_eq!(of_error(&error.in_file("a")), "a: out.glb: is too large (see --compressed, --force)");
        assert_eq!(of_error(&Error::input("nothing helps")), "nothing helps");
        let lost =
            Error::Device { kind: DeviceErrorKind::Lost, device: "cpu:0".into(), message: "gone".into() };
        assert_eq!(of_error(&lost), "cpu:0: gone (see `rhytid devices`)");
        let warning = Warning::from("look".to_owned()).with_remedies(&[Remedy::Conform]);
        assert_eq!(of_warning(&warning), "look (see `rhytid conform`)");
    }
}
