//! Time codes in words, as files have them.
use rhytid_core::Timecode;

/// `01:02:03:04`, with `;` or `.` before the frames if numbers are dropped, and perhaps `.2` for subframes.
pub(super) fn parse(text: &str) -> Option<Timecode> {
    let text = text.trim();
    let numbers: Option<Vec<u32>> =
        text.split([':', ';', '.']).map(|number| number.trim().parse().ok()).collect();
    let (hours, minutes, seconds, frames, subframes) = match numbers?[..] {
        [hours, minutes, seconds, frames] => (hours, minutes, seconds, frames, 0),
        [hours, minutes, seconds, frames, subframes] => (hours, minutes, seconds, frames, subframes),
        _ => return None,
    };
    let drop_frame = text.contains(';');
    let timecode = Timecode { hours, minutes, seconds, frames, subframes, rate: None, drop_frame };
    (text.contains(':') && is_sound(&timecode)).then_some(timecode)
}

/// Whether hours, minutes and seconds are in their ranges.
pub(super) fn is_sound(timecode: &Timecode) -> bool {
    timecode.hours < 100 && timecode.minutes < 60 && timecode.seconds < 60
}

/// The rates that a time code may have, in frames per second. Other numbers are codes of a standard.
const RATES: std::ops::RangeInclusive<f64> = 10.0..=240.0;

/// Whether a number is fit to be the frames of a time code in a second.
pub(super) fn is_rate(rate: f64) -> bool {
    RATES.contains(&rate)
}

/// Frames per second in the name of a standard, such as “NTSC drop”, “PAL”, “Film” or “30 fps”.
pub(super) fn rate(standard: &str) -> Option<f64> {
    let standard = standard.to_ascii_lowercase();
    let words = standard.split(|c: char| !c.is_ascii_digit() && c != '.');
    let number = words.filter_map(|word| word.parse::<f64>().ok()).find(|&rate| is_rate(rate));
    let by_name = || {
        let known =
            [("ntsc", 30000.0 / 1001.0), ("pal", 25.0), ("ebu", 25.0), ("film", 24.0), ("smpte", 30.0)];
        known.into_iter().find(|(name, _)| standard.contains(name)).map(|(_, rate)| rate)
    };
    number.or_else(by_name)
}

/// Whether the name of a standard says that numbers are dropped.
pub(super) fn drops(standard: &str) -> bool {
    let standard = standard.to_ascii_lowercase();
    standard.contains("drop") && !standard.contains("non") && !standard.contains("no drop")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_codes_in_words() {
        let said = |text: &str| parse(text).map(|timecode| timecode.to_string());
        for text in ["01:02:03:04", "01:02:03;04", "23:59:59:29.3", "01:02:03;04.1"] {
            assert_eq!(said(text).as_deref(), Some(text));
        }
        assert_eq!(said(" 1:2:3:4 ").as_deref(), Some("01:02:03:04"));
        for text in ["", "1:2:3", "1:60:3:4", "1.2.3.4", "a:b:c:d", "1:2:3:4:5:6", "-1:2:3:4"] {
            assert_eq!(said(text), None, "{text}");
        }
    }

    #[test]
    fn standards_by_their_names() {
        for (standard, expected) in [
            ("NTSC drop", Some(30000.0 / 1001.0)),
            ("PAL", Some(25.0)),
            ("SMPTE 29.97 fps", Some(29.97)),
            ("Film 24", Some(24.0)),
            ("SMPTE", Some(30.0)),
            ("?", None),
        ] {
            assert_eq!(rate(standard), expected, "{standard}");
        }
        assert!(drops("30 drop") && !drops("30 non-drop") && !drops("PAL"));
    }
}
